//! Path tracing.

mod tracer;

use super::counts::PilotCounts;
use super::independent::{AllPaths, Independent};
use super::run::Run;
use super::settings::Settings;
use crate::engine::Outcome;
use crate::transport::lights::LightRegion;
use crate::transport::scene::View;

pub use tracer::PathTracer;
pub(super) use tracer::survival;

/// Path tracing, as often in every pixel.
#[derive(Debug)]
pub struct PathTracing<'a> {
    view: View<'a>,
    settings: Settings,
    lights: LightRegion,
}

impl<'a> PathTracing<'a> {
    /// Sets the method up.
    pub fn new(view: View<'a>, settings: Settings) -> Self {
        Self { view, settings, lights: LightRegion::whole(view.scene.lights()) }
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let (view, light_sampler, max_edges) = (self.view, self.lights.light_sampler(), self.settings.most_edges());
        let sampler = &PathTracer { view, light_sampler, max_edges, max_image_edges: max_edges, branches: 1 };
        let Settings { per_pixel: samples_per_pixel, seed, .. } = self.settings;
        let samples = Independent { sampler, selection: AllPaths, samples_per_pixel, seed };
        run.independent(&samples, PilotCounts::default())
    }
}
