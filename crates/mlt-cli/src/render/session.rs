//! A render from options to its report.

use std::time::Instant;

use mlt_core::engine::{Ending, Film, Outcome, Watch};
use mlt_core::transport::LUMINANCE;
use mlt_core::transport::render::{Renderer, Sums};
use mlt_core::transport::scene::View;

use super::{Plan, Setup, blocks::Blocks, key::key, speed::Round, summary::report, trust::trust};
use crate::{
    Failure,
    args::{render::RenderOptions, transport::Method},
    check_memory, cpu_seconds,
    interrupt::Interrupt,
    progress::Progress,
    report::{Agreement, Decision, Report},
};

/// Steps of the progress bar.
const STEPS: u64 = 1000;
/// Bytes of a round for each of its mutations: a quarter of an independent sample, whose weight is held twice while it is gathered, and
/// the counts of short chains.
const BYTES_PER_MUTATION: f64 = 4.2;
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
}

/// Renders on the current rayon pool.
pub fn run(options: &RenderOptions, setup: &Setup, plan: Plan, interrupt: &Interrupt) -> Result<Finished, Failure> {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let view = View { scene: &setup.scene, camera: &setup.camera };
    let progress = Progress::new(STEPS, options.method().unit(), options.quiet);
    progress.prepare();
    let Round { per_pixel, time } = Round::new(options, view, &plan, interrupt);
    require_memory_for_round(options.method(), per_pixel, setup)?;
    let go_on = || interrupt.go_on();
    let renderer = Renderer::watched(view, options.settings(per_pixel), Watch::new(&go_on)).ok_or_else(too_early)?;
    let ending = Ending::new(plan.limits(), LUMINANCE, start).expecting(time).showing_error(progress.is_shown());
    let mut sums = renderer.sums().with_key(key(options, setup, per_pixel)?);
    let session = Session { options, setup, plan, renderer, per_pixel, start };
    let outcome = session.renderer.render_until(&ending, options.first_round, &mut sums, &mut |at, _| {
        progress.update((at.share * STEPS as f64) as u64, session.rate(at.rounds), at.error);
        interrupt.go_on()
    });
    progress.finish();
    if sums.film().rounds() == 0 {
        return Err(too_early());
    }
    let interrupted = outcome == Outcome::Stopped && interrupt.requested();
    let mut report = session.report(&sums, interrupted);
    report.seconds = start.elapsed().as_secs_f64();
    report.cpu_seconds = cpu_seconds().zip(cpu).map(|(now, then)| now - then);
    Ok(Finished { film: sums.into_parts().0, report, per_pixel })
}

fn too_early() -> Failure {
    Failure::InterruptedEarly(anyhow::anyhow!("interrupted before the first round was finished; nothing is written"))
}

/// A render under way.
struct Session<'a> {
    options: &'a RenderOptions,
    setup: &'a Setup,
    plan: Plan,
    renderer: Renderer<'a>,
    /// Mutations or samples a pixel of one round.
    per_pixel: f64,
    start: Instant,
}

impl Session<'_> {
    /// Mutations or samples a second, after so many rounds.
    fn rate(&self, rounds: f64) -> f64 {
        rounds * self.per_pixel * f64::from(self.setup.camera.pixels()) / self.start.elapsed().as_secs_f64()
    }

    /// Everything but times and files.
    fn report(&self, sums: &Sums, interrupted: bool) -> Report {
        let (film, counts, blocks) = (sums.film(), sums.tally(), &Blocks::from(sums.film().blocks()));
        let mut report = report(self.options, self.setup, film, counts);
        report.agreement = blocks.agreement().filter(|_| counts.steps() > 0);
        report.warnings.extend(report.agreement.as_ref().and_then(Agreement::warning));
        report.warnings.extend(self.plan.missed(film.rounds(), report.relative_error).filter(|_| !interrupted));
        report.trust = trust(film, counts, blocks, self.setup.camera.size());
        report.warnings.extend(report.trust.doubts());
        report.decision = self.renderer.decision().map(Decision::from);
        report.interrupted = interrupted;
        report
    }
}

/// Refuses a round whose memory, besides the film's, is more than there is.
fn require_memory_for_round(method: Method, per_pixel: f64, setup: &Setup) -> anyhow::Result<()> {
    let bytes = match method.mutates() {
        true => per_pixel * f64::from(setup.camera.pixels()) * BYTES_PER_MUTATION,
        false => per_pixel * rayon::current_num_threads() as f64 * BYTES_PER_SAMPLE,
    };
    check_memory(&setup.memory, bytes as u64, &format!("a round of {per_pixel} {} per pixel", method.unit()))
}
