//! Renders as a plan says.

use super::candidates::Sampler;
use super::parts::SomePaths;
use super::plan::{Plan, Summary};
use super::{Pilot, PilotCounts};
use crate::engine::{Counted, DecodeError, Metropolis, Mixture, Outcome, Reader, Share, Watch};
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightRegion;
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::methods::independent::{AllPaths, ImageSampler, Independent};
use crate::transport::methods::metropolis::{LightStratum, PathMutation};
use crate::transport::methods::path_tracing::PathTracer;
use crate::transport::methods::run::{Run, metropolis};
use crate::transport::methods::samples::paired;
use crate::transport::methods::settings::Settings;
use crate::transport::methods::target::importance;
use crate::transport::paths::LightPath;
use crate::transport::scene::View;

/// Independent samples where they are better, Metropolis where it pays.
#[derive(Debug)]
pub struct Auto<'a> {
    view: View<'a>,
    settings: Settings,
    importance: PixelImportance,
    lights: LightRegion,
    plan: Plan,
    pilot: PilotCounts,
}

impl<'a> Auto<'a> {
    /// Finds out which part of path space is sampled how: the pilot runs here; nothing if it is stopped.
    pub fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let (importance, lights) = (importance(view, &settings, watch)?, LightRegion::whole(view.scene.lights()));
        let (max_edges, &Settings { stratification, seed, per_pixel, .. }) = (settings.most_edges(), &settings);
        let pilot =
            Pilot { view, importance: &importance, lights: &lights, stratification, max_edges, seed, per_pixel, watch };
        let (plan, pilot) = pilot.run()?;
        Some(Self { view, settings, importance, lights, plan, pilot })
    }

    /// The same with what [`pilot`](Self::pilot) gives.
    pub(in crate::transport) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<Self, DecodeError> {
        let importance = PixelImportance::read(view.camera.pixels(), from)?;
        let (plan, lights) = (Plan::read(view, &settings, from)?, LightRegion::whole(view.scene.lights()));
        Ok(Self { view, settings, importance, lights, plan, pilot: PilotCounts::read(from)? })
    }

    /// The pilot's outcome, as bytes.
    pub(in crate::transport) fn pilot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.importance.write(&mut bytes);
        self.plan.write(&mut bytes);
        self.pilot.write(&mut bytes);
        bytes
    }

    /// Follows a plan of the caller's.
    pub fn with_plan(view: View<'a>, settings: Settings, plan: Plan) -> Self {
        let importance = importance(view, &settings, Watch::NEVER).expect("nothing stops it");
        let lights = LightRegion::whole(view.scene.lights());
        Self { view, settings, importance, lights, plan, pilot: PilotCounts::default() }
    }

    /// The decision.
    pub fn decision(&self) -> &Summary {
        &self.plan.summary
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let (view, region) = (self.view, &self.lights);
        let edges = |images| self.plan.sampled_edges(images, self.settings.most_edges());
        let (max_edges, max_image_edges) = (edges(false), edges(view.scene.needs().specular));
        match self.plan.independent {
            None => self.chains(run),
            Some((Sampler::Path { branches }, samples)) => {
                let light_sampler = region.light_sampler();
                self.mixture(&PathTracer { view, light_sampler, max_edges, max_image_edges, branches }, samples, run)
            }
            Some((Sampler::Bidirectional, samples)) => {
                self.mixture(&Bidirectional { view, region, max_edges: max_image_edges }, samples, run)
            }
        }
    }

    /// Chains alone.
    fn chains(&self, run: Run) -> Outcome {
        let (strata, mixture) = (self.strata(), Mixture::new(PathMutation::all(self.view)));
        run.metropolis(&self.estimator(&strata, &mixture), self.pilot)
    }

    /// Independent samples of what is not left to chains, and chains for the rest.
    fn mixture<T: ImageSampler>(&self, sampler: &T, samples_per_pixel: f64, run: Run) -> Outcome {
        let (plan, seed) = (&self.plan, self.settings.seed);
        if plan.shares.is_empty() {
            let samples = Independent { sampler, selection: AllPaths, samples_per_pixel, seed };
            return run.independent(&samples, self.pilot);
        }
        let kinds = plan.sampled();
        let selection = SomePaths { lights: self.view.scene.lights(), strata: &plan.strata, kinds: &kinds };
        let (strata, mixture) = (self.strata(), Mixture::new(PathMutation::all(self.view)));
        let samples = Independent { sampler, selection, samples_per_pixel, seed };
        run.mixture(samples, self.estimator(&strata, &mixture), self.pilot)
    }

    fn strata(&self) -> Vec<(LightStratum<'_>, Share)> {
        let Plan { strata, chained, shares, .. } = &self.plan;
        paired(LightStratum::of_kinds(strata, chained, self.view, self.settings.most_edges()), shares)
    }

    fn estimator<'s>(
        &'s self,
        strata: &'s [(LightStratum<'s>, Share)],
        mixture: &'s Mixture<LightPath, LightStratum<'s>, PathMutation<'s>>,
    ) -> Metropolis<'s, LightPath, LightStratum<'s>, PathMutation<'s>, PixelImportance> {
        metropolis(strata, mixture, &self.importance, self.settings.seed)
    }
}
