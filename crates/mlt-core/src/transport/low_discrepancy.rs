//! Well-stratified random numbers for independent sampling.

use crate::engine::Generator;
use rand_pcg::rand_core::{Rng, TryRng};
use sobol_burley::{NUM_DIMENSION_SETS_4D, sample_4d};
use std::convert::Infallible;

/// Points of one scrambled sequence; more of them are taken from further sequences.
const SEQUENCE: u64 = 1 << 16;

/// The coordinates of one point of an Owen-scrambled Sobol sequence, as a stream of numbers.
///
/// Each number drawn, of 32 or of 64 bits, is the next coordinate. Each coordinate is stratified by itself, the first two
/// also in the plane, and more of them jointly the longer the sequence. After the last of 256 coordinates the stream goes on
/// with independent numbers.
///
/// Source: [Burley20], "Practical Hash-Based Owen Scrambling", JCGT; by the crate `sobol_burley`.
pub struct OwenSobol {
    index: u32,
    seed: u32,
    coordinate: u32,
    buffer: [f32; 4],
    rest: Generator,
}

impl OwenSobol {
    /// Point number `index` of the sequence with key `seed`.
    #[inline]
    pub fn new(seed: u64, index: u64) -> Self {
        let sequence = (seed as u32) ^ ((index / SEQUENCE) as u32).wrapping_mul(0x9e37_79b9);
        Self {
            index: (index % SEQUENCE) as u32,
            seed: sequence,
            coordinate: 0,
            buffer: [0.0; 4],
            rest: Generator::new(u128::from(seed), u128::from(index)),
        }
    }
}

impl TryRng for OwenSobol {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        let (set, lane) = (self.coordinate / 4, self.coordinate as usize % 4);
        if set >= NUM_DIMENSION_SETS_4D {
            return Ok(self.rest.next_u32());
        }
        if lane == 0 {
            self.buffer = sample_4d(self.index, set, self.seed);
        }
        self.coordinate += 1;
        Ok((self.buffer[lane] * (1u64 << 32) as f32) as u32)
    }

    /// One coordinate, continued by independent bits.
    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let high = self.try_next_u32()?;
        // A coordinate has 24 bits.
        Ok(u64::from(high) << 32 | self.rest.next_u64() >> 24)
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
        // Points of different sequences are not.
        assert!(!once(occupancy(256, 0, |i| OwenSobol::new(i << 20 | i, 0))));
    }

    #[test]
    fn coordinates_beyond_the_last_are_independent_numbers() {
        let mut rng = OwenSobol::new(3, 5);
        (0..256).for_each(|_| _ = rng.next_u32());
        let mean = (0..10_000).map(|_| f64::from(uniform_f32(&mut rng))).sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 4.0 / (12.0 * 1e4f64).sqrt());
    }

    #[test]
    fn a_long_coordinate_keeps_its_stratum() {
        let (mut a, mut b) = (OwenSobol::new(9, 3), OwenSobol::new(9, 3));
        assert_eq!(a.next_u64() >> 40, u64::from(b.next_u32()) >> 8);
    }
}
