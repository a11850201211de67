//! The round that suits a time budget.

use std::time::{Duration, Instant};

use mlt_core::engine::{Outcome, Watch};
use mlt_core::transport::image::Target;
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::methods::metropolis::Weights;
use mlt_core::transport::render::{Method, Renderer, Settings};
use mlt_core::transport::scene::View;

use super::Plan;
use crate::{args::render::RenderOptions, interrupt::Interrupt};

/// Time that is enough to measure the speed.
const ENOUGH: Duration = Duration::from_millis(300);
/// Mutations or samples of a task, about.
const TASK: f64 = 8192.0;

/// The size of a round.
pub(super) struct Round {
    /// Mutations or samples a pixel.
    pub per_pixel: f64,
    /// Time that a round of it takes, about; 0 where that does not matter.
    pub time: Duration,
}

impl Round {
    /// As planned, or measured to suit the time.
    pub(super) fn new(options: &RenderOptions, view: View, plan: &Plan, interrupt: &Interrupt) -> Self {
        match (plan.per_pixel, plan.time) {
            (Some(per_pixel), None) => Self { per_pixel, time: Duration::ZERO },
            _ => measured(options, view, plan, interrupt),
        }
    }
}

/// The planned round, or the one that suits a time budget, and its time, from the speed of small renders: each keeps all threads busy.
fn measured(options: &RenderOptions, view: View, plan: &Plan, interrupt: &Interrupt) -> Round {
    let time = plan.time.unwrap_or_default();
    let (start, enough) = (Instant::now(), time.mul_f64(0.01).min(ENOUGH));
    let go_on = || interrupt.go_on();
    let stopped = |size| Round { per_pixel: plan.per_pixel.unwrap_or(size), time: Duration::ZERO };
    let mut size = 1.0 / 64.0;
    loop {
        let settings = without_pilot(options.settings(size));
        let Some(trial) = Renderer::watched(view, settings, Watch::new(&go_on)) else { return stopped(size) };
        let done = if options.method().mutates() { size } else { size.max(1.0) };
        let rounds = rounds_of_trial(done * f64::from(view.camera.pixels()));
        let (mut sums, before) = (trial.sums(), Instant::now());
        if trial.render(0..rounds, &mut sums, &mut |_, _| interrupt.go_on()) == Outcome::Stopped {
            return stopped(size);
        }
        let taken = before.elapsed();
        if taken > enough || start.elapsed() > time.mul_f64(0.05) {
            let rate = rounds as f64 * done / taken.as_secs_f64().max(1e-6);
            let suitable = || plan.per_pixel_at(rate, time.saturating_sub(start.elapsed()));
            let per_pixel = plan.per_pixel.unwrap_or_else(suitable);
            return Round { per_pixel, time: Duration::from_secs_f64(per_pixel / rate) };
        }
        size *= 4.0;
    }
}

/// Rounds of so many mutations or samples that give each thread two tasks, but no more of them than that.
fn rounds_of_trial(size: f64) -> u64 {
    let most = 2 * rayon::current_num_threads() as u64;
    (most as f64 * TASK / size).clamp(1.0, most as f64) as u64
}

/// Settings for a trial of speed: what a pilot would find does not matter much to it, and the work of `auto` is that of as
/// many samples of path tracing.
fn without_pilot(settings: Settings) -> Settings {
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
