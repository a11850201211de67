//! Bidirectional path tracing.

mod connect;
mod guide;
mod met;
mod sampler;

use super::counts::PilotCounts;
use super::independent::{AllPaths, Independent};
use super::run::Run;
use super::settings::Settings;
use crate::engine::Outcome;
use crate::transport::lights::LightRegion;
use crate::transport::scene::View;

pub(crate) use guide::Guide;
pub(crate) use met::ByChance;
pub use sampler::Bidirectional;

/// Bidirectional path tracing, as often in every pixel.
#[derive(Debug)]
pub struct BidirectionalTracing<'a> {
    view: View<'a>,
    settings: Settings,
    lights: LightRegion,
}

impl<'a> BidirectionalTracing<'a> {
    /// Sets the method up.
    pub fn new(view: View<'a>, settings: Settings) -> Self {
        Self { view, settings, lights: LightRegion::whole(view.scene.lights()) }
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        let sampler = &Bidirectional { view: self.view, region: &self.lights, max_edges: self.settings.most_edges() };
        let Settings { per_pixel: samples_per_pixel, seed, .. } = self.settings;
        let samples = Independent { sampler, selection: AllPaths, samples_per_pixel, seed };
        run.independent(&samples, PilotCounts::default())
    }
}
