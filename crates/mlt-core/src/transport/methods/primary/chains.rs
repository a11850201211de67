//! Chains of the two methods in primary sample space.

use super::Part;
use crate::engine::{
    Counted, DecodeError, Importance, Mixture, Mutation, Outcome, Path, Reader, Share, Splat, Stratum, Watch,
};
use crate::primary::{PrimaryImportance, PrimaryMutation};
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightStrata;
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::found::{put_shares, read_shares};
use crate::transport::methods::run::{Run, metropolis};
use crate::transport::methods::samples::{Samples, fitted_shares};
use crate::transport::methods::settings::Settings;
use crate::transport::methods::target::importance;
use crate::transport::scene::View;

/// Chains over random numbers, whatever is made of them.
#[derive(Debug)]
pub(super) struct PrimaryChains<'a> {
    view: View<'a>,
    settings: Settings,
    importance: PixelImportance,
    strata: LightStrata,
}

impl<'a> PrimaryChains<'a> {
    pub(super) fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let importance = importance(view, &settings, watch)?;
        Some(Self::with_importance(view, settings, importance))
    }

    fn with_importance(view: View<'a>, settings: Settings, importance: PixelImportance) -> Self {
        let strata = LightStrata::new(view.scene.lights(), settings.stratification);
        Self { view, importance, strata, settings }
    }

    /// The chains, the shares of their strata and what finding them took, from what [`found`](Self::found) gives.
    pub(super) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<(Self, Vec<Share>, PilotCounts), DecodeError> {
        let importance = PixelImportance::read(view.camera.pixels(), from)?;
        let shares = read_shares(settings.mutations_per_round(view), from)?;
        let (chains, pilot) = (Self::with_importance(view, settings, importance), PilotCounts::read(from)?);
        match chains.strata.regions().len() == shares.len() {
            true => Ok((chains, shares, pilot)),
            false => Err(DecodeError::Damaged),
        }
    }

    /// Findings before the first round, as bytes.
    pub(super) fn found(&self, shares: &[Share], pilot: PilotCounts) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.importance.write(&mut bytes);
        put_shares(&mut bytes, shares);
        pilot.write(&mut bytes);
        bytes
    }

    /// State that the tracers share.
    pub(super) fn part(&self) -> Part<'_, PixelImportance> {
        let (view, strata, max_edges) = (self.view, &self.strata, self.settings.most_edges());
        Part { view, strata, index: 0, max_edges, importance: &self.importance }
    }

    /// Pixels of the image.
    pub(super) fn pixels(&self) -> u32 {
        self.view.camera.pixels()
    }

    /// Shares of a round, and what finding them took; nothing if that is stopped.
    pub(super) fn shares<P, S>(
        &self,
        strata: Vec<S>,
        samples: Samples,
        watch: Watch,
    ) -> Option<(Vec<Share>, PilotCounts)>
    where
        P: Path,
        S: Stratum<P> + Sync,
        PrimaryMutation: Mutation<P, S> + Sync,
        PrimaryImportance: Importance<P>,
    {
        let mixture = Mixture::<P, S, PrimaryMutation>::new(Vec::new());
        let spread = |strata: &[_]| metropolis(strata, &mixture, &PrimaryImportance, self.settings.seed).spread(watch);
        let mutations = self.settings.mutations_per_round(self.view);
        let (shares, rays) = fitted_shares(self.view, samples, strata, mutations, spread)?;
        Some((shares, PilotCounts { mutations: 0, rays }))
    }

    /// Adds rounds.
    pub(super) fn render<P, S>(&self, strata: &[(S, Share)], large_steps: f64, pilot: PilotCounts, run: Run) -> Outcome
    where
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        PrimaryMutation: Mutation<P, S> + Sync,
        PrimaryImportance: Importance<P>,
    {
        let mixture = Mixture::new(PrimaryMutation::both(large_steps));
        run.metropolis(&metropolis(strata, &mixture, &PrimaryImportance, self.settings.seed), pilot)
    }
}
