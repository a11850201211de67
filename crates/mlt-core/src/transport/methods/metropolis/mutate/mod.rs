//! Mutations of light paths, one file each.

mod bidirectional;
mod caustic;
mod event;
mod follow;
mod from_eye;
mod lens;
mod log_uniform;
mod multi_chain;
pub(in crate::transport::methods) mod perturbations;
mod pivot;
#[cfg(test)]
mod tests;

use super::stratum::LightStratum;
use crate::engine::Mutation;
use crate::transport::paths::LightPath;
use crate::transport::scene::View;
use rand_pcg::rand_core::Rng;

pub use bidirectional::BidirectionalMutation;
pub use caustic::CausticPerturbation;
pub use lens::LensPerturbation;
pub use multi_chain::MultiChainPerturbation;
pub use perturbations::Perturbations;
pub use pivot::PivotPerturbation;

/// One of the mutations, chosen without a virtual call.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum PathMutation<'a> {
    /// Deletes a subpath and traces a new one.
    Bidirectional(BidirectionalMutation<'a>),
    /// Moves the path on the image.
    Lens(LensPerturbation<'a>),
    /// Turns the light that makes a caustic.
    Caustic(CausticPerturbation<'a>),
    /// Moves the path on the image and turns what lies behind.
    MultiChain(MultiChainPerturbation<'a>),
    /// Moves the path on the image and turns what lies behind about points on its edges.
    Pivot(PivotPerturbation<'a>),
}

impl<'a> PathMutation<'a> {
    /// All that apply to a view.
    pub fn all(view: View<'a>) -> Vec<Self> {
        Self::with(Perturbations::ALL, view)
    }

    /// The bidirectional mutation and those of the perturbations that apply to a view; that for caustics only where a surface is
    /// specular or has a narrow lobe.
    pub fn with(perturbations: Perturbations, view: View<'a>) -> Vec<Self> {
        let Perturbations { lens, multi_chain, pivot, caustic } = perturbations;
        let mut chosen = vec![Self::Bidirectional(BidirectionalMutation { view })];
        chosen.extend(lens.then(|| Self::Lens(LensPerturbation::new(view))));
        chosen.extend(multi_chain.then(|| Self::MultiChain(MultiChainPerturbation::new(view))));
        chosen.extend(pivot.then(|| Self::Pivot(PivotPerturbation::new(view))));
        let caustic = caustic && (view.scene.needs().specular || view.scene.needs().narrow);
        chosen.extend(caustic.then_some(Self::Caustic(CausticPerturbation { view })));
        chosen
    }
}

impl<'a> Mutation<LightPath, LightStratum<'a>> for PathMutation<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Bidirectional(m) => m.name(),
            Self::Lens(m) => m.name(),
            Self::Caustic(m) => m.name(),
            Self::MultiChain(m) => m.name(),
            Self::Pivot(m) => m.name(),
        }
    }

    #[inline(always)]
    fn suitability(&self, current: &LightPath) -> f64 {
        match self {
            Self::Bidirectional(m) => m.suitability(current),
            Self::Lens(m) => m.suitability(current),
            Self::Caustic(m) => m.suitability(current),
            Self::MultiChain(m) => m.suitability(current),
            Self::Pivot(m) => m.suitability(current),
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
            Self::Lens(m) => m.propose(current, proposal, within, rng),
            Self::Caustic(m) => m.propose(current, proposal, within, rng),
            Self::MultiChain(m) => m.propose(current, proposal, within, rng),
            Self::Pivot(m) => m.propose(current, proposal, within, rng),
        }
    }
}
