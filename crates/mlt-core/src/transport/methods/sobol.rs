//! Well-stratified random numbers for independent sampling.

use crate::engine::mixed;
use crate::instructions::{InstructionSet, Work};
use rand_pcg::rand_core::TryRng;
use std::convert::Infallible;

/// Points whose coordinates are made at once.
const POINTS: usize = 8;
/// Sets of coordinates that are made at once.
const SETS: usize = 2;

/// A coordinate of each of the points that are made at once.
type Coordinates = [u32; POINTS];

/// An Owen-scrambled Sobol sequence, and a stream of the coordinates of one of its points.
///
/// Each number drawn, of 32 or of 64 bits, is the next coordinate. Coordinates come in sets of four, each set from the
/// four-dimensional Sobol sequence, shuffled and scrambled by itself. Each coordinate is stratified by itself, the first two of
/// a set also in the plane, and all four jointly the longer the sequence.
///
/// Source: [Burley20], "Practical Hash-Based Owen Scrambling", JCGT.
#[derive(Debug)]
pub struct OwenSobol {
    seed: u64,
    /// The point's number.
    index: u32,
    /// Coordinates drawn of this point.
    drawn: usize,
    /// Those made so far of the points that are made with this one.
    made: Vec<Coordinates>,
    /// The sequence of the branches.
    branches: Option<Box<Self>>,
    instructions: InstructionSet,
}

impl OwenSobol {
    /// The sequence with key `seed`, at its first point.
    pub fn new(seed: u64) -> Self {
        Self { seed, index: 0, drawn: 0, made: Vec::new(), branches: None, instructions: InstructionSet::detect() }
    }

    /// Becomes the sequence with key `seed`, at its first point, and keeps its memory.
    pub fn restart(&mut self, seed: u64) {
        (self.seed, self.index, self.drawn) = (seed, 0, 0);
        self.made.clear();
        if let Some(branches) = &mut self.branches {
            branches.restart(of_branches(seed));
        }
    }

    /// Goes to the first coordinate of point number `index` mod 2³².
    #[inline]
    pub fn go_to(&mut self, index: u64) {
        let index = index as u32;
        if index / POINTS as u32 != self.index / POINTS as u32 {
            self.made.clear();
        }
        (self.index, self.drawn) = (index, 0);
    }

    /// The numbers of branch `i` of `branches` of this point: point `index` × `branches` + i of another sequence.
    #[inline]
    pub fn branch(&mut self, i: u32, branches: u32) -> &mut Self {
        let index = u64::from(self.index) * u64::from(branches) + u64::from(i);
        let sequence = self.branches.get_or_insert_with(|| Box::new(Self::new(of_branches(self.seed))));
        sequence.go_to(index);
        sequence
    }

    #[inline]
    fn coordinate(&mut self) -> u32 {
        let point = self.index as usize % POINTS;
        let coordinate = match self.made.get(self.drawn) {
            Some(coordinates) => coordinates[point],
            None => self.make_more()[point],
        };
        self.drawn += 1;
        coordinate
    }

    /// Makes more sets of coordinates, and returns the first of them.
    #[cold]
    fn make_more(&mut self) -> &Coordinates {
        let first = self.made.len();
        self.instructions.perform(MoreSets(self));
        &self.made[first]
    }
}

/// The next sets of some points.
struct MoreSets<'a>(&'a mut OwenSobol);

impl Work for MoreSets<'_> {
    type Outcome = ();

    #[inline(always)]
    fn perform(self) {
        let OwenSobol { seed, index, made, .. } = self.0;
        let first = *index - *index % POINTS as u32;
        let sets = (made.len() / 4) as u64;
        for set in sets..sets + SETS as u64 {
            made.extend(set_of(mixed(seed.wrapping_add(set.wrapping_mul(GOLDEN))), first));
        }
    }
}

/// The coordinates of points `first`, a multiple of [`POINTS`], and following, in the set with a key.
///
/// Shuffled, the points' numbers still differ in their lowest digits alone, and coordinates are linear in the digits mod 2:
/// the first point's give the others'.
#[inline(always)]
fn set_of(key: u64, first: u32) -> [Coordinates; 4] {
    let keys = scrambles(key);
    let mut shuffled = [0; POINTS];
    for (i, number) in shuffled.iter_mut().enumerate() {
        *number = nested((first + i as u32).reverse_bits(), key as u32).reverse_bits();
    }
    let of_first = digits(shuffled[0]);
    let mut set = [[0; POINTS]; 4];
    for (axis, coordinates) in set.iter_mut().enumerate() {
        for (number, coordinate) in shuffled.iter().zip(coordinates) {
            let lowest = number ^ shuffled[0];
            let bit = |k: usize| (lowest >> k & 1).wrapping_neg() & LOWEST[k][axis];
            *coordinate = nested(of_first[axis] ^ bit(0) ^ bit(1) ^ bit(2), keys[axis]).reverse_bits();
        }
    }
    set
}

/// The keys of the scrambles of a set's coordinates.
#[inline(always)]
fn scrambles(key: u64) -> [u32; 4] {
    let more = mixed(key);
    [(key >> 32) as u32, more as u32, (more >> 32) as u32, (more.wrapping_mul(GOLDEN) >> 32) as u32]
}

