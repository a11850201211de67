//! Stratified Metropolis over the random numbers of a tracer.

use super::{Part, STREAMS, Tracers};
use crate::engine::{DecodeError, Metropolis, Mixture, Outcome, Reader, Share, Watch, shares_by_power};
use crate::primary::{PrimaryImportance, PrimaryMutation, PrimaryPath, PrimaryStratum};
use crate::transport::image::{PixelImportance, error_weights};
use crate::transport::lights::LightStrata;
use crate::transport::methods::adapt::{Adapted, Pilot};
use crate::transport::methods::found::Found;
use crate::transport::methods::run::{Run, metropolis};
use crate::transport::methods::samples::{fitted_shares, mutations_per_sample, paired};
use crate::transport::methods::settings::Settings;
use crate::transport::methods::target::importance;
use crate::transport::scene::View;

/// States of chains.
type State<T> = PrimaryPath<<T as Tracers>::Output, STREAMS>;
/// Strata of chains.
type PartOf<'s, T> = PrimaryStratum<<T as Tracers>::Of<'s>>;
/// Mutations of chains.
type Mutations<'s, T> = Mixture<State<T>, PartOf<'s, T>, PrimaryMutation>;

/// Stratified Metropolis over the random numbers of tracers.
#[derive(Debug)]
pub(in crate::transport) struct PrimaryMetropolis<'a, T> {
    chains: Chains<'a, T>,
    found: Found,
}

impl<'a, T: Tracers> PrimaryMetropolis<'a, T> {
    /// Chooses the strata and their shares. The pilot, if the settings ask for one, runs here; nothing if it is stopped.
    pub(in crate::transport) fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let importance = importance(view, &settings, watch)?;
        let chains = Chains::new(view, settings, importance);
        let found = Found::new(chains.adapt(watch)?, |strata| chains.shares_by_power(strata, watch))?;
        Some(Self { chains, found })
    }

    /// The same with what [`pilot`](Self::pilot) gives.
    pub(in crate::transport) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<Self, DecodeError> {
        let importance = PixelImportance::read(view.camera.pixels(), from)?;
        let found = Found::read(view, &settings, from)?;
        match found.strata.regions().len() == found.shares.len() {
            true => Ok(Self { chains: Chains::new(view, settings, importance), found }),
            false => Err(DecodeError::Damaged),
        }
    }

    /// The pilot's outcome, as bytes.
    pub(in crate::transport) fn pilot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.chains.importance.write(&mut bytes);
        self.found.write(&mut bytes);
        bytes
    }

    /// Adds rounds.
    pub(in crate::transport) fn render(&self, run: Run) -> Outcome {
        let strata = paired(self.chains.strata(&self.found.strata), &self.found.shares);
        run.metropolis(&self.chains.estimator(&strata, &self.chains.mutations()), self.found.pilot)
    }
}

/// Chains over random numbers, whatever the strata and their shares.
#[derive(Debug)]
struct Chains<'a, T> {
    view: View<'a>,
    settings: Settings,
    importance: PixelImportance,
    tracers: T,
}

impl<'a, T: Tracers> Chains<'a, T> {
    fn new(view: View<'a>, settings: Settings, importance: PixelImportance) -> Self {
        Self { view, importance, tracers: T::new(settings.most_edges()), settings }
    }

    /// The strata asked for, and their shares as far as a pilot fits them.
    fn adapt(&self, watch: Watch) -> Option<Adapted> {
        let (view, size) = (self.view, self.view.camera.size());
        let per_sample = mutations_per_sample(view, T::SAMPLES.usual);
        let pilot = Pilot {
            lights: view.scene.lights(),
            adaptation: self.settings.adaptation,
            mutations: self.mutations_per_round(),
            classes: &|_| 1,
            mutations_per_sample: per_sample,
            by_power: &|parts, mutations| shares_by_power(&self.strata(parts), mutations, per_sample),
            measure: &|parts, shares, rounds| {
                let (strata, mixture) = (paired(self.strata(parts), shares), self.mutations());
                let estimator = self.estimator(&strata, &mixture);
                let found =
                    estimator.pilot(view.camera.pixels(), rounds, &|image| error_weights(image, size), watch)?;
                Some((found.measures, found.tally))
            },
        };
        pilot.run(self.settings.stratification)
    }

    /// Shares of a round by power, with as many independent samples as are worth their work, and the rays that this took.
    fn shares_by_power(&self, parts: &LightStrata, watch: Watch) -> Option<(Vec<Share>, u64)> {
        let spread = |strata: &[_]| self.estimator(strata, &self.mutations()).spread(watch);
        fitted_shares(self.view, T::SAMPLES, self.strata(parts), self.mutations_per_round(), spread)
    }

    /// One tracer for each part of the lights, in their order.
    fn strata<'s>(&'s self, parts: &'s LightStrata) -> Vec<PartOf<'s, T>> {
        let (view, max_edges, importance) = (self.view, self.settings.most_edges(), &self.importance);
        let part = |index| Part { view, strata: parts, index, max_edges, importance };
        let of = |(index, power)| PrimaryStratum { tracer: self.tracers.of(part(index)), power };
        (0..).zip(parts.regions().iter().map(|region| region.power())).map(of).collect()
    }

    fn mutations<'s>(&self) -> Mutations<'s, T> {
        Mixture::new(PrimaryMutation::both(T::large_steps(self.view.camera.pixels())))
    }

    fn estimator<'m, 's>(
        &self,
        strata: &'m [(PartOf<'s, T>, Share)],
        mixture: &'m Mutations<'s, T>,
    ) -> Metropolis<'m, State<T>, PartOf<'s, T>, PrimaryMutation, PrimaryImportance> {
        metropolis(strata, mixture, &PrimaryImportance, self.settings.seed)
    }

    fn mutations_per_round(&self) -> f64 {
        self.settings.mutations_per_round(self.view)
    }
}
