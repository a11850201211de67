//! Mutations of light paths, one file each.

mod bidirectional;
mod caustic;
mod follow;
mod lens;
mod multi_chain;
#[cfg(test)]
mod tests;

use super::path::{LightPath, View};
use super::stratum::LightStratum;
use crate::engine::Mutation;
use rand_pcg::rand_core::Rng;

pub use bidirectional::BidirectionalMutation;
pub use caustic::CausticPerturbation;
pub use lens::LensPerturbation;
pub use multi_chain::MultiChainPerturbation;

/// One of the mutations, chosen without a virtual call.
#[derive(Clone, Copy)]
pub enum PathMutation<'a> {
    /// Deletes a subpath and traces a new one.
    Bidirectional(BidirectionalMutation<'a>),
    /// Moves the path on the image.
    Lens(LensPerturbation<'a>),
    /// Turns the light that makes a caustic.
    Caustic(CausticPerturbation<'a>),
    /// Moves the path on the image and turns what lies behind.
    MultiChain(MultiChainPerturbation<'a>),
}

impl<'a> PathMutation<'a> {
    /// All that apply to a view; that for caustics only where a surface is specular.
    pub fn all(view: View<'a>) -> Vec<Self> {
        let mut all = vec![
            Self::Bidirectional(BidirectionalMutation { view }),
            Self::Lens(LensPerturbation::new(view)),
            Self::MultiChain(MultiChainPerturbation::new(view)),
        ];
        if view.scene.has_specular() {
            all.push(Self::Caustic(CausticPerturbation { view }));
        }
        all
    }
}

impl<'a> Mutation<LightPath, LightStratum<'a>> for PathMutation<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Bidirectional(_) => "bidirectional",
            Self::Lens(_) => "lens",
            Self::Caustic(_) => "caustic",
            Self::MultiChain(_) => "multi-chain",
        }
    }

    #[inline]
    fn suitability(&self, current: &LightPath) -> f64 {
        match self {
            Self::Bidirectional(m) => m.suitability(current),
            Self::Lens(m) => m.suitability(current),
            Self::Caustic(m) => m.suitability(current),
            Self::MultiChain(m) => m.suitability(current),
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
            Self::Caustic(m) => m.propose(current, proposal, rng),
            Self::MultiChain(m) => m.propose(current, proposal, rng),
        }
    }
}
