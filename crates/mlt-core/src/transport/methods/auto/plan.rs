//! Plan of a pilot, and its reasons.

use super::levels::Levels;
use crate::engine::Share;
use crate::transport::lights::LightStrata;

/// How a render is made.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The lights' parts, each a stratum of the chains.
    pub(super) strata: LightStrata,
    /// The levels that decide between samples and chains.
    pub(super) levels: Levels,
    /// Walks of path tracing that go on from the first surface.
    pub(super) branches: u32,
    /// Most edges of its paths.
    pub(super) max_edges: usize,
    /// Its samples of each pixel in a round.
    pub(super) samples: f64,
    /// Chains of a round in each of the strata; none: path tracing alone.
    pub(super) shares: Vec<Share>,
    /// The decision, for a report.
    pub(super) summary: Summary,
}

impl Plan {
    /// A plan of the caller's: path tracing with `samples` of each pixel in a round, and chains with one of `shares` for each of the strata, and one
    /// more where a scene has paths that only chance meets ([`Needs`](crate::transport::scene::Needs)); `level` is the luminance that every pixel is expected to show.
    pub fn new(
        strata: LightStrata,
        (level, samples): (f64, f64),
        [branches, max_edges]: [usize; 2],
        shares: Vec<Share>,
    ) -> Self {
        let [chain_share, hard_light, path, mixture] = [f64::NAN; 4];
        let summary =
            Summary { branches: branches as u32, lamps_only: max_edges == 1, chain_share, hard_light, path, mixture };
        Self { strata, levels: Levels::even(level), branches: branches as u32, max_edges, samples, shares, summary }
    }
}

/// Decision of a pilot.
///
/// Each noise is error × work: the mean over pixels of Var/(L² + (L̄/10)²), times the rays that are traced for it a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Walks of path tracing that go on from the first surface.
    pub branches: u32,
    /// Whether it takes lamps in view only, and chains all else.
    pub lamps_only: bool,
    /// Share of the work, by rays and what comes with them, that chains get.
    pub chain_share: f64,
    /// Share of the light, lamps in view left out, that is worth so much to samples that chains would take it.
    pub hard_light: f64,
    /// Noise of path tracing alone.
    pub path: f64,
    /// Noise of both together.
    pub mixture: f64,
}
