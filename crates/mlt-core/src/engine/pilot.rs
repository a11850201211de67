//! Pilot rounds: what each stratum contributes, how noisy it is, and what that costs.

use super::{
    Deposits, Estimator, Importance, Metropolis, Mutation, Path, Splat, Stratum, StratumStats, Tally,
    metropolis::Prepared,
};
use rayon::prelude::*;
use std::ops::Range;

/// Number of the first pilot round: pilot and production rounds share no random numbers.
pub const PILOT: u64 = 1 << 55;

/// What pilot rounds tell about one stratum.
///
/// With n mutations and m independent samples in a round, the stratum leaves the error
/// Σ_p w_p Var(X_jp) ≈ chain_error / n + sample_error / m in the image, w being weights of the sites, and costs
/// n · mutation_cost + m · sample_cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    /// b_j.
    pub b: f64,
    /// Standard error of `b`.
    pub b_stderr: f64,
    /// b_j² σ_j² τ_j: n Σ_p w_p Var over rounds, from the chains' visits alone; `None` if fewer than two rounds found light.
    pub chain_error: Option<f64>,
    /// Σ_p w_p μ_jp² times the variance of one sample's weight over b_j², μ_jp the stratum's image.
    pub sample_error: f64,
    /// Work of a mutation.
    pub mutation_cost: f64,
    /// Work of an independent sample.
    pub sample_cost: f64,
}

/// Visits of a stratum's chains in one round to one site, as a share of all: deposits over b̂_j.
struct Visits {
    site: u32,
    round: u64,
    share: f64,
}

/// Mean and variance over rounds at one site.
struct Moments {
    site: u32,
    mean: f64,
    variance: f64,
}

impl<P, S, M, I> Metropolis<'_, P, S, M, I> {
    /// Runs rounds that go into no image, and measures. `weigh` makes the weights w from the image (sums over channels)
    /// of these rounds.
    pub fn pilot<const C: usize>(
        &self,
        sites: u32,
        rounds: Range<u64>,
        weigh: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> (Vec<Measure>, Tally)
    where
        P: Path<Splat = Splat<C>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
        Self: Estimator<C, Prepared = Prepared, Tally = Tally>,
    {
        let (mut tally, mut visits) = (Tally::default(), Vec::new());
        visits.resize_with(self.strata.len(), Vec::new);
        let count = rounds.end.saturating_sub(rounds.start);
        for round in rounds {
            let prepared = self.prepare(round);
            let run = |task| {
                let mut deposits = Deposits::new(sites, 31);
                (self.run(&prepared, task, &mut deposits), deposits.sums())
            };
            let (tallies, sums): (Vec<_>, Vec<_>) =
                (0..self.tasks(&prepared)).into_par_iter().map(run).collect::<Vec<_>>().into_iter().unzip();
            for (task, sums) in sums.into_iter().enumerate() {
                let (stratum, b) = prepared.chain(task);
                visits[stratum].extend(sums.into_iter().map(|(site, sum)| Visits { site, round, share: sum / b }));
            }
            self.tally(&mut tally, prepared, tallies);
        }
        let lit_rounds = |stats: &StratumStats| count - stats.dark_rounds;
        let moments: Vec<_> = (visits.into_par_iter().zip(&tally.strata))
            .map(|(visits, stats)| moments(visits, lit_rounds(stats)))
            .collect();
        let mut image = vec![0.0; sites as usize];
        for (stats, moments) in tally.strata.iter().zip(&moments) {
            moments.iter().for_each(|m| image[m.site as usize] += stats.b() * m.mean);
        }
        let weights = weigh(&image);
        let measures = (self.shares.iter().zip(&tally.strata).zip(&moments))
            .map(|((share, stats), moments)| measure(share.mutations, stats, moments, lit_rounds(stats), &weights))
            .collect();
        (measures, tally)
    }
}

fn moments(mut visits: Vec<Visits>, rounds: u64) -> Vec<Moments> {
    visits.sort_by_key(|v| (v.site, v.round));
    let at_site = |visits: &[Visits]| {
        let in_round = visits.chunk_by(|a, b| a.round == b.round).map(|v| v.iter().map(|v| v.share).sum::<f64>());
        let (sum, squares) = in_round.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let mean = sum / rounds as f64;
        let variance = (squares - sum * mean).max(0.0) / (rounds as f64 - 1.0).max(1.0);
        Moments { site: visits[0].site, mean, variance }
    };
    visits.chunk_by(|a, b| a.site == b.site).map(at_site).collect()
}

fn measure(mutations: u64, stats: &StratumStats, moments: &[Moments], rounds: u64, weights: &[f64]) -> Measure {
    let b = stats.b();
    let weighted =
        |value: fn(&Moments) -> f64| -> f64 { moments.iter().map(|m| weights[m.site as usize] * value(m)).sum() };
    let variance = weighted(|m| m.variance);
    // The noise of the means is in their squares too.
    let square = (weighted(|m| m.mean * m.mean) - variance / rounds.max(1) as f64).max(0.0);
    let each = |work: u64, count: u64| work as f64 / count.max(1) as f64;
    Measure {
        b,
        b_stderr: stats.b_stderr(),
        chain_error: (rounds > 1).then_some(b * b * variance * mutations as f64),
        sample_error: square * stats.weight_variance(),
        mutation_cost: each(stats.chain_work, stats.steps()),
        sample_cost: each(stats.sample_work, stats.samples),
    }
}
