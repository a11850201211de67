//! How often independent samples meet what chains visit.

use super::agreement::log2;
use super::bytes::{put, put_list};
use super::count::add_count;
use super::{DecodeError, ExactSum, Reader};
use std::collections::BTreeMap;

/// Hits that are too few to know the energy of a set of states.
const FEW: f64 = 10.0;
/// Least number of states that say anything: a chain gives two.
const LEAST_STATES: u64 = 4;

/// The energy that chains saw, by the number of independent samples that find it.
///
/// A sample shows states with the density q of [`Stratum::density`](super::Stratum::density). So m samples show a set A of states
/// in the mean
///
/// m ∫_A q dμ = m b E_{x ~ I/b}(1_A(x) / v(x)),   v = I/q,
///
/// times, and A has the share E_{x ~ I/b}(1_A) of the energy. Both means are over the states of chains; those of a round count
/// with its b̂, as they do in the image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rarity {
    /// By ⌊log₂ v⌋.
    octaves: BTreeMap<i32, Octave>,
}

/// States that were looked at, and Σ b̂ over them.
#[derive(Clone, Debug, Default, PartialEq)]
struct Octave {
    states: u64,
    energy: ExactSum,
}

impl Octave {
    fn merge(&mut self, other: &Self) {
        add_count(&mut self.states, other.states);
        self.energy.merge(&other.energy);
    }
}

impl Rarity {
    /// Takes in a state of a chain whose round has found b̂ = `b`.
    pub fn add(&mut self, importance: f64, density: f64, b: f64) {
        let octave = log2(importance / density).floor() as i32;
        let octave = self.octaves.entry(octave).or_default();
        octave.states += 1;
        octave.energy.add(b);
    }

    /// Adds others.
    pub fn merge(&mut self, other: &Self) {
        other.octaves.iter().for_each(|(&octave, states)| self.octaves.entry(octave).or_default().merge(states));
    }

    /// Share of the energy in the states of largest value v that all samples together were expected to show fewer than ten times.
    ///
    /// `weight_sum` is the sum of the samples' weights, m b̂. Values are rounded down, so the share is a lower bound. It is 0 where fewer
    /// than four states tell it.
    pub fn unmet(&self, weight_sum: f64) -> f64 {
        let all: f64 = self.octaves.values().map(|octave| octave.energy.value()).sum();
        let (mut hits, mut unmet) = (0.0, Octave::default());
        for (&octave, states) in self.octaves.iter().rev() {
            hits += weight_sum * states.energy.value() / all * libm::exp2(-f64::from(octave));
            if hits >= FEW {
                break;
            }
            unmet.merge(states);
        }
        if unmet.states < LEAST_STATES { 0.0 } else { unmet.energy.value() / all }
    }

    pub(super) fn write(&self, to: &mut Vec<u8>) {
        let octaves: Vec<_> = self.octaves.iter().collect();
        put_list(to, &octaves, |to, (octave, states)| {
            to.extend(octave.to_le_bytes());
            put(to, states.states);
            states.energy.write(to);
        });
    }

    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let octave = |from: &mut Reader| {
            let octave = from.bytes().map(i32::from_le_bytes)?;
            Ok((octave, Octave { states: from.number()?, energy: ExactSum::read(from)? }))
        };
        Ok(Self { octaves: from.list(octave)?.into_iter().collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{
        Accumulated, Film, Metropolis, Mixture, Mutation, Path, Share, Splat, Stratum, StratumStats, render, uniform,
    };
    use rand_pcg::rand_core::Rng;
    use std::ops::ControlFlow;

    /// A number of [0, 1), and a bright spot at its beginning.
    #[derive(Clone)]
    struct X(f64);
    /// [0, 1); `factor`: what its density is multiplied by without right.
    struct All {
        factor: f64,
    }
    struct Jump;

    /// Width of the spot, and its share of the energy.
    const SPOT: f64 = 1e-3;
    const SHARE: f64 = 0.3;

    fn importance(x: &X) -> f64 {
        if x.0 < SPOT { SHARE / SPOT } else { (1.0 - SHARE) / (1.0 - SPOT) }
    }

    impl Path for X {
        type Splat = Splat<1>;

        fn splats(&self) -> impl Iterator<Item = Splat<1>> {
            std::iter::empty()
        }
    }

    impl Stratum<X> for All {
        fn contains(&self, _: &X) -> bool {
            true
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
            visit(&X(uniform(rng)), 1.0);
        }

        fn density(&self, _: &X) -> f64 {
            self.factor
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    impl Mutation<X, All> for Jump {
        fn name(&self) -> &'static str {
            "jump"
        }

        fn propose(&self, x: &X, y: &mut X, _: &All, rng: &mut impl Rng) -> Option<f64> {
            *y = X(if uniform(rng) < 0.5 { SPOT * uniform(rng) } else { uniform(rng) });
            let density = |x: &X| if x.0 < SPOT { 0.5 + 0.5 / SPOT } else { 0.5 };
            Some(density(x) / density(y))
        }
    }

    /// Share that 20 rounds, of `samples` samples each, were to meet fewer than ten times.
    fn unmet(samples: u64, factor: f64) -> f64 {
        let strata = [(All { factor }, Share { mutations: 1 << 14, samples })];
        let mixture = Mixture::new(vec![Jump]);
        let metropolis = Metropolis::new(&strata, &mixture, &importance, 3).expect("a render");
        let mut sums = Accumulated::new(Film::<1>::new(1, 1.0));
        render(&metropolis, 0..20, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let (_, tally) = sums.into_parts();
        let StratumStats { rarity, weight_sum, .. } = &tally.strata[0];
        rarity.unmet(weight_sum.value())
    }

    #[test]
    fn energy_is_in_doubt_where_samples_are_to_meet_it_fewer_than_ten_times() {
        // Twenty rounds meet the spot 5, and 40 times.
        let [few, many] = [250, 2000].map(|samples| unmet(samples, 1.0));
        assert!((few - SHARE).abs() < 0.1, "{few}");
        assert_eq!(many, 0.0);
        // The negative controls: densities that are 8 times too large, or too small.
        assert_eq!(unmet(250, 8.0), 0.0);
        assert!(unmet(2000, 0.125) > 0.1);
        assert_eq!(Rarity::default().unmet(1.0), 0.0);
    }
}
