//! A render that another thread watches and stops: it sees a preview after every round and may end it at any time.
//!
//!     cargo run --release -p mlt-core --no-default-features --example cancel

use mlt_core::engine::{
    Accumulated, Film, Metropolis, Mixture, Mutation, Outcome, Path, Progress, SetupError, Share, Splat, Stratum,
    Tally, render, uniform,
};
use mlt_core::rand_core::Rng;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;

/// Rounds that the watcher is content with.
const ENOUGH: u64 = 5;

fn main() -> Result<(), SetupError> {
    let stop = AtomicBool::new(false);
    let (sender, previews) = mpsc::channel::<(u64, Vec<[f32; 1]>)>();
    thread::scope(|scope| {
        scope.spawn(|| {
            for (rounds, pixels) in previews {
                println!("{rounds} rounds: {:.3?}", &pixels[..4]);
                stop.store(rounds >= ENOUGH, Ordering::Relaxed);
            }
        });
        let strata = [(Line, Share { mutations: 4000, samples: 400 })];
        let (mixture, importance) = (Mixture::new(vec![Step]), |x: &X| x.0);
        let metropolis = Metropolis::new(&strata, &mixture, &importance, 1)?;
        let mut sums = Accumulated::new(Film::new(16, 1.0));
        // It is called after every batch of work too, so that even a long round can be stopped.
        let mut observe = |at: Progress, sums: &Accumulated<1, Tally>| {
            if at.fraction == 0.0 {
                // Nobody looks any more: then the flag says so, too.
                let _ = sender.send((at.rounds, sums.film().preview()));
            }
            if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let outcome = render(&metropolis, 0..u64::MAX, &mut sums, &mut observe);
        drop(sender);
        println!("{outcome:?} after the rounds {}; all of them are in the film", sums.rounds());
        assert_eq!(outcome, Outcome::Stopped);
        Ok(())
    })
}

/// A number in [0, 1) that lights one of 16 sites.
#[derive(Clone)]
struct X(f64);

impl Path for X {
    type Splat = Splat<1>;

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        std::iter::once(Splat { site: (16.0 * self.0) as u32, value: [16.0 * self.0] })
    }
}

/// All of [0, 1).
struct Line;

impl Stratum<X> for Line {
    fn contains(&self, x: &X) -> bool {
        (0.0..1.0).contains(&x.0)
    }

    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
        visit(&X(uniform(rng)), 1.0);
    }

    fn density(&self, _: &X) -> f64 {
        1.0
    }

    fn power(&self) -> f64 {
        1.0
    }
}

struct Step;

impl Mutation<X, Line> for Step {
    fn name(&self) -> &'static str {
        "step"
    }

    fn propose(&self, x: &X, y: &mut X, _: &Line, rng: &mut impl Rng) -> Option<f64> {
        y.0 = (x.0 + 0.2 * (uniform(rng) - 0.5)).rem_euclid(1.0);
        Some(1.0)
    }
}

#[test]
fn it_stops() {
    main().expect("sound");
}
