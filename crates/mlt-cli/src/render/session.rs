//! Rounds until the end.

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

use mlt_core::{
    engine::{Film, MutationStats, Outcome, StratumStats},
    transport::{
        path::View,
        render::{Counts, Method, Renderer, Settings, luminance_and_error, relative_error},
        strata::Stratification,
    },
};

use super::{Plan, Setup, plan::TRUSTED_ROUNDS};
use crate::{
    Failure,
    args::{
        render::{self, RenderOptions},
        values::Strata,
    },
    cpu_seconds,
    interrupt::Interrupt,
    progress::Progress,
    report::{Acceptance, Report, StratumReport},
};

/// Steps of the progress bar.
const STEPS: u64 = 1000;
/// A run of rejections that is worth a warning.
const STUCK: u64 = 10_000;
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
}

/// Renders on the current rayon pool.
pub fn run(options: &RenderOptions, setup: &Setup, plan: Plan, interrupt: &Interrupt) -> Result<Finished, Failure> {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let view = View { scene: &setup.scene, camera: &setup.camera };
    let per_pixel = plan.per_pixel.unwrap_or_else(|| measured(options, view, &plan));
    let renderer = Renderer::new(view, settings(options, per_pixel));
    let (mut film, mut counts) = (renderer.film(), Counts::default());
    let mut ending =
        Ending { plan, interrupt: interrupt.clone(), start, round: Instant::now(), longest: Duration::ZERO };
    let progress = Progress::new(ending.steps(), options.quiet);
    let pixels = f64::from(setup.camera.pixels());
    let first = options.first_round;
    let last = plan.rounds.map_or(u64::MAX, |rounds| first.saturating_add(rounds));
    let outcome = renderer.render(first..last, &mut film, &mut counts, &mut |at, film| {
        let error = (at.rounds > 1 && at.fraction == 0.0).then(|| relative_error(film));
        let done = at.rounds as f64 + at.fraction;
        let rate = done * per_pixel * pixels / start.elapsed().as_secs_f64();
        progress.update(ending.share(done), rate, error);
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
    report.interrupted = interrupted;
    report.seconds = start.elapsed().as_secs_f64();
    report.cpu_seconds = cpu_seconds().zip(cpu).map(|(now, then)| now - then);
    Ok(Finished { film, report, per_pixel })
}

/// The size of a round that suits a time budget, from the speed of a small render.
fn measured(options: &RenderOptions, view: View, plan: &Plan) -> f64 {
    let time = plan.time.unwrap_or_default();
    let start = Instant::now();
    let mut size = 1.0 / 64.0;
    loop {
        let trial = Renderer::new(view, settings(options, size));
        let before = Instant::now();
        trial.render(0..1, &mut trial.film(), &mut Counts::default(), &mut |_, _| ControlFlow::Continue(()));
        let seconds = before.elapsed().as_secs_f64().max(1e-6);
        let done = if options.method.mutates() { size } else { size.max(1.0) };
        if seconds > 0.01 * time.as_secs_f64() || start.elapsed() > time.mul_f64(0.05) {
            return plan.per_pixel_at(done / seconds, time.saturating_sub(start.elapsed()));
        }
        size *= 4.0;
    }
}

fn settings(options: &RenderOptions, per_pixel: f64) -> Settings {
    Settings {
        method: match options.method {
            render::Method::Mlt => Method::Metropolis,
            render::Method::Bdpt => Method::Bidirectional,
            render::Method::Pt => Method::Path,
            render::Method::Pssmlt => Method::PrimaryBidirectional,
            render::Method::Mmlt => Method::Multiplexed,
        },
        stratification: match options.strata {
            Strata::None => Stratification::None,
            Strata::Grid { columns, rows } => Stratification::Grid(columns, rows),
        },
        max_edges: options.max_length.map(|edges| edges as usize),
        seed: options.seed,
        per_pixel,
    }
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
    /// Length of the progress bar; `None` if nobody knows the end.
    fn steps(&self) -> Option<u64> {
        (self.plan.rounds.is_some() || self.plan.time.is_some()).then_some(STEPS)
    }

    /// Where the progress bar stands after `done` rounds.
    fn share(&self, done: f64) -> u64 {
        let rounds = self.plan.rounds.map_or(0.0, |rounds| done / rounds as f64);
        let time = self.plan.time.map_or(0.0, |time| self.start.elapsed().as_secs_f64() / time.as_secs_f64());
        (rounds.max(time).min(1.0) * STEPS as f64) as u64
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
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: setup.name.clone(),
        method: value_name(options.method),
        strata_option: options.strata.to_string(),
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
        acceptance: acceptance(counts),
        b,
        b_stderr,
        strata: counts.strata.iter().map(stratum).collect(),
        relative_error: error.is_finite().then_some(error),
        warnings: setup.warnings.clone(),
        outputs: Vec::new(),
    };
    report.warnings.extend(warnings(film, counts));
    report
}

fn value_name(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// b and its standard error: from the strata, or else the image's mean.
fn image_mean(film: &Film<3>, counts: &Counts) -> (f64, f64) {
    let root = |squares: f64| squares.sqrt();
    if !counts.strata.is_empty() {
        let b = counts.strata.iter().map(StratumStats::b).sum();
        return (b, root(counts.strata.iter().map(|s| s.b_stderr().powi(2)).sum()));
    }
    let pixels = || (0..film.sites() as usize).map(|i| luminance_and_error(film, i));
    let n = f64::from(film.sites());
    (pixels().map(|p| p.0).sum::<f64>() / n, root(pixels().map(|p| p.1 * p.1).sum()) / n)
}

fn acceptance(counts: &Counts) -> Acceptance {
    let rate = |stats: &MutationStats| (stats.total() > 0).then(|| stats.acceptance());
    let mut totals = vec![MutationStats::default(); counts.mutations.len()];
    let mut all = MutationStats::default();
    for stats in counts.strata.iter().flat_map(|s| s.mutations.iter().enumerate()) {
        totals[stats.0].merge(stats.1);
        all.merge(stats.1);
    }
    let mutations = counts.mutations.iter().zip(&totals).map(|(name, stats)| ((*name).to_owned(), rate(stats)));
    Acceptance { mutations: mutations.collect(), total: rate(&all) }
}

fn stratum(stats: &StratumStats) -> StratumReport {
    StratumReport { b: stats.b(), b_stderr: stats.b_stderr(), mutations: stats.steps() }
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
    let non_finite: u64 = counts
        .strata
        .iter()
        .map(|s| s.non_finite_samples + s.mutations.iter().map(|m| m.non_finite).sum::<u64>())
        .sum();
    let longest = counts.strata.iter().map(|s| s.longest_rejection).max().unwrap_or(0);
    let dark = (0..film.sites() as usize).all(|i| film.pixel(i).iter().all(|channel| channel.mean == 0.0));
    warn(
        film.rounds() < TRUSTED_ROUNDS,
        format!("the error is estimated from {} rounds only; take {TRUSTED_ROUNDS} or more to trust it", film.rounds()),
    );
    warn(strata > 0, format!("{strata} strata have a b that is uncertain by more than 5 %; take more mutations"));
    warn(non_finite > 0, format!("{non_finite} paths had an importance that is not finite; they are left out"));
    let refused: u64 = counts.strata.iter().map(|s| s.refused_starts).sum();
    warn(refused > 0, format!("{refused} chains could not start; what they would have added is missing"));
    warn(film.lost() > 0, format!("{} contributions were not finite; they are left out", film.lost()));
    warn(longest > STUCK, format!("a chain was stuck for {longest} mutations; the image may have bright spots"));
    warn(dark, "the image is black: no path from a light to the camera was found".into());
    warnings
}
