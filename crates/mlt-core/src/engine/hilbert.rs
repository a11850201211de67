//! An order of places in which neighbours stay near each other.

use rayon::prelude::*;

/// Bits of one coordinate.
pub(crate) const BITS: u32 = 16;

/// Numbers of `places`, cells of a grid of 2¹⁶ a side, along a Hilbert curve: every run of them is a compact cluster.
///
/// Source: [Skilling04].
pub(crate) fn order<const D: usize>(places: impl IndexedParallelIterator<Item = [u32; D]>) -> Vec<u32> {
    let mut keyed: Vec<_> = places.enumerate().map(|(number, place)| (key(place), number as u32)).collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, number)| number).collect()
}

/// Position along the curve of a cell of the grid.
fn key<const D: usize>(mut x: [u32; D]) -> u64 {
    for q in (1..BITS).rev().map(|bit| 1 << bit) {
        for i in 0..D {
            let swap = if x[i] & q != 0 { 0 } else { (x[0] ^ x[i]) & (q - 1) };
            x[0] ^= if x[i] & q != 0 { q - 1 } else { swap };
            x[i] ^= swap;
        }
    }
    for i in 1..D {
        x[i] ^= x[i - 1];
    }
    let flip = (1..BITS).filter(|bit| x[D - 1] >> bit & 1 != 0).fold(0, |flip, bit| flip ^ ((1 << bit) - 1));
    let x = x.map(|x| x ^ flip);
    let digits = (0..BITS).rev().flat_map(|bit| x.map(|x| u64::from(x >> bit & 1)));
    digits.fold(0, |key, digit| key << 1 | digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of the steps between neighbours along the curve through the first 512 cells.
    fn steps<const D: usize>(side: u32) {
        let cell = |i: u32| std::array::from_fn(|axis| i / side.pow(axis as u32) % side);
        let mut cells: Vec<(u64, [u32; D])> = (0..side.pow(D as u32)).map(|i| (key(cell(i)), cell(i))).collect();
        cells.sort_unstable();
        assert!(cells.iter().map(|c| c.0).eq(0..u64::from(side.pow(D as u32))));
        for pair in cells.windows(2) {
            let distance: u32 = (0..D).map(|i| pair[0].1[i].abs_diff(pair[1].1[i])).sum();
            assert_eq!(distance, 1);
        }
    }

    #[test]
    fn a_cell_s_key_is_a_bijection_that_steps_by_one() {
        steps::<2>(16);
        steps::<3>(8);
    }
}
