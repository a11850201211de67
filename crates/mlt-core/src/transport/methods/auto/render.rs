//! Renders as a plan says.

use super::Pilot;
use super::plan::{Plan, Summary};
use super::split::{IN_VIEW, Rest, Split, Taken};
use crate::engine::{Counted, DecodeError, Mixture, Outcome, Reader, Watch};
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightRegion;
use crate::transport::methods::bidirectional::Guide;
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::independent::{AllPaths, Independent};
use crate::transport::methods::metropolis::{LightStratum, PathMutation, guided};
use crate::transport::methods::path_tracing::PathTracer;
use crate::transport::methods::run::{Run, metropolis};
use crate::transport::methods::samples::paired;
use crate::transport::methods::settings::Settings;
use crate::transport::methods::target::importance;
use crate::transport::scene::View;

/// Path tracing, and chains for what is rare in it.
#[derive(Debug)]
pub struct Auto<'a> {
    view: View<'a>,
    settings: Settings,
    common: Common,
    plan: Plan,
    split: Split,
    pilot: PilotCounts,
}

/// Used by the pilot and by all rounds.
#[derive(Debug)]
pub(super) struct Common {
    pub(super) importance: PixelImportance,
    /// All lights.
    pub(super) lights: LightRegion,
    /// Where light that is met by chance comes from and is seen.
    pub(super) guide: Guide,
}

impl Common {
    /// With the rays that the guide took.
    fn new(view: View, settings: &Settings, importance: PixelImportance) -> (Self, u64) {
        let lights = LightRegion::whole(view.scene.lights());
        let (guide, rays) = Guide::new(&view, settings, &lights);
        (Self { importance, lights, guide }, rays)
    }
}

impl<'a> Auto<'a> {
    /// Finds out how the work is shared out: the pilot runs here; nothing if it is stopped.
    pub fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let (common, rays) = Common::new(view, &settings, importance(view, &settings, watch)?);
        let (max_edges, &Settings { stratification, seed, per_pixel, .. }) = (settings.most_edges(), &settings);
        let pilot = Pilot { view, common: &common, stratification, max_edges, seed, per_pixel, watch };
        let (plan, pilot) = pilot.run()?;
        Some(Self::with(view, settings, common, (plan, pilot + PilotCounts { mutations: 0, rays })))
    }

    fn with(view: View<'a>, settings: Settings, common: Common, (plan, pilot): (Plan, PilotCounts)) -> Self {
        let split = Split::new(&plan.levels, view.camera.size(), plan.max_edges);
        Self { view, settings, common, plan, split, pilot }
    }

    /// The same with what [`pilot`](Self::pilot) gives.
    pub(in crate::transport) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<Self, DecodeError> {
        let (common, _) = Common::new(view, &settings, PixelImportance::read(view.camera.pixels(), from)?);
        let (plan, pilot) = (Plan::read(view, &settings, from)?, PilotCounts::read(from)?);
        Ok(Self::with(view, settings, common, (plan, pilot)))
    }

    /// The pilot's outcome, as bytes.
    pub(in crate::transport) fn pilot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.common.importance.write(&mut bytes);
        self.plan.write(&mut bytes);
        self.pilot.write(&mut bytes);
        bytes
    }

    /// Follows a plan of the caller's.
    pub fn with_plan(view: View<'a>, settings: Settings, plan: Plan) -> Self {
        let importance = importance(view, &settings, Watch::NEVER).expect("nothing stops it");
        let (common, _) = Common::new(view, &settings, importance);
        Self::with(view, settings, common, (plan, PilotCounts::default()))
    }

    /// The decision.
    pub fn decision(&self) -> &Summary {
        &self.plan.summary
    }

    /// Number of the stratum of what only chance meets: the last.
    pub fn met_by_chance(&self) -> Option<usize> {
        self.plan.shares.len().checked_sub(1).filter(|_| self.view.scene.needs().met_by_chance)
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let (view, plan, seed) = (self.view, &self.plan, self.settings.seed);
        let Common { importance, lights, guide } = &self.common;
        let &Plan { branches, max_edges, samples: samples_per_pixel, .. } = plan;
        let (light_sampler, max_image_edges) = (lights.light_sampler(), max_edges);
        let sampler = &PathTracer { view, light_sampler, max_edges, max_image_edges, branches };
        if plan.shares.is_empty() {
            let samples = Independent { sampler, selection: AllPaths, samples_per_pixel, seed };
            return run.independent(&samples, self.pilot);
        }
        let samples = Independent { sampler, selection: Rest(&self.split), samples_per_pixel, seed };
        let strata = LightStratum::of_kinds(&plan.strata, IN_VIEW.others(), view, self.settings.most_edges());
        let strata = guided(strata, guide);
        let (strata, mixture) = (paired(strata, &plan.shares), Mixture::new(PathMutation::all(view)));
        let taken = Taken { importance, view, lights, split: &self.split };
        run.mixture(samples, metropolis(&strata, &mixture, &taken, seed), self.pilot)
    }
}
