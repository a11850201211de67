//! Stratified Metropolis light transport in path space.

pub(super) mod adapt;
mod chains;
pub mod mutate;
pub(super) mod stratum;
pub(super) mod variant;

use super::counts::PilotCounts;
use super::run::Run;
use super::samples::paired;
use super::settings::Settings;
use crate::engine::{Outcome, Share, Watch};
use crate::transport::lights::LightStrata;
use crate::transport::scene::View;
use adapt::Adapted;
use chains::PathChains;
use stratum::with_met;

pub use adapt::{Adaptation, Weights};
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
        let chains = PathChains::new(view, settings, watch)?;
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

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let strata = paired(self.chains.strata(&self.strata), &self.shares);
        run.metropolis(&self.chains.estimator(&strata, &self.chains.mutations()), self.pilot)
    }
}
