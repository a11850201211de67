//! Rounds until the end.

use std::{
    collections::BTreeMap,
    ops::ControlFlow,
    time::{Duration, Instant},
};

use mlt_core::{
    engine::{Film, MutationStats, Outcome, StratumStats},
    transport::{
        adapt::{Adaptation, Weights},
        importance::Target,
        path::View,
        render::{Counts, Method, Renderer, Settings, luminance_and_error, relative_error},
        strata::Stratification,
        stratum::Variant,
    },
};

use super::{Plan, Setup, blocks::Blocks, losses::losses, plan::TRUSTED_ROUNDS};
use crate::{
    Failure,
    args::render::{self, RenderOptions, value_name},
    cpu_seconds,
    interrupt::Interrupt,
    progress::Progress,
    report::{Acceptance, Agreement, Decision, Report, StratumReport},
    require_memory,
};

/// Steps of the progress bar.
const STEPS: u64 = 1000;
/// Time that is enough to measure the speed.
const ENOUGH: Duration = Duration::from_millis(300);
/// Bytes of a round for each of its mutations: a 32nd of an independent sample, and the counts of short chains.
const BYTES_PER_MUTATION: f64 = 0.6;
/// Bytes for each sample of the pixels in work, two a thread: its deposits.
const BYTES_PER_SAMPLE: f64 = 64.0;
/// A run of rejections that is worth a warning: half of the longest chain of a round.
const STUCK: u64 = 4096;
/// Relative uncertainty of a stratum's b that is worth a warning.
const UNCERTAIN: f64 = 0.05;

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
    let mut ending =
        Ending { plan, interrupt: interrupt.clone(), start, round: Instant::now(), longest: Duration::ZERO };
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
    let interrupted = outcome == Outcome::Stopped && ending.interrupt.requested();
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

fn settings(options: &RenderOptions, per_pixel: f64) -> Settings {
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
            weights: match options.weights {
                render::Weights::Power => Weights::Power,
                render::Weights::Adaptive => Weights::Adaptive,
            },
            pilot_rounds: options.rounds_pilot,
        },
        variant: match options.variant {
            render::Variant::Stratified => Variant::Stratified,
            render::Variant::MutationOnly => Variant::MutationOnly,
        },
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
fn without_pilot(settings: Settings) -> Settings {
    let method = if settings.method == Method::Auto { Method::Path } else { settings.method };
    let stratification = match settings.stratification {
        Stratification::Auto => Stratification::None,
        other => other,
    };
    Settings { method, stratification, adaptation: Adaptation::default(), target: Target::Luminance, ..settings }
}

/// When a render ends.
struct Ending {
    plan: Plan,
    interrupt: Interrupt,
    start: Instant,
    /// When the current round began.
    round: Instant,
    /// Longest round so far.
    longest: Duration,
}

impl Ending {
    /// Where the progress bar stands after `done` rounds; errors fall as one over the square root of the work.
    fn share(&self, done: f64, error: Option<f64>) -> u64 {
        let rounds = self.plan.rounds.map_or(0.0, |rounds| done / rounds as f64);
        let time = self.plan.time.map_or(0.0, |time| self.start.elapsed().as_secs_f64() / time.as_secs_f64());
        let error = self.plan.error.zip(error).map_or(0.0, |(target, error)| (target / error).powi(2));
        (rounds.max(time).max(error).min(1.0) * STEPS as f64) as u64
    }

