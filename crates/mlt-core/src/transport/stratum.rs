//! The strata of path space over the lights, as the engine sees them.

use super::bdpt::Bidirectional;
use super::path::{LightPath, View};
use super::region::LightRegion;
use super::strata::LightStrata;
use crate::engine::Stratum;
use rand_pcg::rand_core::Rng;

/// Ω_j: the paths that start in part j of the lights and have no more than a given number of edges.
///
/// Source: [Jankauski15], section 4.1.
#[derive(Clone, Copy)]
pub struct LightStratum<'a> {
    strata: &'a LightStrata,
    index: u32,
    sampler: Bidirectional<'a>,
}

impl<'a> LightStratum<'a> {
    /// All strata of a view, in the order of their parts.
    pub fn all(strata: &'a LightStrata, view: View<'a>, max_edges: usize) -> Vec<Self> {
        let of = |(index, region)| Self { strata, index, sampler: Bidirectional { view, region, max_edges } };
        (0..).zip(strata.regions()).map(of).collect()
    }

    /// Where x_0 is drawn.
    pub fn region(&self) -> &'a LightRegion {
        self.sampler.region
    }

    /// Most edges of a path.
    pub fn max_edges(&self) -> usize {
        self.sampler.max_edges
    }
}

impl Stratum<LightPath> for LightStratum<'_> {
    #[inline]
    fn contains(&self, path: &LightPath) -> bool {
        self.strata.index(path.light()) == self.index && path.edges() <= self.sampler.max_edges
    }

    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        self.sampler.sample(rng, &mut |path, weight| {
            if self.contains(path) {
                visit(path, weight);
            }
        });
    }

    fn power(&self) -> f64 {
        self.sampler.region.power()
    }
}
