//! An order of points in space in which neighbours stay near each other.

use glam::Vec3;
use rayon::prelude::*;

/// Bits of one coordinate.
const BITS: u32 = 16;

/// Indices of `points` along a Hilbert curve through their bounds: every run of them is a compact cluster.
///
/// Source: [Skilling04].
pub(crate) fn order(points: &[Vec3]) -> Vec<u32> {
    let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = (high - low).max_element();
    let scale = if size > 0.0 { ((1 << BITS) - 1) as f32 / size } else { 0.0 };
    let key = |p: &Vec3| key(((*p - low) * scale).to_array().map(|x| x as u32));
    let mut keyed: Vec<_> = points.par_iter().enumerate().map(|(index, p)| (key(p), index as u32)).collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Position along the curve of a cell of the grid.
fn key(mut x: [u32; 3]) -> u64 {
    for q in (1..BITS).rev().map(|bit| 1 << bit) {
        for i in 0..3 {
            let swap = if x[i] & q != 0 { 0 } else { (x[0] ^ x[i]) & (q - 1) };
            x[0] ^= if x[i] & q != 0 { q - 1 } else { swap };
            x[i] ^= swap;
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let flip = (1..BITS).filter(|bit| x[2] >> bit & 1 != 0).fold(0, |flip, bit| flip ^ ((1 << bit) - 1));
    let x = x.map(|x| x ^ flip);
    let digits = (0..BITS).rev().flat_map(|bit| x.map(|x| u64::from(x >> bit & 1)));
    digits.fold(0, |key, digit| key << 1 | digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_along_the_curve_are_neighbours_in_space() {
        let side = 16u32;
        let points: Vec<_> = (0..side.pow(3))
            .map(|i| Vec3::new((i % side) as f32, (i / side % side) as f32, (i / side / side) as f32))
            .collect();
        let order = order(&points);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..side.pow(3)));
        // The grid's points do not lie in the middles of the curve's cells: a few steps are longer than 1.
        let steps: Vec<_> = order.windows(2).map(|w| points[w[0] as usize].distance(points[w[1] as usize])).collect();
        assert!(steps.iter().all(|&s| s < 3.0), "{:?}", steps.iter().copied().fold(0.0, f32::max));
        assert!(steps.iter().sum::<f32>() < 1.2 * steps.len() as f32);
    }

    #[test]
    fn a_cell_s_key_is_a_bijection_that_steps_by_one() {
        let mut cells: Vec<_> = (0..512u32).map(|i| [i & 7, i >> 3 & 7, i >> 6]).map(|c| (key(c), c)).collect();
        cells.sort_unstable();
        assert!(cells.iter().map(|c| c.0).eq(0..512));
        for pair in cells.windows(2) {
            let distance: u32 = (0..3).map(|i| pair[0].1[i].abs_diff(pair[1].1[i])).sum();
            assert_eq!(distance, 1);
        }
    }

    #[test]
    fn points_in_one_place_are_ordered_too() {
        assert_eq!(order(&[Vec3::ONE; 3]), [0, 1, 2]);
        assert!(order(&[]).is_empty());
    }
}
