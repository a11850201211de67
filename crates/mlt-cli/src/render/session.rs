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
    made::{Finished, Made},
    pilot::renderer,
    preview::Previews,
    speed::Round,
    stop::Stop,
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

/// Renders on the current rayon pool, going on from `kept` rounds if there are some.
pub(super) fn run(
    options: &RenderOptions,
    setup: &Setup,
    plan: Plan,
    interrupt: &Interrupt,
    kept: Option<Kept>,
) -> Result<Finished, Failure> {
    let progress = Progress::new(options.method().unit(), options.quiet);
    progress.prepare(0.0);
    let mut previews = Previews::open(options, setup.camera.size())?;
    let (session, mut sums) = Session::begin((options, setup, plan), interrupt, &progress, kept)?;
    let outcome = session.render(&mut sums, &progress, &mut previews);
    if sums.film().rounds() == 0 {
        return Err(Failure::too_early());
    }
    sums.finish();
    let made = session.made(&sums, outcome == Outcome::Stopped)?;
    Ok(Finished { sums, made })
}

/// A pilot's decision, if it had a choice.
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

fn ending_words(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Stopped => "interrupted",
        Outcome::Complete => "done",
    }
}

/// A render under way.
struct Session<'a> {
    options: &'a RenderOptions,
    setup: &'a Setup,
    provenance: Provenance,
    plan: Plan,
    interrupt: &'a Interrupt,
    renderer: Renderer<'a>,
    round: Round,
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

impl<'a> Session<'a> {
    /// Sets a render up, with the rounds that there are already.
    fn begin(
        (options, setup, plan): (&'a RenderOptions, &'a Setup, Plan),
        interrupt: &'a Interrupt,
        progress: &Progress,
        kept: Option<Kept>,
    ) -> Result<(Self, Sums), Failure> {
        let (start, cpu) = (Instant::now(), cpu_seconds());
        let view = View { scene: &setup.scene, camera: &setup.camera };
        let round = Round::new(options, view, &plan, interrupt);
        require_memory_for_round(options.method(), round.per_pixel, setup)?;
        let features = Features::find(options, view);
        let mut sums = Sums::new(film_of(view)).with_key(key(options, setup, round.per_pixel)?);
        let before = kept.as_ref().map_or(Ok(Spent::NONE), |kept| kept.resume(&mut sums, plan.own()))?;
        info!("a round is {} {} per pixel; {plan}", round.per_pixel, options.method().unit());
        let (go_on, tell) = (|| interrupt.go_on(), |share| progress.prepare(share));
        let watch = Watch::new(&go_on).reporting(&tell);
        let known = (kept.as_ref(), &options.keeping);
        let renderer = renderer(view, options.settings(round.per_pixel), known, sums.key(), watch)?;
        info!("set up after {:.3} s{}", start.elapsed().as_secs_f64(), decision(&renderer));
        let (provenance, held) = (provenance(options, setup), sums.rounds().count());
        let session =
            Self { options, setup, provenance, plan, interrupt, renderer, round, start, cpu, before, held, features };
        Ok((session, sums))
    }

    /// Makes the rounds that are missing, as far as the plan goes.
    fn render(&self, sums: &mut Sums, progress: &Progress, previews: &mut Previews) -> Outcome {
        let limits = Ending::new(self.plan.limits(), LUMINANCE, self.start);
        let ending = limits.expecting(self.round.time).showing_error(progress.is_shown());
        let pilot = self.renderer.pilot();
        let mut checkpoint = Checkpoint::new(&self.options.keeping, pilot.as_deref());
        let mut stop = Stop::new(Instant::now());
        let outcome = self.renderer.render_until(&ending, self.plan.own().start, sums, &mut |at, sums| {
            progress.update(&at, self.rate(at.rounds));
            previews.offer(sums.film());
            if at.rounds.fract() == 0.0 {
                debug!("{}", words(&at));
                checkpoint.offer(|| self.about(), sums);
                self.write_if(self.interrupt.files_are_wanted(), sums);
            }
            stop.go_on(self.interrupt.requested(), at.rounds, Instant::now())
        });
        progress.finish();
        let (rounds, seconds) = (sums.film().rounds(), self.start.elapsed().as_secs_f64());
        info!("{rounds} rounds after {seconds:.3} s: {}", ending_words(outcome));
        previews.show(sums.film());
        outcome
    }

    /// Mutations or samples a second, after so many rounds.
    fn rate(&self, rounds: f64) -> f64 {
        let made = rounds - self.held as f64;
        made * self.round.per_pixel * f64::from(self.setup.camera.pixels()) / self.start.elapsed().as_secs_f64()
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
        let (about, report) = (self.about()?, self.report(sums, interrupted)?);
        let (per_pixel, pilot) = (self.round.per_pixel, self.renderer.pilot());
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
    fn report(&self, sums: &Sums, interrupted: bool) -> anyhow::Result<Report> {
        let mut report = report(self.options, &self.provenance, sums)?;
        let missed = self.plan.missed(report.rounds, report.relative_error);
        report.warnings.extend(missed.filter(|_| !interrupted));
        report.decision = self.renderer.decision().map(Decision::from);
        if let Some(stratum) = self.renderer.met_by_chance().and_then(|number| report.strata.get_mut(number)) {
            stratum.met_by_chance = true;
        }
        report.interrupted = interrupted;
        report.set_time(self.spent());
        Ok(report)
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
