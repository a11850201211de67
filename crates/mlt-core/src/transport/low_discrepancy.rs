//! Well-stratified random numbers for independent sampling.

use rand_pcg::rand_core::TryRng;
use std::array;
use std::convert::Infallible;

/// The coordinates of one point of an Owen-scrambled Sobol sequence, as a stream of numbers.
///
/// Each number drawn, of 32 or of 64 bits, is the next coordinate. Coordinates come in pairs, each pair from the
/// two-dimensional Sobol sequence, shuffled and scrambled by itself: of any 2ⁿ consecutive points from a multiple of 2ⁿ
/// on, one lies in every cell of 2ⁿ equal ones that halving the square makes. So each coordinate is stratified by
/// itself, and the two of a pair in the plane.
///
/// Source: [Burley20], "Practical Hash-Based Owen Scrambling", JCGT.
pub struct OwenSobol {
    seed: u64,
    /// The point's number, its lowest bit first.
    reversed_index: u32,
    /// Pairs made so far.
    pairs: u32,
    coordinates: [u32; 2 * PAIRS],
    drawn: usize,
}

/// Pairs made at a time: what a processor does in one vector.
const PAIRS: usize = 4;

impl OwenSobol {
    /// Point number `index` mod 2³² of the sequence with key `seed`.
    #[inline]
    pub fn new(seed: u64, index: u64) -> Self {
        let coordinates = [0; 2 * PAIRS];
        Self { seed, reversed_index: (index as u32).reverse_bits(), pairs: 0, coordinates, drawn: coordinates.len() }
    }

    #[inline]
    fn coordinate(&mut self) -> u32 {
        if self.drawn == self.coordinates.len() {
            self.make_pairs();
        }
        self.drawn += 1;
        self.coordinates[self.drawn - 1]
    }

    #[inline(never)]
    fn make_pairs(&mut self) {
        let pair = |i: usize| u64::from(self.pairs + i as u32).wrapping_mul(GOLDEN);
        let keys: [u64; PAIRS] = array::from_fn(|i| mixed(self.seed.wrapping_add(pair(i))));
        let low = keys.map(|key| key as u32);
        let high = keys.map(|key| (key >> 32) as u32);
        let other = array::from_fn(|i| high[i].wrapping_mul(0x9e37_79b9) ^ low[i]);
        let index = nested([self.reversed_index; PAIRS], low).map(u32::reverse_bits);
        let first = nested(index, high).map(u32::reverse_bits);
        let second = nested(pascal(index), other).map(u32::reverse_bits);
        self.coordinates = array::from_fn(|i| if i % 2 == 0 { first[i / 2] } else { second[i / 2] });
        self.pairs += PAIRS as u32;
        self.drawn = 0;
    }
}

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64.
///
/// Source: Steele, Lea & Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
#[inline]
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// For each lane a permutation in which every bit depends on the lower ones and the key alone: Owen's scrambling of digits
/// that stand lowest bit first.
///
/// Source: [Burley20], section 3; constants of Vegdahl, "Building a Better LK Hash", 2021.
#[inline]
fn nested(digits: [u32; PAIRS], keys: [u32; PAIRS]) -> [u32; PAIRS] {
    array::from_fn(|i| {
        let (mut x, key) = (digits[i], keys[i]);
        x ^= x.wrapping_mul(0x3d20_adea);
        x = x.wrapping_add(key);
        x = x.wrapping_mul((key >> 16) | 1);
        x ^= x.wrapping_mul(0x0552_6c56);
        x ^ x.wrapping_mul(0x53a2_2864)
    })
}

/// The second Sobol coordinate of point `index`, lowest bit first, where the first coordinate is the index itself: bit k is
/// Σ_j C(j, k) index_j mod 2, and C(j, k) is odd where j has all of k's bits.
#[inline]
fn pascal(index: [u32; PAIRS]) -> [u32; PAIRS] {
    index.map(|mut x| {
        x ^= (x >> 1) & 0x5555_5555;
        x ^= (x >> 2) & 0x3333_3333;
        x ^= (x >> 4) & 0x0f0f_0f0f;
        x ^= (x >> 8) & 0x00ff_00ff;
        x ^ (x >> 16)
    })
}

impl TryRng for OwenSobol {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.coordinate())
    }

    /// One coordinate, continued by bits that hardly depend on it.
    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let high = u64::from(self.coordinate());
        Ok(high << 32 | mixed(high ^ self.seed) >> 32)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(4) {
            chunk.copy_from_slice(&self.try_next_u32()?.to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::uniform_f32;
    use rand_pcg::rand_core::Rng;

    /// Points in each of 256 cells, columns by rows, of 256 points, from coordinate `first` on.
    fn occupancy(columns: usize, first: u32, point: impl Fn(u64) -> OwenSobol) -> Vec<u32> {
        let rows = 256 / columns;
        let mut cells = vec![0; 256];
        for mut rng in (0..256).map(point) {
            (0..first).for_each(|_| _ = rng.next_u32());
            let (x, y) = (uniform_f32(&mut rng), uniform_f32(&mut rng));
            cells[(rows as f32 * y) as usize * columns + (columns as f32 * x) as usize] += 1;
        }
        cells
    }

    #[test]
    fn coordinates_are_stratified() {
        let once = |cells: Vec<u32>| cells.iter().all(|&n| n == 1);
        assert!([16, 4, 64].map(|columns| once(occupancy(columns, 0, |i| OwenSobol::new(7, i)))).iter().all(|&b| b));
        assert!((0..40).all(|first| once(occupancy(256, first, |i| OwenSobol::new(7, i)))));
        assert!((0..40).step_by(2).all(|first| once(occupancy(16, first, |i| OwenSobol::new(7, 256 + i)))));
        assert!((0..40).step_by(2).all(|first| once(occupancy(128, first, |i| OwenSobol::new(8, 512 + i)))));
        // Points of different sequences are not.
        assert!(!once(occupancy(256, 0, |i| OwenSobol::new(i << 20 | i, 0))));
    }

    #[test]
    fn coordinates_are_uniform_and_pairs_are_unrelated() {
        // Many points: the product of two coordinates has mean 1/4 and variance 7/144; of one sequence less.
        let mut sums = [0.0; 4];
        let n = 100_000;
        for i in 0..n {
            let mut rng = OwenSobol::new(3, i);
            let [a, b, c, d] = [0; 4].map(|_| f64::from(uniform_f32(&mut rng)));
            sums.iter_mut().zip([a, a * c, b * d, a * a]).for_each(|(sum, x)| *sum += x / n as f64);
        }
        for (mean, expected) in sums.into_iter().zip([0.5, 0.25, 0.25, 1.0 / 3.0]) {
            assert!((mean - expected).abs() < 4.0 * (7.0 / 144.0 / n as f64).sqrt(), "{sums:?}");
        }
    }

    #[test]
    fn a_long_coordinate_keeps_its_stratum() {
        let (mut a, mut b) = (OwenSobol::new(9, 3), OwenSobol::new(9, 3));
        assert_eq!(a.next_u64() >> 40, u64::from(b.next_u32()) >> 8);
    }
}
