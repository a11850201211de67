//! From options to settings of the library.

use mlt_core::transport::image::Target;
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::methods::metropolis::{Variant, Weights};
use mlt_core::transport::render::{Method, Settings};

use crate::args::render::{self, RenderOptions};

/// Settings that the options ask for, in rounds of so many mutations or samples a pixel.
pub fn settings(options: &RenderOptions, per_pixel: f64) -> Settings {
    let method = match options.method() {
        render::Method::Auto => Method::Auto,
        render::Method::Mlt => Method::Metropolis,
        render::Method::Bdpt => Method::Bidirectional,
        render::Method::Pt => Method::Path,
        render::Method::Pssmlt => Method::PrimaryBidirectional,
        render::Method::Mmlt => Method::Multiplexed,
    };
    Settings::new(method, per_pixel).with(|settings| {
        settings.stratification = options.strata.lights;
        settings.classes = options.strata.classes;
        settings.adaptation.weights = match options.weights() {
            render::Weights::Power => Weights::Power,
            render::Weights::Adaptive => Weights::Adaptive,
        };
        settings.adaptation.pilot_rounds = options.rounds_pilot;
        settings.variant = match options.variant {
            render::Variant::Stratified => Variant::Stratified,
            render::Variant::MutationOnly => Variant::MutationOnly,
        };
        settings.perturbations = options.perturbations.0;
        settings.target = match options.importance {
            render::Importance::Luminance => Target::Luminance,
            render::Importance::Relative => Target::Relative,
        };
        settings.max_edges = options.max_length.map(|edges| edges as usize);
        settings.seed = options.seed;
    })
}

/// Settings for a trial of speed: what a pilot would find does not matter much to it, and the work of `auto` is that of as
/// many samples of path tracing.
pub fn without_pilot(settings: Settings) -> Settings {
    settings.with(|settings| {
        if settings.method == Method::Auto {
            settings.method = Method::Path;
        }
        if settings.stratification == Stratification::Auto {
            settings.stratification = Stratification::None;
        }
        settings.adaptation.weights = Weights::Power;
        settings.target = Target::Luminance;
    })
}
