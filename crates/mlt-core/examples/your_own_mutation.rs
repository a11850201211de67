//! A mutation of your own beside others: in proportion to the state, with the ratio that this needs, and how to find out whether
//! that is right.
//!
//!     cargo run --release -p mlt-core --no-default-features --example your_own_mutation

use mlt_core::check::{self, Law, Trials};
use mlt_core::engine::{Mixture, Mutation, Path, Splat, Stratum, uniform};
use mlt_core::rand_core::Rng;

/// A number in (0, 1].
#[derive(Clone)]
struct X(f64);

impl Path for X {
    type Splat = Splat<1>;

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        std::iter::once(Splat { site: 0, value: [importance(self)] })
    }
}

/// I(x), which has a peak at 0.
fn importance(x: &X) -> f64 {
    1.0 / (0.01 + x.0)
}

/// All of (0, 1].
struct Line;

impl Stratum<X> for Line {
    fn contains(&self, x: &X) -> bool {
        0.0 < x.0 && x.0 <= 1.0
    }

    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
        visit(&X(1.0 - uniform(rng)), 1.0);
    }

    fn density(&self, _: &X) -> f64 {
        1.0
    }

    fn power(&self) -> f64 {
        1.0
    }
}

/// Mutations of different kinds are variants of one enum.
enum Move {
    /// To anywhere: T(x→y) = 1.
    Anywhere,
    /// y = x·2^ξ, ξ uniform in ±1: T(x→y) = 1/(2 y ln 2), so T(y→x)/T(x→y) = y/x. `right`: whether that is returned.
    Scale { right: bool },
}

impl Mutation<X, Line> for Move {
    fn name(&self) -> &'static str {
        match self {
            Self::Anywhere => "anywhere",
            Self::Scale { .. } => "scale",
        }
    }

    fn propose(&self, x: &X, y: &mut X, _: &Line, rng: &mut impl Rng) -> Option<f64> {
        match self {
            Self::Anywhere => y.0 = 1.0 - uniform(rng),
            Self::Scale { .. } => y.0 = x.0 * (2.0 * uniform(rng) - 1.0).exp2(),
        }
        Some(if matches!(self, Self::Scale { right: true }) { y.0 / x.0 } else { 1.0 })
    }
}

fn main() {
    let trials = Trials { count: 50_000, seed: 1 };
    // Bins by octave: what the mutation changes.
    let bin = |x: &X| (-x.0.log2()).min(7.0) as usize;
    let report = |right| {
        let mixture = Mixture::new(vec![Move::Anywhere, Move::Scale { right }]);
        check::mutation(&mixture, &Line, &importance, bin, trials)
    };
    println!("as it should be: {}", report(true));
    assert!(report(true).is_sound());
    println!("without its ratio: {}", report(false));
    assert!(report(false).breaks(Law::Inverse));
}

#[test]
fn it_runs() {
    main();
}
