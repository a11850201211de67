//! The engine on functions of one variable, where every truth is known.
//!
//! Statistical tests compare independent replicas with the truth, and each has a negative control: the same test with a
//! small deliberate error must fail.

use mlt_core::engine::{
    Accumulated, Deposits, Estimator, Film, Metropolis, Mixture, Mutation, Path, Purpose, Share, Sink, Splat, Stratum,
    StratumStats, Tally, generator, render, uniform,
};
use mlt_core::rand_core::Rng;
use std::ops::{ControlFlow, Range};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

const BINS: u32 = 8;
const TOTAL: usize = BINS as usize;

/// 0.3 + 2/(1 + ((x − 0.4)/0.05)²), and 0 beyond 0.875.
fn f(x: f64) -> f64 {
    let z = (x - 0.4) / 0.05;
    if x < 0.875 { 0.3 + 2.0 / (1.0 + z * z) } else { 0.0 }
}

/// ∫ f over [a, b].
fn integral(a: f64, b: f64) -> f64 {
    let g = |x: f64| 0.3 * x + 0.1 * ((x - 0.4) / 0.05).atan();
    g(b.min(0.875)) - g(a.min(0.875))
}

/// Means of f over the bins, then over all of [0, 1).
fn truth() -> Vec<f64> {
    let edge = |p: u32| f64::from(p) / f64::from(BINS);
    let mut truth: Vec<_> = (0..BINS).map(|p| f64::from(BINS) * integral(edge(p), edge(p + 1))).collect();
    truth.push(integral(0.0, 1.0));
    truth
}

#[derive(Clone)]
struct Point(f64);

impl Path for Point {
    type Splat = Splat<1>;

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        let bin = ((self.0 * f64::from(BINS)) as u32).min(BINS - 1);
        let value = f(self.0);
        [Splat { site: bin, value: [f64::from(BINS) * value] }, Splat { site: BINS, value: [value] }].into_iter()
    }
}

/// [low, high), with a factor on the weights of its samples that ought to be 1.
struct Cell {
    low: f64,
    high: f64,
    weight_error: f64,
    /// Samples drawn.
    drawn: AtomicU64,
}

impl Cell {
    fn new(low: f64, high: f64) -> Self {
        Self { low, high, weight_error: 1.0, drawn: AtomicU64::new(0) }
    }
}

impl Stratum<Point> for Cell {
    fn contains(&self, x: &Point) -> bool {
        self.low <= x.0 && x.0 < self.high
    }

    /// Density 2t in t = (x − low)/(high − low), so that weights differ even where f is constant.
    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&Point, f64)) {
        self.drawn.fetch_add(1, Ordering::Relaxed);
        let t = (1.0 - uniform(rng)).sqrt();
        let x = self.low + (self.high - self.low) * t;
        visit(&Point(x), self.weight_error * (self.high - self.low) / (2.0 * t));
    }

    fn density(&self, x: &Point) -> f64 {
        2.0 * (x.0 - self.low) / (self.high - self.low).powi(2)
    }

    fn power(&self) -> f64 {
        self.high - self.low
    }
}

#[derive(Clone, Copy)]
enum Move {
    /// Uniform within ±0.1: T(x→y) = T(y→x).
    Near,
    /// x ↦ x·r, r log-uniform in [¾, 4/3]: T(x→y) ∝ 1/y, T(y→x)/T(x→y) = y/x.
    Scale,
    /// The same with the ratio forgotten.
    ScaleWithoutRatio,
}

impl Mutation<Point, Cell> for Move {
    fn name(&self) -> &'static str {
        "move"
    }

    fn suitability(&self, x: &Point) -> f64 {
        match self {
            Self::Near => 1.0,
            _ => 1.0 + x.0,
        }
    }

    fn propose(&self, x: &Point, y: &mut Point, _: &Cell, rng: &mut impl Rng) -> Option<f64> {
        let u = 2.0 * uniform(rng) - 1.0;
        *y = match self {
            Self::Near => Point(x.0 + 0.1 * u),
            _ => Point(x.0 * (4.0f64 / 3.0).powf(u)),
        };
        if y.0 >= 1.0 {
            return None;
        }
        Some(if matches!(self, Self::Scale) { y.0 / x.0 } else { 1.0 })
    }
}

fn cells(n: u32) -> Vec<Cell> {
    let edge = |j: u32| f64::from(j) / f64::from(n);
    (0..n).map(|j| Cell::new(edge(j), edge(j + 1))).collect()
}

