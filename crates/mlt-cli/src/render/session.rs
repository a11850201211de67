//! Rounds until the end.

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

use mlt_core::engine::{self, Film, Outcome};
use mlt_core::transport::image::relative_error;
use mlt_core::transport::render::{Counts, Renderer};
use mlt_core::transport::scene::View;

use super::{
    Plan, Setup,
    blocks::Blocks,
    ending::{Ending, STEPS},
    settings::{settings, without_pilot},
    summary::report,
    trust::trust,
};
use crate::{
    Failure,
    args::render::{self, RenderOptions},
    check_memory, cpu_seconds,
    interrupt::Interrupt,
    progress::Progress,
    report::Report,
    report::{Agreement, Decision},
};

/// Time that is enough to measure the speed.
const ENOUGH: Duration = Duration::from_millis(300);
/// Bytes of a round for each of its mutations: a 32nd of an independent sample, and the counts of short chains.
const BYTES_PER_MUTATION: f64 = 0.6;
/// Bytes for each sample of the pixels in work, two a thread: its deposits.
const BYTES_PER_SAMPLE: f64 = 64.0;
/// Mutations or samples of a task, about.
const TASK: f64 = 8192.0;

/// A render that is over.
pub struct Finished {
    /// Its image.
    pub film: Film<3>,
    /// Its report, without the files.
    pub report: Report,
    /// Mutations or samples a pixel of one round.
    pub per_pixel: f64,
    /// Contribution of each round to each block of the image.
    pub blocks: Blocks,
}

/// Renders on the current rayon pool.
pub fn run(options: &RenderOptions, setup: &Setup, plan: Plan, interrupt: &Interrupt) -> Result<Finished, Failure> {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let view = View { scene: &setup.scene, camera: &setup.camera };
    let pixels = f64::from(setup.camera.pixels());
    let Round { per_pixel, time } = match plan.per_pixel {
        Some(per_pixel) => Round { per_pixel, time: Duration::ZERO },
        None => measured(options, view, &plan, interrupt),
    };
    require_memory_for_round(options.method(), per_pixel, setup)?;
    let renderer = Renderer::new(view, settings(options, per_pixel));
    let (mut film, mut counts) = (renderer.film(), Counts::default());
    let ending = Ending::new(plan, interrupt.clone(), start, time);
    let progress = Progress::new(STEPS, options.method().unit(), options.quiet);
    let (watched, mut error) = (progress.is_shown() || plan.error.is_some(), None);
    let mut blocks = Blocks::new(setup.camera.size());
    let mut observe = |at: engine::Progress, film: &Film<3>| {
        let rounds = film.rounds();
        if at.fraction == 0.0 {
            blocks.add(film);
        }
        if watched && rounds > 1 && at.fraction == 0.0 {
            error = Some(relative_error(film)).filter(|error| error.is_finite());
        }
        let done = rounds as f64 + at.fraction;
        let rate = done * per_pixel * pixels / start.elapsed().as_secs_f64();
        progress.update(ending.share(done, error), rate, error);
        ending.reached(rounds, at.fraction == 0.0, error)
    };
    let mut outcome = Outcome::Complete;
    while outcome == Outcome::Complete {
        let next = options.first_round.saturating_add(film.rounds());
        let end = next.saturating_add(ending.next(film.rounds()));
        if end == next {
            break;
        }
        outcome = renderer.render(next..end, &mut film, &mut counts, &mut observe);
    }
    progress.finish();
    let interrupted = outcome == Outcome::Stopped && interrupt.requested();
    if film.rounds() == 0 {
        return Err(Failure::InterruptedEarly(anyhow::anyhow!(
            "interrupted before the first round was finished; nothing is written"
        )));
    }
    let mut report = report(options, setup, &film, &counts);
    report.agreement = blocks.agreement().filter(|_| counts.steps() > 0);
    report.warnings.extend(report.agreement.as_ref().and_then(Agreement::warning));
    report.warnings.extend(ending.missed(film.rounds(), report.relative_error).filter(|_| !interrupted));
    report.trust = trust(&film, &counts, &blocks, setup.camera.size());
    report.warnings.extend(report.trust.doubts());
    report.decision = renderer.decision().map(Decision::from);
    report.interrupted = interrupted;
    report.seconds = start.elapsed().as_secs_f64();
    report.cpu_seconds = cpu_seconds().zip(cpu).map(|(now, then)| now - then);
    Ok(Finished { film, report, per_pixel, blocks })
}

/// The size of a round.
struct Round {
    /// Mutations or samples a pixel.
    per_pixel: f64,
    /// Time that a round of it takes, about; 0 where that does not matter.
    time: Duration,
}

/// The round that suits a time budget, from the speed of small renders: each keeps all threads busy.
fn measured(options: &RenderOptions, view: View, plan: &Plan, interrupt: &Interrupt) -> Round {
    let time = plan.time.unwrap_or_default();
    let (start, enough) = (Instant::now(), time.mul_f64(0.01).min(ENOUGH));
    let mut observe = |_, _: &Film<3>| match interrupt.requested() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let mut size = 1.0 / 64.0;
    loop {
        let trial = Renderer::new(view, without_pilot(settings(options, size)));
        let done = if options.method().mutates() { size } else { size.max(1.0) };
        let rounds = rounds_of_trial(done * f64::from(view.camera.pixels()));
        let (mut film, before) = (trial.film(), Instant::now());
        if trial.render(0..rounds, &mut film, &mut Counts::default(), &mut observe) == Outcome::Stopped {
            return Round { per_pixel: size, time: Duration::ZERO };
        }
        let taken = before.elapsed();
        if taken > enough || start.elapsed() > time.mul_f64(0.05) {
            let rate = rounds as f64 * done / taken.as_secs_f64().max(1e-6);
            let per_pixel = plan.per_pixel_at(rate, time.saturating_sub(start.elapsed()));
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

/// Refuses a round whose memory, besides the film's, is more than there is.
fn require_memory_for_round(method: render::Method, per_pixel: f64, setup: &Setup) -> anyhow::Result<()> {
    let bytes = match method.mutates() {
        true => per_pixel * f64::from(setup.camera.pixels()) * BYTES_PER_MUTATION,
        false => per_pixel * rayon::current_num_threads() as f64 * BYTES_PER_SAMPLE,
    };
    check_memory(&setup.memory, bytes as u64, &format!("a round of {per_pixel} {} per pixel", method.unit()))
}
