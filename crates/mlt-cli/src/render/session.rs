//! Rounds until the end.

use std::time::Instant;

use mlt_core::engine::{self, Film, Outcome};
use mlt_core::transport::image::relative_error;
use mlt_core::transport::render::{Observer, Renderer, Sums};
use mlt_core::transport::scene::View;

use super::{
    Plan, Setup,
    blocks::Blocks,
    ending::{Ending, STEPS},
    speed::Round,
    summary::report,
    trust::trust,
};
use crate::{
    Failure,
    args::{render::RenderOptions, transport::Method},
    check_memory, cpu_seconds,
    interrupt::Interrupt,
    progress::Progress,
    report::{Agreement, Decision, Report},
};

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
    let Round { per_pixel, time } = Round::new(options, view, &plan, interrupt);
    require_memory_for_round(options.method(), per_pixel, setup)?;
    let session = Session {
        options,
        setup,
        renderer: Renderer::new(view, options.settings(per_pixel)),
        ending: Ending::new(plan, interrupt.clone(), start, time),
        per_pixel,
        start,
    };
    let mut sums = session.renderer.sums();
    let outcome = session.rounds(&mut sums);
    if sums.film().rounds() == 0 {
        return Err(Failure::InterruptedEarly(anyhow::anyhow!(
            "interrupted before the first round was finished; nothing is written"
        )));
    }
    let interrupted = outcome == Outcome::Stopped && interrupt.requested();
    let mut report = session.report(&sums, interrupted);
    report.seconds = start.elapsed().as_secs_f64();
    report.cpu_seconds = cpu_seconds().zip(cpu).map(|(now, then)| now - then);
    Ok(Finished { film: sums.into_parts().0, report, per_pixel })
}

/// A render under way.
struct Session<'a> {
    options: &'a RenderOptions,
    setup: &'a Setup,
    renderer: Renderer<'a>,
    ending: Ending,
    /// Mutations or samples a pixel of one round.
    per_pixel: f64,
    start: Instant,
}

impl Session<'_> {
    /// Makes rounds until the end, and shows progress.
    fn rounds(&self, sums: &mut Sums) -> Outcome {
        let progress = Progress::new(STEPS, self.options.method().unit(), self.options.quiet);
        let (watched, mut error) = (progress.is_shown() || self.ending.needs_error(), None);
        let mut observe = |at: engine::Progress, sums: &Sums| {
            let (rounds, at_end) = (sums.film().rounds(), at.fraction == 0.0);
            if watched && rounds > 1 && at_end {
                error = Some(relative_error(sums.film())).filter(|error| error.is_finite());
            }
            let done = rounds as f64 + at.fraction;
            progress.update(self.ending.share(done, error), self.rate(done), error);
            self.ending.reached(rounds, at_end, error)
        };
        let outcome = self.until_the_end(sums, &mut observe);
        progress.finish();
        outcome
    }

    /// Makes as many rounds at a time as the ending lets begin.
    fn until_the_end(&self, sums: &mut Sums, observe: &mut Observer) -> Outcome {
        let mut outcome = Outcome::Complete;
        while outcome == Outcome::Complete {
            let done = sums.film().rounds();
            let next = self.options.first_round.saturating_add(done);
            let end = next.saturating_add(self.ending.next(done));
            if end == next {
                break;
            }
            outcome = self.renderer.render(next..end, sums, observe);
        }
        outcome
    }

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
        report.warnings.extend(self.ending.missed(film.rounds(), report.relative_error).filter(|_| !interrupted));
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
