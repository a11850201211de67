//! One Metropolis–Hastings chain.

use super::{Importance, Mixture, Mutation, Path, Sink, Stratum, StratumStats, uniform};
use rand_pcg::rand_core::Rng;

/// A chain in one stratum. It owns two states and swaps them, so a step copies no more than its mutation does.
pub struct Chain<'a, P, S, M, I> {
    mixture: &'a Mixture<P, S, M>,
    importance: &'a I,
    stratum: &'a S,
    current: P,
    proposal: P,
    current_importance: f64,
    pending: f64,
    rejections: u64,
    stats: StratumStats,
}

impl<'a, P, S, M, I> Chain<'a, P, S, M, I>
where
    P: Path,
    S: Stratum<P>,
    M: Mutation<P, S>,
    I: Importance<P>,
{
    /// A chain that starts at `start`; `None` if that state's importance is not positive and finite in the stratum.
    pub fn new(mixture: &'a Mixture<P, S, M>, importance: &'a I, stratum: &'a S, start: P) -> Option<Self> {
        let current_importance = importance.eval(&start);
        let valid = current_importance > 0.0 && current_importance.is_finite() && stratum.contains(&start);
        valid.then(|| Self {
            mixture,
            importance,
            stratum,
            proposal: start.clone(),
            current: start,
            current_importance,
            pending: 0.0,
            rejections: 0,
            stats: StratumStats::new(mixture.mutations().len()),
        })
    }

    /// The state that the chain stands at.
    pub fn current(&self) -> &P {
        &self.current
    }

    /// One Metropolis–Hastings step; deposits both states by expected value, times `scale`.
    ///
    /// a(x→y) = min(1, I_j(y) T(y→x) / (I_j(x) T(x→y))); y gets a, x gets 1 − a, and what x is due is deposited once,
    /// when the chain leaves it.
    ///
    /// Source: [VeachGuibas97], sections 4.1 and 5.1.
    pub fn step(&mut self, sink: &mut impl Sink<P::Splat>, scale: f64, rng: &mut impl Rng) {
        let Some(Candidate { mutation, importance, acceptance }) = self.propose(rng) else {
            self.pending += 1.0;
            return self.stay();
        };
        self.pending += 1.0 - acceptance;
        if uniform(rng) < acceptance {
            self.flush(sink, scale);
            std::mem::swap(&mut self.current, &mut self.proposal);
            self.current_importance = importance;
            self.pending = acceptance;
            self.rejections = 0;
            self.stats.mutations[mutation].accepted += 1;
        } else {
            if acceptance > 0.0 {
                deposit(&self.proposal, acceptance * scale / importance, sink);
            }
            self.stats.mutations[mutation].rejected += 1;
            self.stay();
        }
    }

    /// Deposits what the current state is still due, times `scale`.
    pub fn flush(&mut self, sink: &mut impl Sink<P::Splat>, scale: f64) {
        if self.pending > 0.0 {
            deposit(&self.current, self.pending * scale / self.current_importance, sink);
        }
        self.pending = 0.0;
    }

    /// Counts so far.
    pub fn into_stats(self) -> StratumStats {
        self.stats
    }

    fn stay(&mut self) {
        self.rejections += 1;
        self.stats.longest_rejection = self.stats.longest_rejection.max(self.rejections);
    }

    /// Writes a proposal; `None` where there is none that could be accepted, which is counted here.
    fn propose(&mut self, rng: &mut impl Rng) -> Option<Candidate> {
        let Some((mutation, probability)) = self.mixture.select(&self.current, rng) else {
            self.stats.idle += 1;
            return None;
        };
        let proposed = self.mixture.mutations()[mutation].propose(&self.current, &mut self.proposal, self.stratum, rng);
        let stats = &mut self.stats.mutations[mutation];
        let Some(ratio) = proposed else {
            stats.failed += 1;
            return None;
        };
        let inside = self.stratum.contains(&self.proposal);
        let importance = if inside { self.importance.eval(&self.proposal) } else { 0.0 };
        let ratio = ratio * self.mixture.probability(mutation, &self.proposal) / probability;
        let acceptance = importance * ratio / self.current_importance;
        if !(importance.is_finite() && acceptance.is_finite() && acceptance >= 0.0) {
            stats.non_finite += 1;
            return None;
        }
        Some(Candidate { mutation, importance, acceptance: acceptance.min(1.0) })
    }
}

/// A proposal that the chain may accept.
struct Candidate {
    mutation: usize,
    importance: f64,
    acceptance: f64,
}

fn deposit<P: Path>(path: &P, weight: f64, sink: &mut impl Sink<P::Splat>) {
    path.splats().for_each(|splat| sink.deposit(splat, weight));
}
