//! A path tracer that knows nothing of ours, made Metropolis by an adapter of a few lines.
//!
//! It draws its random numbers by the trait of rand 0.9, as many existing renderers do. Nothing in it has to change: a state of the
//! chains is the numbers that it drew.
//!
//!     cargo run --release -p mlt-core --no-default-features --example your_own_tracer

use mlt_core::check::{self, Trials};
use mlt_core::engine::{Accumulated, Film, Metropolis, Mixture, SetupError, Share, Splat, render};
use mlt_core::primary::{Output, PrimaryImportance, PrimaryMutation, PrimaryStratum, Stream, Streams, Tracer};
use mlt_core::rand_core::Rng;
use rand_core_09::RngCore;
use std::ops::ControlFlow;

const PIXELS: u32 = 32;

// The tracer of somebody else.

/// Radiance of a sky with a small bright sun, through a pixel of a row that it picks itself: direction u in [0, 1), and a bounce.
fn trace(rng: &mut impl RngCore) -> (u32, f64) {
    let mut uniform = || f64::from(rng.next_u32()) / 2f64.powi(32);
    let position = f64::from(PIXELS) * uniform();
    let sky = |u: f64| if (u - 0.7).abs() < 0.01 { 50.0 } else { 0.5 };
    let direct = sky(position / f64::from(PIXELS));
    // Russian roulette: as many numbers as the path has bounces.
    let mut reflected = 0.0;
    let mut throughput = 1.0;
    while uniform() < 0.5 {
        throughput *= 0.6 / 0.5;
        reflected += throughput * 0.4 * sky(uniform());
    }
    (position as u32, direct + reflected)
}

// The adapter.

/// A stream of recorded numbers, seen through rand 0.9's trait. That of rand 0.8 asks for `try_fill_bytes` besides.
struct Recorded<'a>(&'a mut Stream);

impl RngCore for Recorded<'_> {
    fn next_u32(&mut self) -> u32 {
        self.0.next_u32()
    }

    fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    fn fill_bytes(&mut self, bytes: &mut [u8]) {
        self.0.fill_bytes(bytes);
    }
}

/// Contribution of a path, and its pixel.
#[derive(Clone, Default)]
struct Radiance {
    pixel: u32,
    value: f64,
}

impl Output for Radiance {
    type Splat = Splat<1>;

    fn importance(&self) -> f64 {
        self.value
    }

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        std::iter::once(Splat { site: self.pixel, value: [self.value] })
    }
}

struct Adapted;

impl Tracer<1> for Adapted {
    type Output = Radiance;

    fn trace(&self, [numbers]: &mut Streams<1>, output: &mut Radiance) -> bool {
        let (pixel, value) = trace(&mut Recorded(numbers));
        // It picks one of the pixels, each with probability 1/PIXELS: F is its radiance times their number.
        *output = Radiance { pixel, value: value * f64::from(PIXELS) };
        value > 0.0
    }
}

fn main() -> Result<(), SetupError> {
    let report = check::tracer(&Adapted, Trials { count: 1000, seed: 1 });
    println!("the tracer: {report}");
    assert!(report.is_sound());

    let share = Share { mutations: 20_000, samples: 5_000 };
    let strata = [(PrimaryStratum { tracer: Adapted, power: 1.0 }, share)];
    let mixture = Mixture::new(PrimaryMutation::both(0.3));
    let metropolis = Metropolis::new(&strata, &mixture, &PrimaryImportance, 1)?;
    let mut sums = Accumulated::new(Film::new(PIXELS, 1.0));
    render(&metropolis, 0..20, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let (film, tally) = sums.into_parts();
    tally.warnings().iter().for_each(|warning| println!("warning: {warning}"));

    let mut rng = Plain(mlt_core::engine::generator(2, mlt_core::engine::Purpose::Image, 0, 0, 0));
    let mut plain = vec![0.0; PIXELS as usize];
    let samples = 400_000;
    for _ in 0..samples {
        let (pixel, value) = trace(&mut rng);
        plain[pixel as usize] += value * f64::from(PIXELS) / f64::from(samples);
    }
    println!("pixel  Metropolis            plain");
    for pixel in (0..PIXELS as usize).step_by(2) {
        let [found] = film.pixel(pixel);
        println!("{pixel:>5}  {:7.4} ± {:.4}  {:7.4}", found.mean, found.stderr, plain[pixel]);
    }
    let [metropolis, plain] = [film.whole([1.0]).mean, plain.iter().sum::<f64>() / f64::from(PIXELS)];
    assert!((metropolis / plain - 1.0).abs() < 0.02, "{metropolis} against {plain}");
    Ok(())
}

/// Any generator of ours, for the comparison.
struct Plain(mlt_core::engine::Generator);

impl RngCore for Plain {
    fn next_u32(&mut self) -> u32 {
        self.0.next_u32()
    }

    fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    fn fill_bytes(&mut self, bytes: &mut [u8]) {
        self.0.fill_bytes(bytes);
    }
}

#[test]
fn it_runs() {
    main().expect("sound");
}
