//! Shares of a round for what a pilot decided.

use super::constants::{MUTATIONS_PER_SAMPLE, TIME_OF_A_CHAINS_RAY};
use super::decide::Decision;
use super::parts::Parts;
use crate::engine::{Measure, Share, allocate};
use crate::transport::paths::Kinds;

/// Work of chains in a round.
pub(super) struct Chains {
    /// The kinds of each of the lights' parts that they sample; of all lights as one, if these are the same everywhere.
    pub(super) kinds: Vec<Kinds>,
    /// One share for each part with any.
    pub(super) shares: Vec<Share>,
    /// Work that is to be expected over that which was promised.
    pub(super) work: f64,
    /// Error × work that is to be expected over that of the best shares.
    pub(super) excess: f64,
}

impl Decision {
    /// The same with what chains are to do in fact.
    pub(super) fn with(self, chains: &Chains) -> Self {
        Self {
            chain_work: self.chain_work * chains.work,
            chain_products: self.chain_products.map(|product| product * chains.excess),
            ..self
        }
    }
}

/// The strata of chains, and their shares of a round of so much work.
pub(super) fn share_out(
    parts: &Parts,
    decision: &Decision,
    measures: &[Measure],
    work: f64,
    mutations_per_sample: u64,
) -> Chains {
    let (kinds, unions) = unions(parts, decision, measures);
    if unions.is_empty() {
        return Chains { kinds, shares: Vec::new(), work: 1.0, excess: 1.0 };
    }
    let mut mutations = work / (2.0 * TIME_OF_A_CHAINS_RAY);
    let mut expected = 1.0;
    let mut shares = Vec::new();
    for _ in 0..3 {
        let n = (mutations.max(1.0) / unions.len() as f64) as u64;
        let even = vec![Share { mutations: n.max(1), samples: (n / MUTATIONS_PER_SAMPLE).max(1) }; unions.len()];
        shares = allocate(&unions, &even, mutations.max(1.0), mutations_per_sample);
        expected = unions.iter().zip(&shares).map(|(m, share)| work_of(m, share)).sum::<f64>() / work;
        mutations *= if expected > 0.0 { expected.recip().clamp(0.1, 10.0) } else { 1.0 };
    }
    let error: f64 = unions.iter().zip(&shares).map(|(m, share)| m.error(share)).sum();
    let best = unions.iter().map(side).sum::<f64>().powi(2);
    // Where all is dark, chains need little of what they may have.
    let [work, excess] = if best > 0.0 { [expected, error * expected * work / best] } else { [1.0; 2] };
    Chains { kinds, shares, work, excess }
}

/// The kinds that chains sample in each of the lights' parts, and what is known of them where that is anything.
///
/// Where the kinds are the same for all lights, these are one part: a chain that may go from one lamp to another mixes better.
fn unions(parts: &Parts, decision: &Decision, measures: &[Measure]) -> (Vec<Kinds>, Vec<Measure>) {
    let (mut chained, mut unions) = (Vec::new(), Vec::new());
    for (in_chains, measures) in parts.by_light(&decision.in_chains).zip(parts.by_light(measures)) {
        let of = parts.groups.iter().zip(measures).zip(in_chains).filter(|(_, chained)| **chained);
        let (kinds, measures): (Vec<Kinds>, Vec<Measure>) = of.map(|((kinds, m), _)| (kinds, *m)).unzip();
        chained.push(kinds.iter().flat_map(|kinds| kinds.iter()).fold(Kinds::NONE, Kinds::with));
        if !measures.is_empty() {
            unions.push(Measure::of_union(&measures));
        }
    }
    let all_alike = chained.windows(2).all(|pair| pair[0] == pair[1]);
    if all_alike && !parts.asked_for && !unions.is_empty() {
        return (vec![chained[0]], vec![Measure::of_union(&unions)]);
    }
    (chained, unions)
}

fn work_of(measure: &Measure, share: &Share) -> f64 {
    let rays = share.mutations as f64 * measure.mutation_cost + share.samples as f64 * measure.sample_cost;
    TIME_OF_A_CHAINS_RAY * rays
}

/// Root of the least error × work of a stratum: mutations and samples share the work in proportion to the roots of theirs.
pub(super) fn side(measure: &Measure) -> f64 {
    let of = |error: f64, rays: f64| (error * rays * TIME_OF_A_CHAINS_RAY).sqrt();
    of(measure.chain_error.unwrap_or(0.0), measure.mutation_cost) + of(measure.sample_error, measure.sample_cost)
}
