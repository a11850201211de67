//! Where distant lights are seen.

use super::content::Content;
use super::node::Node;
use crate::transport::scene::Piece;
use glam::DVec3;

/// Least width of directions, so that an estimate is positive also where rounding takes a light's edge below the horizon.
const LEAST_WIDTH: f64 = 1e-6;

/// Directions by their mean, weighted by power: it is as long as they agree.
#[derive(Clone, Copy)]
pub(super) struct Directions {
    mean: DVec3,
    power: f64,
}

impl Content for Directions {
    fn of(piece: &Piece, power: f64, _: bool) -> Self {
        Self { mean: piece.low.as_dvec3(), power }
    }

    fn union(a: &Self, b: &Self) -> Self {
        let power = a.power + b.power;
        let mean = if power > 0.0 { (a.power * a.mean + b.power * b.mean) / power } else { a.mean };
        Self { mean, power }
    }

    fn store(&self, i: usize, node: &mut Node) {
        for axis in 0..3 {
            node.centre[axis][i] = self.mean[axis] as f32;
        }
        node.radius[i] = (0.25 * (1.0 - self.mean.length_squared())).max(LEAST_WIDTH) as f32;
        node.power[i] = self.power as f32;
    }
}
