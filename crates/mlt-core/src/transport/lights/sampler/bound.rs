//! Where near lights are, and which way they face.

use super::content::Content;
use super::node::Node;
use crate::transport::scene::Piece;
use glam::Vec3;

/// A box around pieces, and a cone around the normals of their fronts.
#[derive(Clone, Copy)]
pub(super) struct Bound {
    low: Vec3,
    high: Vec3,
    axis: Vec3,
    /// Half of the cone's opening, radians.
    spread: f64,
    power: f64,
    both_sides: bool,
}

impl Content for Bound {
    fn of(piece: &Piece, power: f64, both_sides: bool) -> Self {
        let &Piece { low, high, normal, spread, .. } = piece;
        Self { low, high, axis: normal, spread, power, both_sides }
    }

    fn union(a: &Self, b: &Self) -> Self {
        let axis = (a.axis + b.axis).normalize_or(Vec3::Z);
        // The rounding of the axes is far below the addend.
        let reach = |x: &Self| x.spread + libm::acos(f64::from(axis.dot(x.axis).clamp(-1.0, 1.0))) + 1e-3;
        Self {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
            axis,
            spread: reach(a).max(reach(b)).min(std::f64::consts::PI),
            power: a.power + b.power,
            both_sides: a.both_sides || b.both_sides,
        }
    }

    fn store(&self, i: usize, node: &mut Node) {
        let centre = 0.5 * (self.low + self.high);
        for axis in 0..3 {
            (node.centre[axis][i], node.axis[axis][i]) = (centre[axis], self.axis[axis]);
        }
        // A little more than half of the diagonal, for what rounding takes away.
        node.radius[i] = 0.5001 * (self.high - self.low).length();
        (node.spread[0][i], node.spread[1][i]) = (libm::cos(self.spread) as f32, libm::sin(self.spread) as f32);
        (node.power[i], node.both_sides[i]) = (self.power as f32, f32::from(u8::from(self.both_sides)));
    }
}
