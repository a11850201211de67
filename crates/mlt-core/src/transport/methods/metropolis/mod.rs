//! Stratified Metropolis light transport in path space.

mod chains;
pub mod mutate;
pub(super) mod stratum;
pub(super) mod variant;

use super::counts::PilotCounts;
use super::found::Found;
use super::run::Run;
use super::samples::paired;
use super::settings::Settings;
use super::target::importance;
use crate::engine::{DecodeError, Outcome, Reader, Watch};
use crate::transport::image::PixelImportance;
use crate::transport::scene::View;
use chains::PathChains;
pub(crate) use stratum::guided;
use stratum::with_met;

pub use super::adapt::{Adaptation, Weights};
pub use mutate::{PathMutation, Perturbations};
pub use stratum::LightStratum;
pub use variant::Variant;

/// Stratified Metropolis light transport.
#[derive(Debug)]
pub struct PathMetropolis<'a> {
    chains: PathChains<'a>,
    found: Found,
}

impl<'a> PathMetropolis<'a> {
    /// Chooses the strata and their shares. The pilot, if the settings ask for one, runs here; nothing if it is stopped.
    pub fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let importance = importance(view, &settings, watch)?;
        let (chains, rays) = PathChains::new(view, settings, importance);
        let Found { strata, shares, pilot } =
            Found::new(chains.adapt(watch)?, |strata| chains.shares_by_power(strata, watch))?;
        let shares = with_met(&chains.strata(&strata), shares);
        let pilot = pilot + PilotCounts { mutations: 0, rays };
        Some(Self { chains, found: Found { strata, shares, pilot } })
    }

    /// The same with what [`pilot`](Self::pilot) gives.
    pub(in crate::transport) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<Self, DecodeError> {
        let importance = PixelImportance::read(view.camera.pixels(), from)?;
        let found = Found::read(view, &settings, from)?;
        let (chains, _) = PathChains::new(view, settings, importance);
        match chains.strata(&found.strata).len() == found.shares.len() {
            true => Ok(Self { chains, found }),
            false => Err(DecodeError::Damaged),
        }
    }

    /// The pilot's outcome, as bytes.
    pub(in crate::transport) fn pilot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.chains.importance().write(&mut bytes);
        self.found.write(&mut bytes);
        bytes
    }

    /// Number of the stratum of what only chance meets.
    pub fn met_by_chance(&self) -> Option<usize> {
        self.chains.strata(&self.found.strata).iter().position(LightStratum::is_met)
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let strata = paired(self.chains.strata(&self.found.strata), &self.found.shares);
        run.metropolis(&self.chains.estimator(&strata, &self.chains.mutations()), self.found.pilot)
    }
}