/// A problem to run: everything that a test may spoil.
struct Problem {
    strata: Vec<(Cell, Share)>,
    moves: Vec<Move>,
}

impl Problem {
    fn new(strata: Vec<Cell>, mutations: u64, samples: u64) -> Self {
        let share = Share { mutations, samples };
        let strata = strata.into_iter().map(|cell| (cell, share)).collect();
        Self { strata, moves: vec![Move::Near, Move::Scale] }
    }

    fn run(&self, seed: u64, rounds: Range<u64>) -> (Film<1>, Tally) {
        self.run_with(&|x: &Point| f(x.0), seed, rounds)
    }

    fn run_with(
        &self,
        importance: &(impl Fn(&Point) -> f64 + Sync),
        seed: u64,
        rounds: Range<u64>,
    ) -> (Film<1>, Tally) {
        let mixture = Mixture::new(self.moves.clone());
        let metropolis = Metropolis::new(&self.strata, &mixture, importance, seed).unwrap();
        let mut sums = Accumulated::new(Film::new(BINS + 1, 1.0));
        render(&metropolis, rounds, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        sums.into_parts()
    }

    /// Largest |z| of any bin or the total, from `replicas` renders of one round with seeds of their own.
    fn worst_z(&self, replicas: u64) -> f64 {
        let truth = truth();
        let mut sums = vec![(0.0, 0.0); truth.len()];
        for seed in 0..replicas {
            let (film, _) = self.run(seed, 0..1);
            for (site, (sum, squares)) in sums.iter_mut().enumerate() {
                let x = film.pixel(site)[0].mean;
                *sum += x;
                *squares += x * x;
            }
        }
        let n = replicas as f64;
        let z = |((sum, squares), truth): (&(f64, f64), &f64)| -> f64 {
            let mean = sum / n;
            let stderr = ((squares / n - mean * mean) / (n - 1.0)).max(0.0).sqrt();
            if stderr > 0.0 { ((mean - truth) / stderr).abs() } else { (mean - truth).abs() * f64::INFINITY }
        };
        sums.iter().zip(&truth).map(z).filter(|z| !z.is_nan()).fold(0.0, f64::max)
    }
}

/// Sites of a film, bit for bit.
fn bits(film: &Film<1>) -> Vec<[u64; 2]> {
    let pixel = |site| film.pixel(site as usize)[0];
    (0..film.sites()).map(pixel).map(|p| [p.mean.to_bits(), p.stderr.to_bits()]).collect()
}

const REPLICAS: u64 = 20_000;
/// With nine sites a correct estimator exceeds it once in 15,000 seeds.
const LIMIT: f64 = 4.5;

#[test]
fn very_short_stratified_rounds_are_unbiased() {
    let z = Problem::new(cells(4), 6, 3).worst_z(REPLICAS);
    assert!(z < LIMIT, "worst z = {z}");
    let z = Problem::new(cells(1), 6, 3).worst_z(REPLICAS);
    assert!(z < LIMIT, "unstratified: worst z = {z}");
}

#[test]
fn a_forgotten_ratio_shows() {
    let mut problem = Problem::new(cells(4), 6, 3);
    problem.moves[1] = Move::ScaleWithoutRatio;
    let z = problem.worst_z(REPLICAS);
    assert!(z > 2.0 * LIMIT, "worst z = {z}");
}

#[test]
fn a_wrong_b_of_one_stratum_shows() {
    let mut problem = Problem::new(cells(4), 6, 3);
    problem.strata[1].0.weight_error = 1.05;
    let z = problem.worst_z(REPLICAS);
    assert!(z > LIMIT, "worst z = {z}");
}

#[test]
fn a_dropped_stratum_shows() {
    let mut problem = Problem::new(cells(8), 6, 3);
    problem.strata.remove(5);
    let z = problem.worst_z(REPLICAS / 4);
    assert!(z > 2.0 * LIMIT, "worst z = {z}");
}

/// A stratum that admits everything, as if there were no strata at all.
struct Everything(Cell);

impl Stratum<Point> for Everything {
    fn contains(&self, _: &Point) -> bool {
        true
    }

    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&Point, f64)) {
        self.0.sample(rng, visit);
    }

    fn density(&self, x: &Point) -> f64 {
        self.0.density(x)
    }

    fn power(&self) -> f64 {
        1.0
    }
}

