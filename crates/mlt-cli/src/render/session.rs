//! A render from options to its report.

use std::time::{Duration, Instant};

use mlt_core::engine::{Ending, Outcome, Standing, Watch};
use mlt_core::transport::LUMINANCE;
use mlt_core::transport::render::{Renderer, Sums, film_of};
use mlt_core::transport::scene::View;
use tracing::{debug, info};

use super::{
    Plan, Setup,
    checkpoint::Checkpoint,
    features::Features,
    files::write,
    key::{arguments, key},
    pilot::renderer,
    preview::Previews,
    speed::Round,
    summary::{provenance, report},
};
use crate::{
    Failure,
    args::{render::RenderOptions, transport::Method},
    check_memory, cpu_seconds,
    interrupt::Interrupt,
    kept::{About, Kept, Spent},
    progress::Progress,
    provenance::Provenance,
    report::{Decision, Report},
    tell, warn,
};

/// Bytes of a round for each of its mutations: a quarter of an independent sample, whose weight is held twice while it is gathered, and
/// the counts of short chains.
const BYTES_PER_MUTATION: f64 = 4.2;
/// Bytes for each sample of the pixels in work, two a thread: its deposits.
const BYTES_PER_SAMPLE: f64 = 64.0;

/// A render that is over.
pub(crate) struct Finished {
    /// Its rounds.
    pub sums: Sums,
    /// All else.
    pub made: Made,
}

/// The report of some rounds.
pub(crate) struct Made {
    /// Which render they are of.
    pub about: About,
    /// What its pilot found, if it has one.
    pub pilot: Option<Vec<u8>>,
    /// Its report, without the files.
    pub report: Report,
    /// Mutations or samples a pixel of one round.
    pub per_pixel: f64,
    /// Features of its image.
    pub features: Features,
}

/// Renders on the current rayon pool, going on from `kept` rounds if there are some.
pub(super) fn run(
    options: &RenderOptions,
    setup: &Setup,
    plan: Plan,
    interrupt: &Interrupt,
    kept: Option<Kept>,
) -> Result<Finished, Failure> {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let view = View { scene: &setup.scene, camera: &setup.camera };
    let progress = Progress::new(options.method().unit(), options.quiet);
    progress.prepare(0.0);
    let Round { per_pixel, time } = Round::new(options, view, &plan, interrupt);
    require_memory_for_round(options.method(), per_pixel, setup)?;
    let mut previews = Previews::open(options, setup.camera.size())?;
    let features = Features::find(options, view);
    let mut sums = Sums::new(film_of(view)).with_key(key(options, setup, per_pixel)?);
    let before = kept.as_ref().map_or(Ok(Spent::NONE), |kept| kept.resume(&mut sums, plan.own()))?;
    let go_on = || interrupt.go_on();
    info!("a round is {per_pixel} {} per pixel; {plan}", options.method().unit());
    let tell = |share| progress.prepare(share);
    let watch = Watch::new(&go_on).reporting(&tell);
    let known = (kept.as_ref(), &options.keeping);
    let renderer = renderer(view, options.settings(per_pixel), known, sums.key(), watch)?;
    let pilot = renderer.pilot();
    drop(kept);
    info!("set up after {:.3} s{}", start.elapsed().as_secs_f64(), decision(&renderer));
    let ending = Ending::new(plan.limits(), LUMINANCE, start).expecting(time).showing_error(progress.is_shown());
    let provenance = provenance(options, setup);
    let session = Session {
        options,
        setup,
        provenance,
        plan,
        renderer,
        per_pixel,
        start,
        cpu,
        before,
        held: sums.rounds().count(),
        features,
    };
    let mut checkpoint = Checkpoint::new(&options.keeping, pilot.as_deref());
    let outcome = session.renderer.render_until(&ending, plan.own().start, &mut sums, &mut |at, sums| {
        progress.update(&at, session.rate(at.rounds));
        previews.offer(sums.film());
        if at.rounds.fract() == 0.0 {
            debug!("{}", words(&at));
            checkpoint.offer(|| session.about(), sums);
            session.write_if(interrupt.files_are_wanted(), sums);
        }
        interrupt.go_on()
    });
    progress.finish();
    info!(
        "{} rounds after {:.3} s: {}",
        sums.film().rounds(),
        start.elapsed().as_secs_f64(),
        ending_words(outcome, interrupt)
    );
    previews.show(sums.film());
    if sums.film().rounds() == 0 {
        return Err(too_early());
    }
    let made = session.made(&sums, outcome == Outcome::Stopped && interrupt.requested())?;
    sums.finish();
    Ok(Finished { sums, made })
}

