//! Plan of a pilot, and its reasons.

use super::candidates::{Candidate, PER_LENGTH, Sampler};
use super::decide::{Costs, Decision};
use super::parts::Parts;
use crate::engine::Share;
use crate::transport::lights::LightStrata;
use crate::transport::paths::{Kind, Kinds};

/// How a render is made.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The lights' parts.
    pub(in crate::transport) strata: LightStrata,
    /// The independent method and its samples of each pixel in a round.
    pub(in crate::transport) independent: Option<(Sampler, f64)>,
    /// The kinds of paths in each of the lights' parts that are left to chains.
    pub(in crate::transport) chained: Vec<Kinds>,
    /// Chains of a round, one share for each part with any such kinds.
    pub(in crate::transport) shares: Vec<Share>,
    /// The decision, for a report.
    pub summary: Summary,
}

impl Plan {
    /// A plan of the caller's: `chained` are the kinds in each part of the lights that chains sample, with one of `shares` for
    /// each that is not empty; the independent method takes `samples` of each pixel in a round for all other paths.
    pub fn new(
        strata: LightStrata,
        (sampler, samples): (Sampler, f64),
        chained: Vec<Kinds>,
        shares: Vec<Share>,
    ) -> Self {
        let summary = Summary { sampler: Some(sampler), chain_share: f64::NAN, parts: Vec::new() };
        Self { strata, independent: Some((sampler, samples)), chained, shares, summary }
    }

    /// The kinds of paths in each of the lights' parts that are sampled independently.
    pub(in crate::transport) fn sampled(&self) -> Vec<Kinds> {
        self.chained.iter().map(|kinds| kinds.others()).collect()
    }

    /// Most edges of these, images of lights left out or not, if no path has more than `most`.
    pub(in crate::transport) fn sampled_edges(&self, images: bool, most: usize) -> usize {
        let kinds = self.sampled().into_iter().map(|kinds| if images { kinds } else { kinds.without(Kind::IMAGE) });
        kinds.map(|kinds| kinds.most_edges(most)).max().unwrap_or(most).max(1)
    }
}

/// Decision of a pilot.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The independent method.
    pub sampler: Option<Sampler>,
    /// Share of the work, by rays and what comes with them, that chains get; NaN where no pilot measured it.
    pub chain_share: f64,
    /// Every part of path space.
    pub parts: Vec<PartSummary>,
}

/// Findings of a pilot in one part of path space.
///
/// Each noise is error × work: the part's contribution to the image's mean of Var/(L² + (L̄/10)²), times the rays that
/// were traced for it a pixel. It is infinite where a method missed what another one found, where it rests on too few
/// events, and where it is not used.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSummary {
    /// Which part of the lights.
    pub light: usize,
    /// Which paths.
    pub kinds: Kinds,
    /// Noise of path tracing.
    pub path: f64,
    /// Noise of bidirectional path tracing.
    pub bidirectional: f64,
    /// Noise of chains.
    pub chains: f64,
    /// Whether chains sample it.
    pub in_chains: bool,
}

/// A report of a decision.
pub(super) fn summary(parts: &Parts, decision: &Decision, costs: &[Costs], candidates: &[Candidate]) -> Summary {
    // Path tracing without branches and bidirectional path tracing, of paths of all lengths, are the first and the last.
    let lengths = &candidates[candidates.len() - PER_LENGTH..];
    let noise = |costs: &Costs, m: usize| costs.independent[candidates.len() - PER_LENGTH + m] * lengths[m].work;
    let part = |(i, costs): (usize, &Costs)| PartSummary {
        light: parts.at(i).light,
        kinds: parts.group(i),
        path: noise(costs, 0),
        bidirectional: noise(costs, PER_LENGTH - 1),
        chains: costs.chains,
        in_chains: decision.in_chains[i],
    };
    Summary {
        sampler: decision.independent.map(|(m, _)| candidates[m].sampler),
        chain_share: decision.chain_share(),
        parts: costs.iter().enumerate().map(part).collect(),
    }
}