impl Mutation<Point, Everything> for Move {
    fn name(&self) -> &'static str {
        "move"
    }

    fn suitability(&self, x: &Point) -> f64 {
        Mutation::<Point, Cell>::suitability(self, x)
    }

    fn propose(&self, x: &Point, y: &mut Point, within: &Everything, rng: &mut impl Rng) -> Option<f64> {
        self.propose(x, y, &within.0, rng)
    }
}

#[test]
fn one_stratum_is_no_strata_bit_for_bit() {
    let problem = Problem::new(cells(1), 300, 50);
    let (one, one_tally) = problem.run(3, 0..5);
    let everything = [(Everything(Cell::new(0.0, 1.0)), problem.strata[0].1)];
    let mixture = Mixture::new(problem.moves.clone());
    // Where f is 0 outside [0, 1), Ω_1 = [0, 1) and the whole line are the same.
    let importance = |x: &Point| if (0.0..1.0).contains(&x.0) { f(x.0) } else { 0.0 };
    let metropolis = Metropolis::new(&everything, &mixture, &importance, 3).unwrap();
    let mut sums = Accumulated::new(Film::new(BINS + 1, 1.0));
    render(&metropolis, 0..5, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let (none, tally) = sums.into_parts();
    assert_eq!(bits(&one), bits(&none));
    assert_eq!(one_tally.strata[0].weight_sum, tally.strata[0].weight_sum);
    assert_ne!(bits(&one), bits(&problem.run(4, 0..5).0), "another seed gives another film");
}

#[test]
fn same_bits_on_any_number_of_threads() {
    // Chains longer than one task and bootstraps longer than one block.
    let problem = Problem::new(cells(4), 20_000, 1000);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (film, tally) = pool.install(|| problem.run(5, 0..3));
        (bits(&film), tally)
    };
    let one = on(1);
    for threads in [2, 3, 8, 32] {
        assert!(one == on(threads), "{threads} threads");
    }
}

#[test]
fn rounds_can_be_made_apart_and_merged() {
    let problem = Problem::new(cells(4), 500, 100);
    let (whole, _) = problem.run(6, 0..8);
    let (mut late, _) = problem.run(6, 3..8);
    let (early, _) = problem.run(6, 0..3);
    assert_eq!(late.merge(&early), Ok(()));
    assert!(late.merge(&early).is_err(), "twice");
    assert_eq!(bits(&whole), bits(&late));
    assert_eq!(whole.rounds(), late.rounds());
    assert_ne!(bits(&whole), bits(&problem.run(6, 0..7).0), "a missing round shows");
}

/// Share of intervals of ±1.96 standard errors, stretched by `stretch`, that hold the truth.
fn coverage(problem: &Problem, stretch: f64) -> f64 {
    let truth = truth();
    let (mut inside, mut all) = (0.0, 0.0);
    for seed in 0..250 {
        let (film, _) = problem.run(1000 + seed, 0..64);
        for (site, truth) in truth.iter().enumerate().filter(|(_, truth)| **truth > 0.0) {
            let [pixel] = film.pixel(site);
            all += 1.0;
            inside += f64::from(u8::from((pixel.mean - truth).abs() < stretch * 1.96 * pixel.stderr));
        }
    }
    inside / all
}

#[test]
fn standard_errors_are_honest() {
    let problem = Problem::new(cells(4), 60, 20);
    let share = coverage(&problem, 1.0);
    assert!((0.90..0.99).contains(&share), "{share}");
    let share = coverage(&problem, 0.7);
    assert!(share < 0.90, "errors 30 % too small pass: {share}");
}

/// Means of uniform numbers, in rounds of different sizes: site p of channel c holds the mean of u^(c+1).
struct Uneven {
    seed: u64,
    sites: u32,
}

impl Estimator<2> for Uneven {
    type Prepared = u64;
    type Task = ();
    type Tally = ();

    fn prepare(&self, round: u64) -> u64 {
        round
    }

    fn tasks(&self, _: &u64) -> usize {
        self.sites as usize
    }

    fn task_deposits(&self) -> usize {
        50
    }

    fn run(&self, &round: &u64, task: usize, deposits: &mut Deposits<2>) {
        let mut rng = generator(self.seed, Purpose::Image, round, 0, task as u64);
        let n = self.weight(round);
        for _ in 0..n {
            let u = uniform(&mut rng);
            deposits.deposit(Splat { site: task as u32, value: [u, u * u] }, 1.0 / n as f64);
        }
    }

    fn weight(&self, round: u64) -> u64 {
        [1, 5, 20, 50][round as usize % 4]
    }