/// What a pilot has decided, if it had a choice.
fn decision(renderer: &Renderer) -> String {
    let text = renderer.decision().map_or_else(String::new, |decision| Decision::from(decision).to_string());
    if text.is_empty() { text } else { format!(": {}", text.split_whitespace().collect::<Vec<_>>().join(" ")) }
}

/// How far a render is.
fn words(at: &Standing) -> String {
    let error = at.error.map_or_else(|| "unknown".into(), |error| format!("{:.2} %", 100.0 * error));
    let left = at.left.map_or_else(|| "unknown".into(), |left| format!("{:.1} s", left.as_secs_f64()));
    format!("{} rounds, relative error {error}, time left {left}", at.rounds)
}

fn ending_words(outcome: Outcome, interrupt: &Interrupt) -> &'static str {
    match outcome {
        Outcome::Stopped if interrupt.requested() => "interrupted",
        Outcome::Stopped => "the error is reached",
        Outcome::Complete => "done",
    }
}

/// The failure of a render that is stopped before anything is worth keeping.
pub(super) fn too_early() -> Failure {
    Failure::InterruptedEarly(anyhow::anyhow!("interrupted before the first round was finished; nothing is written"))
}

/// A render under way.
struct Session<'a> {
    options: &'a RenderOptions,
    setup: &'a Setup,
    provenance: Provenance,
    plan: Plan,
    renderer: Renderer<'a>,
    /// Mutations or samples a pixel of one round.
    per_pixel: f64,
    start: Instant,
    /// Processor time before it, s.
    cpu: Option<f64>,
    /// Time that its rounds have taken in earlier processes.
    before: Spent,
    /// How many these are.
    held: u64,
    /// Features of its image.
    features: Features,
}

impl Session<'_> {
    /// Mutations or samples a second, after so many rounds.
    fn rate(&self, rounds: f64) -> f64 {
        let made = rounds - self.held as f64;
        made * self.per_pixel * f64::from(self.setup.camera.pixels()) / self.start.elapsed().as_secs_f64()
    }

    /// Time that the rounds have taken so far.
    fn spent(&self) -> Spent {
        let processors = cpu_seconds().zip(self.cpu).map(|(now, then)| Duration::from_secs_f64((now - then).max(0.0)));
        Spent { clock: self.start.elapsed(), processors }.and(self.before)
    }

    /// Which render the rounds are of.
    fn about(&self) -> anyhow::Result<About> {
        let (arguments, provenance) = (arguments(self.options)?, self.provenance.clone());
        Ok(About { arguments, provenance, whole: self.plan.whole(), spent: self.spent() })
    }

    /// The report of the rounds so far.
    fn made(&self, sums: &Sums, interrupted: bool) -> anyhow::Result<Made> {
        let (about, report) = (self.about()?, self.report(sums, interrupted));
        let (per_pixel, pilot) = (self.per_pixel, self.renderer.pilot());
        Ok(Made { about, pilot, report, per_pixel, features: self.features.clone() })
    }

    /// Writes the files as they are so far, if they are wanted. One that fails leaves the render going.
    fn write_if(&self, wanted: bool, sums: &Sums) {
        if !wanted {
            return;
        }
        let written = self.made(sums, false).map_err(Failure::from).and_then(|made| write(self.options, made, sums));
        match written {
            Ok(report) => tell(&format!("{} rounds so far are in {}\n", report.rounds, report.outputs.join(", "))),
            Err(failure) => warn(&format!("{failure}; the render goes on")),
        }
    }

    /// Everything but files.
    fn report(&self, sums: &Sums, interrupted: bool) -> Report {
        let mut report = report(self.options, &self.provenance, sums);
        let missed = self.plan.missed(report.rounds, report.relative_error);
        report.warnings.extend(missed.filter(|_| !interrupted));
        report.decision = self.renderer.decision().map(Decision::from);
        report.interrupted = interrupted;
        report.set_time(self.spent());
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
