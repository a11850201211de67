//! Whether the chains of a stratum agree.

use super::bytes::put;
use super::count::add_count;
use super::{DecodeError, ExactSum, Reader};

/// Moments of g(x) = log₂ I(x) over halves of chains.
///
/// With W the mean variance of g inside a half of n states, and V the variance of the means of m halves,
///
/// R̂² = ((n − 1)/n W + V)/W,   and all halves together are worth m W/V independent states.
///
/// Chains that stay where they started, or whose moves are too small for their length, have V ≈ W and R̂ ≈ √2 or more.
///
/// Source: [GelmanRubin92], with each chain cut in halves as in [GelmanEtAl13].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HalfChains {
    /// m.
    halves: u64,
    /// m n.
    states: u64,
    /// Σ of the halves' means, and of their squares.
    means: [ExactSum; 2],
    /// Σ of the variances inside.
    within: ExactSum,
}

impl HalfChains {
    /// Adds others.
    pub fn merge(&mut self, other: &Self) {
        add_count(&mut self.halves, other.halves);
        add_count(&mut self.states, other.states);
        self.means.iter_mut().zip(&other.means).for_each(|(sum, x)| sum.merge(x));
        self.within.merge(&other.within);
    }

    /// R̂ ≥ 1, but for noise; `None` with fewer than two halves and where g does not vary.
    pub fn r_hat(&self) -> Option<f64> {
        let (n, within) = (self.states as f64 / self.halves as f64, self.within.value() / self.halves as f64);
        let r_hat = ((n - 1.0) / n + self.between()? / within).sqrt();
        (!r_hat.is_nan()).then_some(r_hat)
    }

    /// Independent states that all are worth, at most their number; `None` as for [`r_hat`](Self::r_hat).
    pub fn effective_states(&self) -> Option<f64> {
        let worth = self.within.value() / self.between()?;
        (!worth.is_nan()).then(|| worth.min(self.states as f64))
    }

    pub(super) fn write(&self, to: &mut Vec<u8>) {
        [self.halves, self.states].into_iter().for_each(|count| put(to, count));
        self.means.iter().chain([&self.within]).for_each(|sum| sum.write(to));
    }

    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let (halves, states) = (from.number()?, from.number()?);
        let means = [ExactSum::read(from)?, ExactSum::read(from)?];
        Ok(Self { halves, states, means, within: ExactSum::read(from)? })
    }

    /// V.
    fn between(&self) -> Option<f64> {
        let m = self.halves as f64;
        let [sum, squares] = self.means.each_ref().map(ExactSum::value);
        (self.halves > 1).then(|| (squares - sum * sum / m).max(0.0) / (m - 1.0))
    }
}

/// One half of a chain, as it grows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Half {
    states: u64,
    sum: f64,
    squares: f64,
}

impl Half {
    /// Takes in a state with this g.
    #[inline]
    pub(super) fn add(&mut self, g: f64) {
        self.states += 1;
        self.sum += g;
        self.squares += g * g;
    }

    /// Adds what it found, if it has two states or more, and begins anew.
    pub(super) fn close(&mut self, halves: &mut HalfChains) {
        let Self { states, sum, squares } = std::mem::take(self);
        if states < 2 {
            return;
        }
        let n = states as f64;
        let mean = sum / n;
        halves.halves += 1;
        halves.states += states;
        halves.means[0].add(mean);
        halves.means[1].add(mean * mean);
        halves.within.add((squares - n * mean * mean).max(0.0) / (n - 1.0));
    }
}

/// g: log₂ of a positive number, exact at powers of two and up to 0.09 too small between them. Any scalar that tells states apart
/// will do.
#[inline]
pub(super) fn log2(x: f64) -> f64 {
    x.to_bits() as i64 as f64 * (1.0 / (1u64 << 52) as f64) - 1023.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform};

    /// Halves of `n` states of an autoregressive process with factor `a` about a level of the half's own.
    fn halves(n: u64, a: f64, level: impl Fn(u64) -> f64) -> HalfChains {
        let mut all = HalfChains::default();
        for i in 0..400 {
            let mut rng = generator(5, Purpose::Chain, 0, 0, i);
            let (mut half, mut x, mut part) = (Half::default(), 0.0, HalfChains::default());
            (0..n).for_each(|_| {
                x = a * x + uniform(&mut rng) - 0.5;
                half.add(x + level(i));
            });
            half.close(&mut part);
            all.merge(&part);
        }
        all
    }

    /// An autoregressive process has τ = (1 + a)/(1 − a).
    #[test]
    fn effective_states_are_those_of_the_autocorrelation_time() {
        for (a, time) in [(0.0, 1.0), (0.9, 19.0)] {
            let found = halves(2000, a, |_| 0.0);
            let (r_hat, worth) = (found.r_hat().expect("it varies"), found.effective_states().expect("it varies"));
            assert!((r_hat - 1.0).abs() < 0.01, "{r_hat}");
            assert!((worth * time / 800_000.0 - 1.0).abs() < 0.25, "{worth}");
        }
    }

    #[test]
    fn chains_that_stay_apart_are_told() {
        let apart = halves(2000, 0.0, |i| (i % 2) as f64);
        assert!(apart.r_hat().expect("it varies") > 1.5, "{apart:?}");
        assert!(apart.effective_states().expect("it varies") < 400.0, "{apart:?}");
    }

    #[test]
    fn chains_that_do_not_move_have_no_end_of_disagreement_or_none() {
        let stuck = |level: fn(u64) -> f64| {
            let mut all = HalfChains::default();
            for i in 0..4 {
                let mut half = Half::default();
                (0..10).for_each(|_| half.add(level(i)));
                half.close(&mut all);
            }
            all
        };
        assert_eq!(stuck(|_| 2.0).r_hat(), None);
        assert_eq!(stuck(|i| i as f64).r_hat(), Some(f64::INFINITY));
        assert_eq!(HalfChains::default().r_hat(), None);
    }

    #[test]
    fn the_logarithm_is_one() {
        assert!([1e-30, 0.3, 1.0, 7.0, 1e20].iter().all(|&x: &f64| (log2(x) - x.log2()).abs() < 0.09));
    }
}
