//! Random streams by key, so that no result depends on which thread did what.

use rand_pcg::{Pcg64Dxsm, rand_core::Rng};

/// The generator of every chain and every sample.
pub type Generator = Pcg64Dxsm;

/// Purpose of a stream of random numbers; streams of different purposes are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Purpose {
    /// An independent sample of a stratum.
    Sample = 1,
    /// The choice of the chains' first states.
    Start = 2,
    /// A chain.
    Chain = 3,
    /// An independent sample of the image.
    Image = 4,
}

/// The stream of (seed, purpose, round, stratum, index): PCG's state and increment are hashes of the key.
pub fn generator(seed: u64, purpose: Purpose, round: u64, stratum: u64, index: u64) -> Generator {
    let mut hash = 0x9e37_79b9_7f4a_7c15;
    let mut absorb = |word: u64| {
        hash = mixed(hash ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        hash
    };
    let a = absorb(seed);
    let b = absorb(((purpose as u64) << 56) ^ round);
    let c = absorb(stratum);
    let d = absorb(index);
    let wide = |high: u64, low: u64| u128::from(high) << 64 | u128::from(low);
    Generator::new(wide(mixed(a ^ d), mixed(c ^ d.rotate_left(32))), wide(mixed(b ^ d), d))
}

/// The finaliser of SplitMix64, a bijection in which every output bit depends on every input bit.
///
/// Source: Steele, Lea & Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
#[inline]
pub fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Uniform in [0, 1), 53 bits.
#[inline]
pub fn uniform(rng: &mut impl Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Uniform in [0, 1), 24 bits. It takes one `next_u32`, so a generator that plays back stored or low-discrepancy
/// numbers gives one coordinate a call.
#[inline]
pub fn uniform_f32(rng: &mut impl Rng) -> f32 {
    (rng.next_u32() >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn neighbouring_keys_give_unrelated_streams() {
        let mut first = HashSet::new();
        let mut sum = 0.0;
        for seed in 0..4 {
            for round in 0..8 {
                for stratum in 0..8 {
                    for index in 0..16 {
                        let mut rng = generator(seed, Purpose::Chain, round, stratum, index);
                        first.insert(rng.next_u64());
                        sum += uniform(&mut rng);
                    }
                }
            }
        }
        assert_eq!(first.len(), 4096);
        let z = (sum / 4096.0 - 0.5) * (12.0 * 4096f64).sqrt();
        assert!(z.abs() < 4.0, "mean of the streams' second numbers: z = {z}");
    }
}