/// The four Sobol coordinates of point `index`, lowest bit first.
const fn digits(index: u32) -> [u32; 4] {
    [index, pascal(index), looked_up(&THIRD, index), looked_up(&FOURTH, index)]
}

/// Those of the points whose numbers have one of the lowest digits and no other.
const LOWEST: [[u32; 4]; 3] = [digits(1), digits(2), digits(4)];
const _: () = assert!(POINTS == 1 << LOWEST.len());

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The key of the branches' sequence.
fn of_branches(seed: u64) -> u64 {
    mixed(seed ^ GOLDEN)
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
const fn pascal(mut index: u32) -> u32 {
    index ^= (index >> 1) & 0x5555_5555;
    index ^= (index >> 2) & 0x3333_3333;
    index ^= (index >> 4) & 0x0f0f_0f0f;
    index ^= (index >> 8) & 0x00ff_00ff;
    index ^ (index >> 16)
}

/// Contribution of each byte of an index to a coordinate, lowest bit first.
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
const fn looked_up(table: &Table, index: u32) -> u32 {
    let [a, b, c, d] = index.to_le_bytes();
    table[0][a as usize] ^ table[1][b as usize] ^ table[2][c as usize] ^ table[3][d as usize]
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

    fn point(seed: u64, index: u64) -> OwenSobol {
        let mut rng = OwenSobol::new(seed);
        rng.go_to(index);
        rng
    }

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
        assert!([16, 4, 64].map(|columns| once(occupancy(columns, 0, |i| point(7, i)))).iter().all(|&b| b));
        assert!((0..40).all(|first| once(occupancy(256, first, |i| point(7, i)))));
        assert!((0..40).step_by(4).all(|first| once(occupancy(16, first, |i| point(7, 256 + i)))));
        assert!((0..40).step_by(4).all(|first| once(occupancy(128, first, |i| point(8, 512 + i)))));
        // Points of different sequences are not.
        assert!(!once(occupancy(256, 0, |i| point(i << 20 | i, 0))));
    }

    /// Known values of the plain sequence: 2⁻³ times the numbers of the first eight points.
    #[test]
    fn tables_are_those_of_the_sequence() {
        let eighths = |table| (0..8).map(|i| looked_up(table, i).reverse_bits() >> 29).collect::<Vec<_>>();
        assert_eq!(eighths(&THIRD), [0, 4, 6, 2, 3, 7, 5, 1]);
        assert_eq!(eighths(&FOURTH), [0, 4, 6, 2, 1, 5, 7, 3]);
    }

    /// Points that are made at once, in vectors if the processor has them, are what each would be by itself.
    #[test]
    fn coordinates_are_scrambled_sobol_points() {
        for index in [0, 1, 13, 1000, u32::MAX] {
            let mut rng = point(7, index.into());
            for set in 0..2 * SETS as u64 {
                let key = mixed(set.wrapping_mul(GOLDEN).wrapping_add(7));
                let plain = digits(nested(index.reverse_bits(), key as u32).reverse_bits());
                for (digits, key) in plain.into_iter().zip(scrambles(key)) {
                    assert_eq!(rng.next_u32(), nested(digits, key).reverse_bits(), "point {index}, set {set}");
                }
            }
        }
    }

    #[test]
    fn coordinates_are_uniform_and_unrelated() {
        // Many points: the product of two coordinates has mean 1/4 and variance 7/144; of one sequence less.
        let mut sums = [0.0; 4];
        let n = 100_000;
        for i in 0..n {
            let mut rng = point(3, i);
            let [a, b, c, d] = [0; 4].map(|_| f64::from(uniform_f32(&mut rng)));
            sums.iter_mut().zip([a, a * c, b * d, a * a]).for_each(|(sum, x)| *sum += x / n as f64);
        }
        for (mean, expected) in sums.into_iter().zip([0.5, 0.25, 0.25, 1.0 / 3.0]) {
            assert!((mean - expected).abs() < 4.0 * (7.0 / 144.0 / n as f64).sqrt(), "{sums:?}");
        }
    }

    #[test]
    fn branches_of_all_points_are_one_sequence() {
        let branch = |i| {
            let mut rng = point(7, i / 4);
            rng.branch(i as u32 % 4, 4);
            *rng.branches.unwrap()
        };
        for columns in [4, 16, 256] {
            assert!(occupancy(columns, 0, branch).iter().all(|&n| n == 1));
        }
        assert_ne!(branch(0).next_u32(), point(7, 0).next_u32());
    }

    #[test]
    fn a_restarted_sequence_is_a_new_one() {
        let mut used = point(7, 3);
        used.branch(1, 4).next_u32();
        (0..20).for_each(|_| _ = used.next_u32());
        used.restart(8);
        let mut new = OwenSobol::new(8);
        assert_eq!([used.next_u32(), used.branch(1, 4).next_u32()], [new.next_u32(), new.branch(1, 4).next_u32()]);
    }

    #[test]
    fn a_long_coordinate_keeps_its_stratum() {
        let (mut a, mut b) = (point(9, 3), point(9, 3));
        assert_eq!(a.next_u64() >> 40, u64::from(b.next_u32()) >> 8);
    }
}
