//! What chains count.

use super::{Coverage, HalfChains, Rarity};

/// Outcomes of one mutation's proposals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MutationStats {
    /// Proposals that became the current state.
    pub accepted: u64,
    /// Proposals that did not.
    pub rejected: u64,
    /// Constructions that gave no proposal; they count as rejections in an acceptance rate.
    pub failed: u64,
    /// Proposals with a NaN or infinite importance or ratio, rejected.
    pub non_finite: u64,
    /// Longest run of its proposals, in one chain, of which none was accepted.
    pub longest_rejection: u64,
}

impl MutationStats {
    /// All proposals, failed ones included.
    pub fn total(&self) -> u64 {
        self.accepted + self.rejected + self.failed + self.non_finite
    }

    /// Accepted share of all proposals, in [0, 1]; 0 without any.
    pub fn acceptance(&self) -> f64 {
        if self.total() == 0 { 0.0 } else { self.accepted as f64 / self.total() as f64 }
    }

    /// Adds another count.
    pub fn merge(&mut self, other: &Self) {
        self.accepted += other.accepted;
        self.rejected += other.rejected;
        self.failed += other.failed;
        self.non_finite += other.non_finite;
        self.longest_rejection = self.longest_rejection.max(other.longest_rejection);
    }
}

/// Counts and bootstrap sums of one stratum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StratumStats {
    /// One entry a mutation, in the mixture's order.
    pub mutations: Vec<MutationStats>,
    /// Steps at states to which no mutation applied.
    pub idle: u64,
    /// Longest run of steps without an acceptance.
    pub longest_rejection: u64,
    /// Independent samples drawn for b_j.
    pub samples: u64,
    /// Sum of their importance weights.
    pub weight_sum: f64,
    /// Sum of the squares of their importance weights.
    pub weight_squares: f64,
    /// Independent samples with a NaN or infinite weight, taken as 0.
    pub non_finite_samples: u64,
    /// Rounds.
    pub rounds: u64,
    /// Those in which no sample had a positive weight: they ran no chain here.
    pub dark_rounds: u64,
    /// Chains that could not start because their first state, made again, had no importance: their share is missing.
    pub refused_starts: u64,
    /// Chains whose first state's sample, made again, had another weight: it is not a function of its random numbers.
    pub changed_starts: u64,
    /// Where states lie that samples and chains met.
    pub coverage: Coverage,
    /// Whether the chains agree.
    pub halves: HalfChains,
    /// How often samples meet what the chains visit.
    pub rarity: Rarity,
    /// Work of the chains, in the unit of [`Metropolis::work`](super::Metropolis::counting).
    pub chain_work: u64,
    /// Work of the independent samples, in the same unit.
    pub sample_work: u64,
}

impl StratumStats {
    /// No counts, for `mutations` mutations.
    pub fn new(mutations: usize) -> Self {
        Self { mutations: vec![MutationStats::default(); mutations], ..Self::default() }
    }

    /// b_j, the integral of the importance over the stratum: the mean weight of the independent samples.
    pub fn b(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { self.weight_sum / self.samples as f64 }
    }

    /// Standard error of [`b`](Self::b); infinite with fewer than two samples.
    pub fn b_stderr(&self) -> f64 {
        if self.samples < 2 { f64::INFINITY } else { (self.weight_variance() / self.samples as f64).sqrt() }
    }

    /// Variance of one sample's importance weight; infinite with fewer than two samples.
    pub fn weight_variance(&self) -> f64 {
        if self.samples < 2 {
            return f64::INFINITY;
        }
        let n = self.samples as f64;
        (self.weight_squares / n - self.b() * self.b()).max(0.0) * n / (n - 1.0)
    }

    /// Steps of the chains.
    pub fn steps(&self) -> u64 {
        self.idle + self.mutations.iter().map(MutationStats::total).sum::<u64>()
    }

    /// Adds another count of the same mixture.
    pub fn merge(&mut self, other: &Self) {
        self.mutations.resize(self.mutations.len().max(other.mutations.len()), MutationStats::default());
        self.mutations.iter_mut().zip(&other.mutations).for_each(|(a, b)| a.merge(b));
        self.idle += other.idle;
        self.longest_rejection = self.longest_rejection.max(other.longest_rejection);
        self.samples += other.samples;
        self.weight_sum += other.weight_sum;
        self.weight_squares += other.weight_squares;
        self.non_finite_samples += other.non_finite_samples;
        self.rounds += other.rounds;
        self.dark_rounds += other.dark_rounds;
        self.refused_starts += other.refused_starts;
        self.changed_starts += other.changed_starts;
        self.coverage.merge(&other.coverage);
        self.halves.merge(&other.halves);
        self.rarity.merge(&other.rarity);
        self.chain_work += other.chain_work;
        self.sample_work += other.sample_work;
    }
}
