//! Counts of chains.

use super::bytes::{put, put_list};
use super::count::{add_count, total_count};
use super::{Coverage, DecodeError, ExactSum, HalfChains, Rarity, Reader};

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
        total_count([self.accepted, self.rejected, self.failed, self.non_finite])
    }

    /// Accepted share of all proposals, in [0, 1]; 0 without any.
    pub fn acceptance(&self) -> f64 {
        if self.total() == 0 { 0.0 } else { self.accepted as f64 / self.total() as f64 }
    }

    /// Adds another count.
    pub fn merge(&mut self, other: &Self) {
        add_count(&mut self.accepted, other.accepted);
        add_count(&mut self.rejected, other.rejected);
        add_count(&mut self.failed, other.failed);
        add_count(&mut self.non_finite, other.non_finite);
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
    pub weight_sum: ExactSum,
    /// Sum of the squares of their importance weights.
    pub weight_squares: ExactSum,
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
    /// Work of the chains, in the unit of [`Metropolis::counting`](super::Metropolis::counting).
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
        if self.samples == 0 { 0.0 } else { self.weight_sum.value() / self.samples as f64 }
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
        (self.weight_squares.value() / n - self.b() * self.b()).max(0.0) * n / (n - 1.0)
    }

    /// Steps of the chains.
    pub fn steps(&self) -> u64 {
        total_count(self.mutations.iter().map(MutationStats::total).chain([self.idle]))
    }

    /// Adds another count of the same mixture.
    pub fn merge(&mut self, other: &Self) {
        self.mutations.resize(self.mutations.len().max(other.mutations.len()), MutationStats::default());
        self.mutations.iter_mut().zip(&other.mutations).for_each(|(a, b)| a.merge(b));
        add_count(&mut self.idle, other.idle);
        self.longest_rejection = self.longest_rejection.max(other.longest_rejection);
        add_count(&mut self.samples, other.samples);
        self.weight_sum.merge(&other.weight_sum);
        self.weight_squares.merge(&other.weight_squares);
        add_count(&mut self.non_finite_samples, other.non_finite_samples);
        add_count(&mut self.rounds, other.rounds);
        add_count(&mut self.dark_rounds, other.dark_rounds);
        add_count(&mut self.refused_starts, other.refused_starts);
        add_count(&mut self.changed_starts, other.changed_starts);
        self.coverage.merge(&other.coverage);
        self.halves.merge(&other.halves);
        self.rarity.merge(&other.rarity);
        add_count(&mut self.chain_work, other.chain_work);
        add_count(&mut self.sample_work, other.sample_work);
    }

    /// Counts in a fixed order, with which they are written.
    fn counts(&mut self) -> [&mut u64; 12] {
        let Coverage { states, astray, uncovered, shared } = &mut self.coverage;
        [
            &mut self.idle,
            &mut self.longest_rejection,
            &mut self.samples,
            &mut self.non_finite_samples,
            &mut self.rounds,
            &mut self.dark_rounds,
            &mut self.refused_starts,
            &mut self.changed_starts,
            states,
            astray,
            uncovered,
            shared,
        ]
    }

    pub(super) fn write(&self, to: &mut Vec<u8>) {
        self.clone().counts().into_iter().for_each(|count| put(to, *count));
        [self.chain_work, self.sample_work].into_iter().for_each(|work| put(to, work));
        [&self.weight_sum, &self.weight_squares].into_iter().for_each(|sum| sum.write(to));
        self.halves.write(to);
        self.rarity.write(to);
        put_list(to, &self.mutations, |to, m| {
            [m.accepted, m.rejected, m.failed, m.non_finite, m.longest_rejection].into_iter().for_each(|x| put(to, x));
        });
    }

    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let mut stats = Self::default();
        for count in stats.counts() {
            *count = from.number()?;
        }
        (stats.chain_work, stats.sample_work) = (from.number()?, from.number()?);
        (stats.weight_sum, stats.weight_squares) = (ExactSum::read(from)?, ExactSum::read(from)?);
        stats.halves = HalfChains::read(from)?;
        stats.rarity = Rarity::read(from)?;
        stats.mutations = from.list(|from| {
            let [accepted, rejected] = [from.number()?, from.number()?];
            let [failed, non_finite, longest_rejection] = [from.number()?, from.number()?, from.number()?];
            Ok(MutationStats { accepted, rejected, failed, non_finite, longest_rejection })
        })?;
        Ok(stats)
    }

    /// One mutation, and all counts as large as they can be.
    #[cfg(test)]
    pub(crate) fn of_largest_counts() -> Self {
        let mut stats = Self::new(1);
        stats.counts().into_iter().for_each(|count| *count = u64::MAX);
        (stats.chain_work, stats.sample_work) = (u64::MAX, u64::MAX);
        let [accepted, rejected, failed, non_finite, longest_rejection] = [u64::MAX; 5];
        stats.mutations[0] = MutationStats { accepted, rejected, failed, non_finite, longest_rejection };
        stats
    }
}
