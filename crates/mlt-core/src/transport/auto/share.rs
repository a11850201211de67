//! Shares of a round for what a pilot decided.

use super::decide::Decision;
use super::parts::Parts;
use super::{MUTATIONS_A_SAMPLE, TIME_OF_A_CHAINS_RAY};
use crate::engine::{Measure, Share, allocate};
use crate::transport::kind::Kinds;

/// The kinds of each of the lights' parts that chains sample, and their shares of a round of so much work.
pub(super) fn share_out(
    parts: &Parts,
    decision: &Decision,
    measures: &[Measure],
    work: f64,
    mutations_a_sample: u64,
) -> (Vec<Kinds>, Vec<Share>) {
    let (mut chained, mut unions) = (Vec::new(), Vec::new());
    let groups = parts.groups.len();
    for (in_chains, measures) in decision.in_chains.chunks(groups).zip(measures.chunks(groups)) {
        let of = parts.groups.iter().zip(measures).zip(in_chains).filter(|(_, chained)| **chained);
        let (kinds, measures): (Vec<Kinds>, Vec<Measure>) = of.map(|((kinds, m), _)| (kinds, *m)).unzip();
        chained.push(kinds.iter().flat_map(|kinds| kinds.iter()).fold(Kinds::NONE, Kinds::with));
        if !measures.is_empty() {
            unions.push(Measure::of_union(&measures));
        }
    }
    let mut mutations = work / (2.0 * TIME_OF_A_CHAINS_RAY);
    let mut shares = Vec::new();
    for _ in 0..3 {
        let n = (mutations.max(1.0) / unions.len().max(1) as f64) as u64;
        let even = vec![Share { mutations: n.max(1), samples: (n / MUTATIONS_A_SAMPLE).max(1) }; unions.len()];
        shares = allocate(&unions, &even, mutations.max(1.0), mutations_a_sample);
        let cost = |(share, m): (&Share, &Measure)| {
            share.mutations as f64 * m.mutation_cost + share.samples as f64 * m.sample_cost
        };
        let expected = TIME_OF_A_CHAINS_RAY * shares.iter().zip(&unions).map(cost).sum::<f64>();
        mutations *= if expected > 0.0 { (work / expected).clamp(0.1, 10.0) } else { 1.0 };
    }
    (chained, shares)
}

/// Samples of each pixel in a round of so much work a pixel: about the independent method's share, but the first 2^k points
/// of a sequence, which are much better spread than any other number of them.
pub(super) fn good_number(budget: f64, decision: &Decision, work: f64) -> f64 {
    let ideal = (budget * (1.0 - decision.chain_share) / work).max(1.0);
    let lower = libm::exp2(libm::floor(libm::log2(ideal)));
    // Chains keep half of their share at least.
    let room = decision.chain_share == 0.0 || 2.0 * lower * work <= budget * (1.0 - 0.5 * decision.chain_share);
    if ideal > std::f64::consts::SQRT_2 * lower && room { 2.0 * lower } else { lower }
}
