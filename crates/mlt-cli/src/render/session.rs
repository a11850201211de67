//! Rounds until the end.

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

use mlt_core::{
    engine::{Film, Outcome},
    transport::{
        path::View,
        render::{Counts, Renderer, relative_error},
    },
};

use super::{
    Plan, Setup,
    blocks::Blocks,
    ending::{Ending, STEPS},
    settings::{settings, without_pilot},
    summary::report,
};
use crate::{
    Failure,
    args::render::{self, RenderOptions},
    cpu_seconds,
    interrupt::Interrupt,
    progress::Progress,
    report::Report,
    report::{Agreement, Decision},
    require_memory,
};

/// Time that is enough to measure the speed.
const ENOUGH: Duration = Duration::from_millis(300);
/// Bytes of a round for each of its mutations: a 32nd of an independent sample, and the counts of short chains.
const BYTES_PER_MUTATION: f64 = 0.6;
/// Bytes for each sample of the pixels in work, two a thread: its deposits.
const BYTES_PER_SAMPLE: f64 = 64.0;
/// A render that is over.
pub struct Finished {
    /// Its image.
    pub film: Film<3>,
    /// Its report, without the files.
    pub report: Report,
    /// Mutations or samples a pixel of one round.
    pub per_pixel: f64,
    /// What each round gave each block of the image.
    pub blocks: Blocks,
}

/// Renders on the current rayon pool.
pub fn run(options: &RenderOptions, setup: &Setup, plan: Plan, interrupt: &Interrupt) -> Result<Finished, Failure> {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let view = View { scene: &setup.scene, camera: &setup.camera };
    let per_pixel = plan.per_pixel.unwrap_or_else(|| measured(options, view, &plan, interrupt));
    require_memory_for_round(options.method(), per_pixel, f64::from(setup.camera.pixels()))?;
    let renderer = Renderer::new(view, settings(options, per_pixel));
    let (mut film, mut counts) = (renderer.film(), Counts::default());
    let mut ending = Ending::new(plan, interrupt.clone(), start);
    let progress = Progress::new(STEPS, options.method().unit(), options.quiet);
    let pixels = f64::from(setup.camera.pixels());
    let first = options.first_round;
    let last = plan.rounds.map_or(u64::MAX, |rounds| first.saturating_add(rounds));
    let (watched, mut error) = (progress.is_shown() || plan.error.is_some(), None);
    let mut blocks = Blocks::new(setup.camera.size());
    let outcome = renderer.render(first..last, &mut film, &mut counts, &mut |at, film| {
        if at.fraction == 0.0 {
            blocks.add(film);
        }
        if watched && at.rounds > 1 && at.fraction == 0.0 {
            error = Some(relative_error(film)).filter(|error| error.is_finite());
        }
        let done = at.rounds as f64 + at.fraction;
        let rate = done * per_pixel * pixels / start.elapsed().as_secs_f64();
        progress.update(ending.share(done, error), rate, error);
        ending.reached(at.rounds, at.fraction == 0.0, error)
    });
    progress.finish();
    let interrupted = outcome == Outcome::Stopped && interrupt.requested();
    if film.rounds() == 0 {
        let (what, code): (_, fn(anyhow::Error) -> Failure) = match interrupted {
            true => ("interrupted before the first round was finished; nothing is written", Failure::InterruptedEarly),
            false => ("the time was over before the first round was finished; give it more", Failure::Run),
        };
        return Err(code(anyhow::anyhow!(what)));
    }
    let mut report = report(options, setup, &film, &counts);
    report.agreement = blocks.agreement().filter(|_| counts.steps() > 0);
    report.warnings.extend(report.agreement.as_ref().and_then(Agreement::warning));
    report.decision = renderer.decision().map(Decision::from);
    report.interrupted = interrupted;
    report.seconds = start.elapsed().as_secs_f64();
    report.cpu_seconds = cpu_seconds().zip(cpu).map(|(now, then)| now - then);
    Ok(Finished { film, report, per_pixel, blocks })
}

/// The size of a round that suits a time budget, from the speed of a small render.
fn measured(options: &RenderOptions, view: View, plan: &Plan, interrupt: &Interrupt) -> f64 {
    let time = plan.time.unwrap_or_default();
    let (start, enough) = (Instant::now(), time.mul_f64(0.01).min(ENOUGH));
    let mut observe = |_, _: &Film<3>| match interrupt.requested() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let mut size = 1.0 / 64.0;
    loop {
        let trial = Renderer::new(view, without_pilot(settings(options, size)));
        let before = Instant::now();
        if trial.render(0..1, &mut trial.film(), &mut Counts::default(), &mut observe) == Outcome::Stopped {
            return size;
        }
        let taken = before.elapsed();
        let done = if options.method().mutates() { size } else { size.max(1.0) };
        if taken > enough || start.elapsed() > time.mul_f64(0.05) {
            return plan.per_pixel_at(done / taken.as_secs_f64().max(1e-6), time.saturating_sub(start.elapsed()));
        }
        size *= 4.0;
    }
}

/// Refuses a round whose memory, besides the film's, is more than there is.
fn require_memory_for_round(method: render::Method, per_pixel: f64, pixels: f64) -> anyhow::Result<()> {
    let bytes = match method.mutates() {
        true => per_pixel * pixels * BYTES_PER_MUTATION,
        false => per_pixel * rayon::current_num_threads() as f64 * BYTES_PER_SAMPLE,
    };
    require_memory(bytes as u64, &format!("a round of {per_pixel} {} per pixel", method.unit()))
}