    fn tally(&self, (): &mut (), _: &u64, _: Vec<()>) {}
}

#[test]
fn weighted_rounds_have_honest_errors_in_every_channel() {
    let (mut inside, mut all) = ([0.0; 2], 0.0);
    let mut chi_square = [0.0; 2];
    for seed in 0..40 {
        let mut sums = Accumulated::new(Film::<2>::new(64, 1.0));
        render(&Uneven { seed, sites: 64 }, 0..60, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let film = sums.film();
        for site in 0..64 {
            let pixels = film.pixel(site);
            all += 1.0;
            for (channel, truth) in [0.5, 1.0 / 3.0].into_iter().enumerate() {
                let z = (pixels[channel].mean - truth) / pixels[channel].stderr;
                inside[channel] += f64::from(u8::from(z.abs() < 1.96));
                chi_square[channel] += z * z;
            }
        }
    }
    for channel in 0..2 {
        let share = inside[channel] / all;
        assert!((0.92..0.97).contains(&share), "channel {channel}: {share}");
        let spread = chi_square[channel] / all;
        assert!((0.9..1.2).contains(&spread), "channel {channel}: mean z² = {spread}");
    }
}

#[test]
fn importance_that_is_not_finite_is_counted_and_kept_out() {
    let bad = |x: &Point| if (0.3..0.5).contains(&x.0) { f64::NAN } else { f(x.0) };
    let (film, tally) = Problem::new(cells(1), 1000, 200).run_with(&bad, 7, 0..4);
    let total = tally.total();
    assert!(total.non_finite_samples > 0);
    assert!(total.mutations.iter().all(|m| m.non_finite > 0), "{total:?}");
    assert_eq!(film.lost().count, 0);
    assert!((0..=TOTAL).all(|site| film.pixel(site)[0].mean.is_finite()));
    let good = Problem::new(cells(1), 1000, 200).run(7, 0..4).1.total();
    assert_eq!((good.non_finite_samples, good.mutations[0].non_finite), (0, 0));
}

#[test]
fn a_dark_stratum_costs_no_mutation_and_gives_nothing() {
    let problem = Problem::new(cells(8), 100, 20);
    let (film, tally) = problem.run(8, 0..6);
    let dark = &tally.strata[7];
    assert_eq!((dark.steps(), dark.b(), dark.dark_rounds, dark.samples), (0, 0.0, 6, 120));
    assert_eq!((film.pixel(7)[0].mean, film.pixel(7)[0].stderr), (0.0, 0.0));
    assert!(tally.strata[..7].iter().all(|s| s.steps() == 600 && s.dark_rounds == 0));
    // Known to be dark, it need not even be sampled.
    let drawn = |problem: &Problem| problem.strata[7].0.drawn.load(Ordering::Relaxed);
    assert_eq!(drawn(&problem), 120);
}

#[test]
fn a_stratum_that_is_known_to_be_dark_may_be_left_out() {
    let mut problem = Problem::new(cells(8), 100, 20);
    let whole = problem.run(8, 0..6).0;
    problem.strata.pop();
    let (film, tally) = problem.run(8, 0..6);
    assert_eq!(bits(&film), bits(&whole));
    assert_eq!(tally.strata.len(), 7);
}

#[test]
fn counts_add_up_and_b_is_within_its_error() {
    let problem = Problem::new(cells(4), 1000, 400);
    let (_, tally) = problem.run(9, 0..10);
    for (stats, (cell, _)) in tally.strata.iter().zip(&problem.strata) {
        assert_eq!(stats.steps(), 10_000);
        assert_eq!(stats.samples, 4000);
        let z = (stats.b() - integral(cell.low, cell.high)) / stats.b_stderr();
        assert!(z.abs() < 4.0, "b of [{}, {}): z = {z}", cell.low, cell.high);
    }
    let steps: u64 = tally.strata.iter().map(StratumStats::steps).sum();
    assert_eq!(tally.total().steps(), steps);
}

#[test]
fn the_engine_names_no_vector_no_accelerator_and_no_scene() {
    let engine = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/engine");
    let mut files = 0;
    for entry in std::fs::read_dir(engine).unwrap() {
        let path = entry.unwrap().path();
        let source = std::fs::read_to_string(&path).unwrap().to_lowercase();
        for word in ["glam", "obvhs", "transport"] {
            assert!(!source.contains(word), "{} names {word}", path.display());
        }
        files += 1;
    }
    assert!(files > 5);
}
