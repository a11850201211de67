//! Well-stratified random numbers for independent sampling.

use rand_pcg::rand_core::TryRng;
use std::array;
use std::convert::Infallible;

/// The coordinates of one point of an Owen-scrambled Sobol sequence, as a stream of numbers.
///
/// Each number drawn, of 32 or of 64 bits, is the next coordinate. Coordinates come in sets of four, each set from the
/// four-dimensional Sobol sequence, shuffled and scrambled by itself. Each coordinate is stratified by itself, the first two of
/// a set also in the plane, and all four jointly the longer the sequence.
///
/// Source: [Burley20], "Practical Hash-Based Owen Scrambling", JCGT.
pub struct OwenSobol {
    seed: u64,
    /// The point's number, its lowest bit first.
    reversed_index: u32,
    /// Sets made so far.
    sets: u32,
    coordinates: [u32; 4],
    drawn: usize,
}

impl OwenSobol {
    /// Point number `index` mod 2³² of the sequence with key `seed`.
    #[inline]
    pub fn new(seed: u64, index: u64) -> Self {
        Self { seed, reversed_index: (index as u32).reverse_bits(), sets: 0, coordinates: [0; 4], drawn: 4 }
    }

    /// The numbers of branch `i` of `branches` of this point: point `index` × `branches` + i of another sequence.
    #[inline]
    pub fn branch(&self, i: u32, branches: u32) -> Self {
        let index = self.reversed_index.reverse_bits();
        Self::new(mixed(self.seed ^ GOLDEN), u64::from(index) * u64::from(branches) + u64::from(i))
    }

    #[inline]
    fn coordinate(&mut self) -> u32 {
        if self.drawn == 4 {
            self.make_set();
        }
        self.drawn += 1;
        self.coordinates[self.drawn - 1]
    }

    #[inline(never)]
    fn make_set(&mut self) {
        let key = mixed(self.seed.wrapping_add(u64::from(self.sets).wrapping_mul(GOLDEN)));
        let more = mixed(key);
        let keys = [(key >> 32) as u32, more as u32, (more >> 32) as u32, (more.wrapping_mul(GOLDEN) >> 32) as u32];
        let index = nested(self.reversed_index, key as u32).reverse_bits();
        let digits = [index, pascal(index), looked_up(&THIRD, index), looked_up(&FOURTH, index)];
        self.coordinates = array::from_fn(|i| nested(digits[i], keys[i]).reverse_bits());
        self.sets += 1;
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

/// A permutation in which every bit depends on the lower ones and the key alone: Owen's scrambling of digits that stand
/// lowest bit first.
///
/// Source: [Burley20], section 3; constants of Vegdahl, "Building a Better LK Hash", 2021.
#[inline]
fn nested(mut x: u32, key: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol coordinate of point `index`, lowest bit first, where the first coordinate is the index itself: bit k is
/// Σ_j C(j, k) index_j mod 2, and C(j, k) is odd where j has all of k's bits.
#[inline]
fn pascal(mut index: u32) -> u32 {
    index ^= (index >> 1) & 0x5555_5555;
    index ^= (index >> 2) & 0x3333_3333;
    index ^= (index >> 4) & 0x0f0f_0f0f;
    index ^= (index >> 8) & 0x00ff_00ff;
    index ^ (index >> 16)
}

/// What each byte of an index adds to a coordinate, lowest bit first.
type Table = [[u32; 256]; 4];

/// The third coordinate: x² + x + 1.
static THIRD: Table = table([1, 3, 0], 2, 0b1);
/// The fourth coordinate: x³ + x + 1.
static FOURTH: Table = table([1, 3, 1], 3, 0b01);

/// The coordinate of a primitive polynomial of some degree, given by its inner coefficients, and of the first m_k:
/// m_k = Σ_{0<i<degree} 2^i a_i m_{k−i} + 2^degree m_{k−degree} + m_{k−degree}, sums mod 2 by bits; column k is m_k / 2^k.
///
/// Source: [JoeKuo08], "Constructing Sobol Sequences with Better Two-Dimensional Projections", SIAM J. Sci. Comput.
const fn table(first: [u64; 3], degree: usize, inner: u64) -> Table {
    let mut table = [[0; 256]; 4];
    let mut m = [0u64; 32];
    let mut k = 0;
    while k < 32 {
        m[k] = if k < degree { first[k] } else { m[k - degree] ^ m[k - degree] << degree };
        let mut i = 1;
        while k >= degree && i < degree {
            m[k] ^= (inner >> (degree - 1 - i) & 1) * (m[k - i] << i);
            i += 1;
        }
        let column = ((m[k] << (31 - k)) as u32).reverse_bits();
        let mut byte = 0;
        while byte < 256 {
            table[k / 8][byte] ^= if byte >> (k % 8) & 1 == 1 { column } else { 0 };
            byte += 1;
        }
        k += 1;
    }
    table
}

#[inline]
fn looked_up(table: &Table, index: u32) -> u32 {
    let [a, b, c, d] = index.to_le_bytes().map(usize::from);
    table[0][a] ^ table[1][b] ^ table[2][c] ^ table[3][d]
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
        assert!((0..40).step_by(4).all(|first| once(occupancy(16, first, |i| OwenSobol::new(7, 256 + i)))));
        assert!((0..40).step_by(4).all(|first| once(occupancy(128, first, |i| OwenSobol::new(8, 512 + i)))));
        // Points of different sequences are not.
        assert!(!once(occupancy(256, 0, |i| OwenSobol::new(i << 20 | i, 0))));
    }

    /// Known values of the plain sequence: 2⁻³ times the numbers of the first eight points.
    #[test]
    fn tables_are_those_of_the_sequence() {
        let eighths = |table| (0..8).map(|i| looked_up(table, i).reverse_bits() >> 29).collect::<Vec<_>>();
        assert_eq!(eighths(&THIRD), [0, 4, 6, 2, 3, 7, 5, 1]);
        assert_eq!(eighths(&FOURTH), [0, 4, 6, 2, 1, 5, 7, 3]);
    }

    #[test]
    fn coordinates_are_uniform_and_unrelated() {
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
    fn branches_of_all_points_are_one_sequence() {
        let branch = |i| OwenSobol::new(7, i / 4).branch(i as u32 % 4, 4);
        for columns in [4, 16, 256] {
            assert!(occupancy(columns, 0, branch).iter().all(|&n| n == 1));
        }
        assert_ne!(branch(0).next_u32(), OwenSobol::new(7, 0).next_u32());
    }

    #[test]
    fn a_long_coordinate_keeps_its_stratum() {
        let (mut a, mut b) = (OwenSobol::new(9, 3), OwenSobol::new(9, 3));
        assert_eq!(a.next_u64() >> 40, u64::from(b.next_u32()) >> 8);
    }
}
