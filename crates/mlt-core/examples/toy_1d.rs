//! The smallest user of the engine: a function of one variable, cut into strata.
//!
//! The film is a histogram: its site p holds the mean of f over bin p, and one more site the mean over [0, 1).
//!
//!     cargo run --release -p mlt-core --no-default-features --example toy_1d

use mlt_core::engine::{
    Accumulated, Film, Metropolis, Mixture, Mutation, Path, SetupError, Share, Splat, Stratum, render, uniform,
};
use mlt_core::rand_core::Rng;
use std::ops::ControlFlow;

/// Bins of the histogram.
const BINS: u32 = 16;
/// Strata, equal cells of [0, 1).
const STRATA: u32 = 4;
/// Rounds: independent estimates of the whole histogram.
const ROUNDS: u64 = 200;

/// f(x): a little light everywhere and two peaks.
fn f(x: f64) -> f64 {
    0.2 + peak(x, 0.31, 0.01) + 3.0 * peak(x, 0.8, 0.08)
}

/// w²/((x − c)² + w²).
fn peak(x: f64, c: f64, w: f64) -> f64 {
    w * w / ((x - c).powi(2) + w * w)
}

/// ∫ f from 0 to x.
fn integral(x: f64) -> f64 {
    let peak = |c: f64, w: f64| w * (((x - c) / w).atan() - (-c / w).atan());
    0.2 * x + peak(0.31, 0.01) + 3.0 * peak(0.8, 0.08)
}

/// A state: the number itself.
#[derive(Clone)]
struct Point(f64);

impl Path for Point {
    type Splat = Splat<1>;

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        let value = f(self.0);
        let bin = ((self.0 * f64::from(BINS)) as u32).min(BINS - 1);
        [Splat { site: bin, value: [f64::from(BINS) * value] }, Splat { site: BINS, value: [value] }].into_iter()
    }
}

/// Ω_j = [low, high).
struct Cell {
    low: f64,
    high: f64,
}

impl Cell {
    fn draw(&self, rng: &mut impl Rng) -> Point {
        Point(self.low + (self.high - self.low) * uniform(rng))
    }
}

impl Stratum<Point> for Cell {
    fn contains(&self, x: &Point) -> bool {
        self.low <= x.0 && x.0 < self.high
    }

    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&Point, f64)) {
        visit(&self.draw(rng), self.high - self.low);
    }

    fn density(&self, _: &Point) -> f64 {
        1.0 / (self.high - self.low)
    }

    fn power(&self) -> f64 {
        self.high - self.low
    }
}

/// Two ways of moving; both have T(y→x) = T(x→y).
enum Move {
    /// By up to ±0.02, round the ends of [0, 1). It may leave the stratum, and is rejected then.
    Near,
    /// To anywhere in the stratum.
    Anywhere,
}

impl Mutation<Point, Cell> for Move {
    fn name(&self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Anywhere => "anywhere",
        }
    }

    fn propose(&self, current: &Point, proposal: &mut Point, within: &Cell, rng: &mut impl Rng) -> Option<f64> {
        *proposal = match self {
            Self::Near => Point((current.0 + 0.04 * (uniform(rng) - 0.5)).rem_euclid(1.0)),
            Self::Anywhere => within.draw(rng),
        };
        Some(1.0)
    }
}

fn main() -> Result<(), SetupError> {
    let edge = |j: u32| f64::from(j) / f64::from(STRATA);
    let share = Share { mutations: 400, samples: 200 };
    let strata: Vec<_> = (0..STRATA).map(|j| (Cell { low: edge(j), high: edge(j + 1) }, share)).collect();
    let mixture = Mixture::new(vec![Move::Near, Move::Anywhere]);
    let importance = |x: &Point| f(x.0);
    let metropolis = Metropolis::new(&strata, &mixture, &importance, 1)?;
    let mut sums = Accumulated::new(Film::new(BINS + 1, 1.0));
    render(&metropolis, 0..ROUNDS, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let (film, tally) = sums.into_parts();

    println!("   bin  estimate     truth     error  std.err.");
    let print = |label: &str, site: u32, truth: f64| {
        let [pixel] = film.pixel(site as usize);
        println!("{label:>6} {:9.5} {truth:9.5} {:9.5} {:9.5}", pixel.mean, pixel.mean - truth, pixel.stderr);
    };
    let edge = |p: u32| f64::from(p) / f64::from(BINS);
    for p in 0..BINS {
        print(&p.to_string(), p, (integral(edge(p + 1)) - integral(edge(p))) * f64::from(BINS));
    }
    print("total", BINS, integral(1.0));
    println!();
    for (j, (stratum, (cell, _))) in tally.strata.iter().zip(&strata).enumerate() {
        let truth = integral(cell.high) - integral(cell.low);
        println!("stratum {j}: b = {:.5} ± {:.5}, truth {truth:.5}", stratum.b(), stratum.b_stderr());
    }
    for (mutation, stats) in mixture.mutations().iter().zip(tally.total().mutations) {
        println!("{:>9}: {:4.1} % accepted", mutation.name(), 100.0 * stats.acceptance());
    }
    tally.warnings().iter().for_each(|warning| println!("warning: {warning}"));
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("sound strata");
}
