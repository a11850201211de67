//! The independent methods that a render may use.

use super::constants::{BRANCHES, LENGTHS, TIME_OF_A_BIDIRECTIONAL_RAY};
use super::measure::work_of;
use crate::transport::lights::LightRegion;
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::methods::path_tracing::PathTracer;
use crate::transport::paths::{Kind, Kinds};
use crate::transport::scene::View;

/// An independent method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampler {
    /// Path tracing.
    Path {
        /// Walks that go on from the first surface.
        branches: u32,
    },
    /// Bidirectional path tracing.
    Bidirectional,
}

/// Candidates for each limit of length: path tracing with each number of branches, and bidirectional path tracing.
pub(super) const PER_LENGTH: usize = BRANCHES.len() + 1;

/// An independent method that samples paths up to some length.
pub(super) struct Candidate {
    pub(super) sampler: Sampler,
    pub(super) max_edges: usize,
    /// Time of a sample of these paths alone, in rays of path tracing.
    pub(super) work: f64,
    /// Error of one sample over that which the pilot measured of this method, for paths of at most two edges and for longer
    /// ones.
    scale: [f64; 2],
}

impl Candidate {
    /// All methods, for paths of all lengths and for shorter ones.
    pub(super) fn all(view: View, region: &LightRegion, most: usize, seed: u64) -> Vec<Self> {
        let light_sampler = region.light_sampler();
        let lengths = LENGTHS.iter().map(|[_, edges]| *edges).filter(|&edges| edges < most);
        let of_length = |max_edges| {
            let path = |branches| {
                work_of(&PathTracer { view, light_sampler, max_edges, max_image_edges: most, branches }, seed)
            };
            let bidirectional = Self {
                sampler: Sampler::Bidirectional,
                max_edges,
                work: work_of(&Bidirectional { view, region, max_edges }, seed) * TIME_OF_A_BIDIRECTIONAL_RAY,
                scale: [1.0; 2],
            };
            let (one, two) = (path(1), path(2));
            let splits = BRANCHES.map(|branches| Self::path(branches, max_edges, one, two - one));
            splits.into_iter().chain([bidirectional])
        };
        lengths.chain([most]).flat_map(of_length).collect()
    }

    /// Path tracing, `one` being the work of a sample that does not split and `branch` that of another branch.
    ///
    /// K branches divide the variance of what they bring by K. For the light that comes to the first surface at once, fewer
    /// samples are left, which are less well spread: n samples have a variance of about n^(−3/2), Sobol points across
    /// discontinuities.
    fn path(branches: u32, max_edges: usize, one: f64, branch: f64) -> Self {
        let work = one + f64::from(branches - 1) * branch.max(0.0);
        let scale = [(work / one).sqrt(), 1.0 / f64::from(branches)];
        Self { sampler: Sampler::Path { branches }, max_edges, work, scale }
    }

    /// Factor of the measured error of paths of some kinds, of at most `most` edges; infinite if they are not
    /// sampled. Path tracing follows images of lights to their ends, and branches follow the same ones in a mirror.
    pub(super) fn scale(&self, kinds: Kinds, most: usize) -> f64 {
        let longest = kinds.without(Kind::IMAGE).most_edges(most);
        let sampled = longest <= self.max_edges && (self.is_path() || kinds.most_edges(most) <= self.max_edges);
        if sampled { self.scale[usize::from(longest > 2)] } else { f64::INFINITY }
    }

    /// Whether it is path tracing, with any number of branches.
    pub(super) fn is_path(&self) -> bool {
        self.sampler != Sampler::Bidirectional
    }
}
