//! From options to settings of the library.

use mlt_core::transport::image::Target;
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::methods::metropolis::{Adaptation, Variant, Weights};
use mlt_core::transport::render::{Method, Settings};

use crate::args::render::{self, RenderOptions};

/// What the options ask for, in rounds of so many mutations or samples a pixel.
pub fn settings(options: &RenderOptions, per_pixel: f64) -> Settings {
    Settings {
        method: match options.method() {
            render::Method::Auto => Method::Auto,
            render::Method::Mlt => Method::Metropolis,
            render::Method::Bdpt => Method::Bidirectional,
            render::Method::Pt => Method::Path,
            render::Method::Pssmlt => Method::PrimaryBidirectional,
            render::Method::Mmlt => Method::Multiplexed,
        },
        stratification: options.strata.lights,
        classes: options.strata.classes,
        adaptation: Adaptation {
            weights: match options.weights() {
                render::Weights::Power => Weights::Power,
                render::Weights::Adaptive => Weights::Adaptive,
            },
            pilot_rounds: options.rounds_pilot,
        },
        variant: match options.variant {
            render::Variant::Stratified => Variant::Stratified,
            render::Variant::MutationOnly => Variant::MutationOnly,
        },
        perturbations: options.perturbations.0,
        target: match options.importance {
            render::Importance::Luminance => Target::Luminance,
            render::Importance::Relative => Target::Relative,
        },
        max_edges: options.max_length.map(|edges| edges as usize),
        seed: options.seed,
        per_pixel,
    }
}

/// Settings for a trial of speed: what a pilot would find does not matter much to it, and the work of `auto` is that of as
/// many samples of path tracing.
pub fn without_pilot(settings: Settings) -> Settings {
    let method = if settings.method == Method::Auto { Method::Path } else { settings.method };
    let stratification = match settings.stratification {
        Stratification::Auto => Stratification::None,
        other => other,
    };
    let adaptation = Adaptation { weights: Weights::Power, ..settings.adaptation };
    Settings { method, stratification, adaptation, target: Target::Luminance, ..settings }
}