    /// Breaks when the render is to stop: on a signal at once, else at the end of a round.
    fn reached(&mut self, rounds: u64, at_end: bool, error: Option<f64>) -> ControlFlow<()> {
        if at_end {
            self.longest = self.longest.max(self.round.elapsed());
            self.round = Instant::now();
        }
        // Half a round too late is as good as half a round too early.
        let late = self.plan.time.is_some_and(|time| self.start.elapsed() + self.longest / 2 > time);
        let good =
            rounds >= TRUSTED_ROUNDS && self.plan.error.zip(error).is_some_and(|(target, error)| error <= target);
        if self.interrupt.requested() || (at_end && (late || good)) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

fn report(options: &RenderOptions, setup: &Setup, film: &Film<3>, counts: &Counts) -> Report {
    let [width, height] = setup.camera.size().map(|n| n as usize);
    let error = relative_error(film);
    let (b, b_stderr) = image_mean(film, counts);
    let mutations = by_mutation(counts);
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: setup.name.clone(),
        method: value_name(options.method()),
        strata_option: options.strata.to_string(),
        weights: value_name(options.weights),
        rounds_pilot: options.rounds_pilot,
        variant: value_name(options.variant),
        importance: value_name(options.importance),
        width,
        height,
        max_length: options.max_length,
        seed: options.seed,
        threads: rayon::current_num_threads(),
        first_round: options.first_round,
        rounds: film.rounds(),
        interrupted: false,
        seconds: 0.0,
        cpu_seconds: None,
        mutations: counts.steps(),
        samples: counts.samples + counts.strata.iter().map(|s| s.samples).sum::<u64>(),
        rays: counts.rays,
        pilot_mutations: counts.pilot_mutations,
        pilot_rays: counts.pilot_rays,
        acceptance: acceptance(&mutations),
        longest_rejection: mutations.iter().map(|(name, stats)| (name.clone(), stats.longest_rejection)).collect(),
        b,
        b_stderr,
        strata: counts.strata.iter().map(stratum).collect(),
        relative_error: error.is_finite().then_some(error),
        agreement: None,
        decision: None,
        warnings: setup.warnings.clone(),
        outputs: Vec::new(),
    };
    report.warnings.extend(warnings(film, counts));
    report.warnings.extend(losses(film, counts, width));
    report
}

/// b and its standard error: from the strata if chains make the whole image, or else the image's mean.
fn image_mean(film: &Film<3>, counts: &Counts) -> (f64, f64) {
    let root = |squares: f64| squares.sqrt();
    if counts.samples == 0 {
        let b = counts.strata.iter().map(StratumStats::b).sum();
        return (b, root(counts.strata.iter().map(|s| s.b_stderr().powi(2)).sum()));
    }
    let pixels = || (0..film.sites() as usize).map(|i| luminance_and_error(film, i));
    let n = f64::from(film.sites());
    (pixels().map(|p| p.0).sum::<f64>() / n, root(pixels().map(|p| p.1 * p.1).sum()) / n)
}

/// Counts of each mutation over all strata.
fn by_mutation(counts: &Counts) -> BTreeMap<String, MutationStats> {
    let mut mutations: BTreeMap<_, _> =
        counts.mutations.iter().map(|name| ((*name).to_owned(), MutationStats::default())).collect();
    for (name, stats) in counts.strata.iter().flat_map(|s| counts.mutations.iter().zip(&s.mutations)) {
        mutations.entry((*name).to_owned()).or_default().merge(stats);
    }
    mutations
}

fn acceptance(mutations: &BTreeMap<String, MutationStats>) -> Acceptance {
    let rate = |stats: &MutationStats| (stats.total() > 0).then(|| stats.acceptance());
    let mut all = MutationStats::default();
    mutations.values().for_each(|stats| all.merge(stats));
    let mutations = mutations.iter().map(|(name, stats)| (name.clone(), rate(stats)));
    Acceptance { mutations: mutations.collect(), total: rate(&all) }
}

fn stratum(stats: &StratumStats) -> StratumReport {
    let (b, b_stderr, longest_rejection) = (stats.b(), stats.b_stderr(), stats.longest_rejection);
    StratumReport { b, b_stderr, mutations: stats.steps(), longest_rejection }
}

fn warnings(film: &Film<3>, counts: &Counts) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |condition: bool, text: String| {
        if condition {
            warnings.push(text);
        }
    };
    let b: f64 = counts.strata.iter().map(StratumStats::b).sum();
    let uncertain = |s: &&StratumStats| s.b_stderr() > UNCERTAIN * s.b() && s.b() > 0.01 * b;
    let strata = counts.strata.iter().filter(uncertain).count();
    let longest = counts.strata.iter().map(|s| s.longest_rejection).max().unwrap_or(0);
    let dark = (0..film.sites() as usize).all(|i| film.pixel(i).iter().all(|channel| channel.mean == 0.0));
    let rounds = film.rounds();
    warn(rounds == 1, format!("one round says nothing of its error; take {TRUSTED_ROUNDS} or more to know it"));
    warn(
        (2..TRUSTED_ROUNDS).contains(&rounds),
        format!("the error is estimated from {rounds} rounds only; take {TRUSTED_ROUNDS} or more to trust it"),
    );
    warn(strata > 0, format!("{strata} strata have a b that is uncertain by more than 5 %; take more mutations"));
    warn(longest > STUCK, format!("a chain was stuck for {longest} mutations; the image may have bright spots"));
    warn(dark, "the image is black: no path from a light to the camera was found".into());
    warnings
}
