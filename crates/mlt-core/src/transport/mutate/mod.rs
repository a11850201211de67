//! Mutations of light paths, one file each.

mod bidirectional;
mod lens;

use super::path::{LightPath, View};
use super::stratum::LightStratum;
use crate::engine::Mutation;
use rand_pcg::rand_core::Rng;

pub use bidirectional::BidirectionalMutation;
pub use lens::LensPerturbation;

/// One of the mutations, chosen without a virtual call.
#[derive(Clone, Copy)]
pub enum PathMutation<'a> {
    /// Deletes a subpath and traces a new one.
    Bidirectional(BidirectionalMutation<'a>),
    /// Moves the path on the image.
    Lens(LensPerturbation<'a>),
}

impl<'a> PathMutation<'a> {
    /// All that apply to a view.
    pub fn all(view: View<'a>) -> Vec<Self> {
        vec![Self::Bidirectional(BidirectionalMutation { view }), Self::Lens(LensPerturbation { view })]
    }
}

impl<'a> Mutation<LightPath, LightStratum<'a>> for PathMutation<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Bidirectional(_) => "bidirectional",
            Self::Lens(_) => "lens",
        }
    }

    #[inline]
    fn suitability(&self, current: &LightPath) -> f64 {
        match self {
            Self::Bidirectional(m) => m.suitability(current),
            Self::Lens(m) => m.suitability(current),
        }
    }

    #[inline]
    fn propose(
        &self,
        current: &LightPath,
        proposal: &mut LightPath,
        within: &LightStratum<'a>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        match self {
            Self::Bidirectional(m) => m.propose(current, proposal, within, rng),
            Self::Lens(m) => m.propose(current, proposal, rng),
        }
    }
}
