//! An order of points in space in which neighbours stay near each other.

use crate::engine::hilbert::{self, BITS};
use glam::Vec3;
use rayon::prelude::*;

/// Indices of `points` along a Hilbert curve through their bounds: every run of them is a compact cluster.
pub(crate) fn order(points: &[Vec3]) -> Vec<u32> {
    let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = (high - low).max_element();
    let scale = if size > 0.0 { ((1 << BITS) - 1) as f32 / size } else { 0.0 };
    hilbert::order(points.par_iter().map(|p| ((*p - low) * scale).to_array().map(|x| x as u32)))
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
    fn points_in_one_place_are_ordered_too() {
        assert_eq!(order(&[Vec3::ONE; 3]), [0, 1, 2]);
        assert!(order(&[]).is_empty());
    }
}
