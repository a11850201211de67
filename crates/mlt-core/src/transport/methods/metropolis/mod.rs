//! Stratified Metropolis light transport in path space.

mod chains;
pub mod mutate;
pub(super) mod stratum;
pub(super) mod variant;

use super::adapt::Adapted;
use super::counts::PilotCounts;
use super::found::{put_shares, read_shares};
use super::run::Run;
use super::samples::paired;
use super::settings::Settings;
use super::target::importance;
use crate::engine::{Counted, DecodeError, Outcome, Reader, Share, Watch};
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightStrata;
use crate::transport::scene::View;
use chains::PathChains;
use stratum::with_met;

pub use super::adapt::{Adaptation, Weights};
pub use mutate::{PathMutation, Perturbations};
pub use stratum::LightStratum;
pub use variant::Variant;

/// Stratified Metropolis light transport.
#[derive(Debug)]
pub struct PathMetropolis<'a> {
    chains: PathChains<'a>,
    strata: LightStrata,
    shares: Vec<Share>,
    pilot: PilotCounts,
}

impl<'a> PathMetropolis<'a> {
    /// Chooses the strata and their shares. The pilot, if the settings ask for one, runs here; nothing if it is stopped.
    pub fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let importance = importance(view, &settings, watch)?;
        let chains = PathChains::new(view, settings, importance);
        let Adapted { strata, shares, tally } = chains.adapt(watch)?;
        let mut pilot = PilotCounts::of(&tally);
        let shares = match shares {
            Some(shares) => shares,
            None => {
                let (shares, rays) = chains.shares_by_power(&strata, watch)?;
                pilot.rays += rays;
                shares
            }
        };
        let shares = with_met(&chains.strata(&strata), shares);
        Some(Self { chains, strata, shares, pilot })
    }

    /// The same with what [`pilot`](Self::pilot) gives.
    pub(in crate::transport) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<Self, DecodeError> {
        let importance = PixelImportance::read(view.camera.pixels(), from)?;
        let strata = LightStrata::read(view.scene.lights(), from)?;
        let shares = read_shares(settings.mutations_per_round(view), from)?;
        let (chains, pilot) = (PathChains::new(view, settings, importance), PilotCounts::read(from)?);
        match chains.strata(&strata).len() == shares.len() {
            true => Ok(Self { chains, strata, shares, pilot }),
            false => Err(DecodeError::Damaged),
        }
    }

    /// The pilot's outcome, as bytes.
    pub(in crate::transport) fn pilot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.chains.importance().write(&mut bytes);
        self.strata.write(&mut bytes);
        put_shares(&mut bytes, &self.shares);
        self.pilot.write(&mut bytes);
        bytes
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let strata = paired(self.chains.strata(&self.strata), &self.shares);
        run.metropolis(&self.chains.estimator(&strata, &self.chains.mutations()), self.pilot)
    }
}
