//! Chains of a render and of its pilot.

use super::mutate::PathMutation;
use super::stratum::{LightStratum, guided, with_met};
use super::variant::Variant;
use crate::engine::{MUTATIONS_PER_SAMPLE, Metropolis, Mixture, Share, Watch, shares_by_power};
use crate::transport::image::{PixelImportance, error_weights};
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::methods::adapt::{Adaptation, Adapted, Pilot, Weights};
use crate::transport::methods::bidirectional::Guide;
use crate::transport::methods::run::metropolis;
use crate::transport::methods::samples::{Samples, fitted_shares, mutations_per_sample, paired};
use crate::transport::methods::settings::Settings;
use crate::transport::paths::LightPath;
use crate::transport::scene::View;

/// Chains over paths, whatever the strata and their shares.
#[derive(Debug)]
pub(super) struct PathChains<'a> {
    view: View<'a>,
    settings: Settings,
    importance: PixelImportance,
    /// All lights.
    lights: LightRegion,
    /// Where light that is met by chance comes from and is seen, if that is a stratum of its own.
    guide: Guide,
}

impl<'a> PathChains<'a> {
    /// With the rays that a guide took.
    pub(super) fn new(view: View<'a>, settings: Settings, importance: PixelImportance) -> (Self, u64) {
        let lights = LightRegion::whole(view.scene.lights());
        let (guide, rays) = match (settings.stratification, settings.variant) {
            (Stratification::None, _) | (_, Variant::MutationOnly) => Default::default(),
            (_, Variant::Stratified) => Guide::new(&view, &settings, &lights),
        };
        (Self { view, settings, importance, lights, guide }, rays)
    }

    pub(super) fn importance(&self) -> &PixelImportance {
        &self.importance
    }

    /// The strata asked for, and their shares as far as a pilot fits them.
    pub(super) fn adapt(&self, watch: Watch) -> Option<Adapted> {
        let (view, size) = (self.view, self.view.camera.size());
        let (max_edges, classes) = (self.settings.most_edges(), self.settings.classes);
        let weights = match self.settings.variant {
            Variant::Stratified => self.settings.adaptation.weights,
            // All paths are one stratum.
            Variant::MutationOnly => Weights::Power,
        };
        let pilot = Pilot {
            lights: view.scene.lights(),
            adaptation: Adaptation { weights, ..self.settings.adaptation },
            mutations: self.mutations_per_round(),
            classes: &|parts| LightStratum::classes_of_part(parts, view, max_edges, classes).len(),
            mutations_per_sample: mutations_per_sample(view, MUTATIONS_PER_SAMPLE),
            by_power: &|parts, mutations| {
                let strata = LightStratum::product(parts, view, max_edges, classes);
                shares_by_power(&strata, mutations, mutations_per_sample(view, MUTATIONS_PER_SAMPLE))
            },
            measure: &|parts, shares, rounds| {
                let strata = self.product(parts);
                let shares = with_met(&strata, shares.to_vec());
                let (strata, mixture) = (paired(strata, &shares), self.mutations());
                let estimator = self.estimator(&strata, &mixture);
                let found =
                    estimator.pilot(view.camera.pixels(), rounds, &|image| error_weights(image, size), watch)?;
                Some((found.measures, found.tally))
            },
        };
        pilot.run(self.settings.stratification)
    }

    /// Shares of a round by power, with as many independent samples as are worth their work, and the rays that this took.
    pub(super) fn shares_by_power(&self, parts: &LightStrata, watch: Watch) -> Option<(Vec<Share>, u64)> {
        let spread = |strata: &[_]| self.estimator(strata, &self.mutations()).spread(watch);
        fitted_shares(self.view, Samples::OF_PATHS, self.strata(parts), self.mutations_per_round(), spread)
    }

    /// The strata of paths over parts of the lights.
    pub(super) fn strata<'s>(&'s self, parts: &'s LightStrata) -> Vec<LightStratum<'s>> {
        match self.settings.variant {
            Variant::Stratified => self.product(parts),
            Variant::MutationOnly => {
                vec![LightStratum::mutation_only(parts, &self.lights, self.view, self.settings.most_edges())]
            }
        }
    }

    fn product<'s>(&'s self, parts: &'s LightStrata) -> Vec<LightStratum<'s>> {
        let (view, max_edges) = (self.view, self.settings.most_edges());
        guided(LightStratum::product(parts, view, max_edges, self.settings.classes), &self.guide)
    }

    pub(super) fn mutations<'s>(&self) -> Mixture<LightPath, LightStratum<'s>, PathMutation<'a>> {
        Mixture::new(PathMutation::with(self.settings.perturbations, self.view))
    }

    pub(super) fn estimator<'s>(
        &'s self,
        strata: &'s [(LightStratum<'s>, Share)],
        mixture: &'s Mixture<LightPath, LightStratum<'s>, PathMutation<'s>>,
    ) -> Metropolis<'s, LightPath, LightStratum<'s>, PathMutation<'s>, PixelImportance> {
        metropolis(strata, mixture, &self.importance, self.settings.seed)
    }

    fn mutations_per_round(&self) -> f64 {
        self.settings.mutations_per_round(self.view)
    }
}
