//! Whether strata are a partition, and their samples what they say.

use super::trial::Zero;
use super::{Law, Report, Trials};
use crate::engine::{Importance, Purpose, Stratum, generator};

/// Tries strata against `whole`, a sampler of the whole space: a [`Stratum`] that contains every state.
///
/// With samples of the whole, each state of positive importance has to lie in one stratum, and
/// E[Σ w/p · I · 1_{Ω_j}] = E[Σ w_j/p_j · I] for every stratum.
pub fn strata<P>(
    strata: &[impl Stratum<P>],
    whole: &impl Stratum<P>,
    importance: &impl Importance<P>,
    trials: Trials,
) -> Report {
    let mut report = Report::default();
    let mut integrals = vec![Zero::new(trials.count); strata.len()];
    let (mut uncovered, mut shared) = (0, 0);
    for trial in 0..trials.count {
        let mut of_whole = vec![0.0; strata.len()];
        sample(whole, usize::MAX, trial, trials, &mut |path, weight| {
            let weight = weight * importance.eval(path);
            let inside = |j: &usize| strata[*j].contains(path);
            let lit = u64::from(weight > 0.0);
            match (0..strata.len()).filter(inside).inspect(|&j| of_whole[j] += weight).count() {
                0 => uncovered += lit,
                1 => {}
                _ => shared += lit,
            }
        });
        for (j, stratum) in strata.iter().enumerate() {
            let mut sum = 0.0;
            sample(stratum, j, trial, trials, &mut |path, weight| sum += weight * importance.eval(path));
            integrals[j].add(sum - of_whole[j]);
        }
    }
    report.count(Law::Covered, uncovered, trials.count, "states of the whole");
    report.count(Law::Disjoint, shared, trials.count, "states of the whole");
    report.expect(Law::Integral, &integrals, |j| format!("stratum {j} against the whole"));
    for (j, stratum) in strata.iter().enumerate() {
        samples(stratum, j, importance, trials, &mut report);
    }
    report
}

/// Whether the samples of a stratum repeat, are finite, and lie in it.
fn samples<P>(
    stratum: &impl Stratum<P>,
    j: usize,
    importance: &impl Importance<P>,
    trials: Trials,
    report: &mut Report,
) {
    let (mut outside, mut not_finite, mut changed) = (0, 0, 0);
    for trial in 0..trials.count {
        let mut weights = Vec::new();
        sample(stratum, j, trial, trials, &mut |path, weight| {
            let value = importance.eval(path);
            outside += u64::from(!stratum.contains(path));
            not_finite += u64::from(!([weight, value].iter().all(|x| x.is_finite() && *x >= 0.0)));
            weights.push([weight, value].map(f64::to_bits));
        });
        let mut again = Vec::new();
        sample(stratum, j, trial, trials, &mut |path, weight| {
            again.push([weight, importance.eval(path)].map(f64::to_bits));
        });
        changed += u64::from(weights != again);
    }
    let place = format!("samples of stratum {j}");
    report.count(Law::Repeatable, changed, trials.count, &place);
    report.count(Law::Inside, outside, trials.count, &place);
    report.count(Law::Finite, not_finite, trials.count, &place);
}

fn sample<P>(stratum: &impl Stratum<P>, j: usize, trial: u64, trials: Trials, visit: &mut impl FnMut(&P, f64)) {
    stratum.sample(&mut generator(trials.seed, Purpose::Sample, 0, j as u64, trial), visit);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::uniform;
    use rand_pcg::rand_core::Rng;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// [low, high) of the line; what else it does wrong.
    #[derive(Default)]
    struct Cell {
        low: f64,
        high: f64,
        /// Relative error of its samples' weights.
        too_bright: f64,
        /// How far from it its samples lie.
        beside: f64,
        /// Whether the number of samples so far has a part in them.
        counts: bool,
        drawn: AtomicU64,
    }

    impl Stratum<f64> for Cell {
        fn contains(&self, x: &f64) -> bool {
            (self.low..self.high).contains(x)
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&f64, f64)) {
            let drawn = self.drawn.fetch_add(u64::from(self.counts), Ordering::Relaxed);
            let width = self.high - self.low;
            let x = self.low + width * ((uniform(rng) + drawn as f64 * 0.37) % 1.0);
            visit(&(x + self.beside), width * (1.0 + self.too_bright));
        }

        fn density(&self, _: &f64) -> f64 {
            1.0 / (self.high - self.low)
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    fn cell(low: f64, high: f64) -> Cell {
        Cell { low, high, ..Cell::default() }
    }

    fn broken(cells: &[Cell]) -> Vec<Law> {
        let report = strata(cells, &cell(0.0, 1.0), &|x: &f64| 1.0 + x, Trials { count: 20_000, seed: 3 });
        report.broken.iter().map(|finding| finding.law).collect()
    }

    #[test]
    fn each_law_is_named_where_it_is_broken() {
        assert_eq!(broken(&[cell(0.0, 0.3), cell(0.3, 1.0)]), []);
        assert_eq!(broken(&[cell(0.0, 0.3), cell(0.301, 1.0)]), [Law::Covered]);
        assert_eq!(broken(&[cell(0.0, 0.301), cell(0.3, 1.0)]), [Law::Disjoint]);
        let bright = Cell { too_bright: 0.05, ..cell(0.3, 1.0) };
        assert_eq!(broken(&[cell(0.0, 0.3), bright]), [Law::Integral]);
        let beside = Cell { beside: -1e-3, ..cell(0.3, 1.0) };
        assert_eq!(broken(&[cell(0.0, 0.3), beside]), [Law::Inside]);
        let counts = Cell { counts: true, ..cell(0.3, 1.0) };
        assert_eq!(broken(&[cell(0.0, 0.3), counts]), [Law::Repeatable]);
        let negative = Cell { too_bright: f64::NAN, ..cell(0.3, 1.0) };
        assert!(broken(&[cell(0.0, 0.3), negative]).contains(&Law::Finite));
    }

    #[test]
    fn a_report_reads_as_sentences() {
        let report = strata(&[cell(0.0, 0.5)], &cell(0.0, 1.0), &|_: &f64| 1.0, Trials { count: 100, seed: 3 });
        let text = report.to_string();
        assert!(
            text.starts_with("every state of positive importance lies in a stratum: broken by states of the whole"),
            "{text}"
        );
    }
}
