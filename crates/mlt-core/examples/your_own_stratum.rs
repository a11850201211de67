//! Strata of your own: the unit disc, cut into rings of equal area, and how to find out whether they are right.
//!
//!     cargo run --release -p mlt-core --no-default-features --example your_own_stratum

use mlt_core::check::{self, Law, Trials};
use mlt_core::engine::{Stratum, uniform};
use mlt_core::rand_core::Rng;

/// A point of the disc.
#[derive(Clone)]
struct Point {
    x: f64,
    y: f64,
}

/// The points whose squared radius is in [low, high): π (high − low) is its area.
struct Ring {
    low: f64,
    high: f64,
}

impl Stratum<Point> for Ring {
    /// Which ring a point is in has to follow from the point alone.
    fn contains(&self, p: &Point) -> bool {
        (self.low..self.high).contains(&(p.x * p.x + p.y * p.y))
    }

    /// A uniform point of the ring, with the weight 1/p: its area.
    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&Point, f64)) {
        let radius = (self.low + (self.high - self.low) * uniform(rng)).sqrt();
        let angle = std::f64::consts::TAU * uniform(rng);
        let point = Point { x: radius * angle.cos(), y: radius * angle.sin() };
        // Rounding may put a point upon an edge on the other side of it.
        if self.contains(&point) {
            visit(&point, std::f64::consts::PI * (self.high - self.low));
        }
    }

    /// The density of such samples, where a chain may ask for it.
    fn density(&self, _: &Point) -> f64 {
        1.0 / (std::f64::consts::PI * (self.high - self.low))
    }

    /// Guess of b_j before anything is measured.
    fn power(&self) -> f64 {
        self.high - self.low
    }
}

fn rings(edges: &[f64]) -> Vec<Ring> {
    edges.windows(2).map(|edge| Ring { low: edge[0], high: edge[1] }).collect()
}

fn main() {
    let whole = Ring { low: 0.0, high: 1.0 };
    let importance = |p: &Point| 1.0 + p.x;
    let trials = Trials { count: 20_000, seed: 1 };
    let report = check::strata(&rings(&[0.0, 0.25, 0.5, 0.75, 1.0]), &whole, &importance, trials);
    println!("four rings: {report}");
    assert!(report.is_sound());

    let mut wrong = rings(&[0.0, 0.25, 0.5, 0.75, 1.0]);
    wrong[1].high = 0.49;
    let report = check::strata(&wrong, &whole, &importance, trials);
    println!("with a gap: {report}");
    assert!(report.breaks(Law::Covered));
}

#[test]
fn it_runs() {
    main();
}
