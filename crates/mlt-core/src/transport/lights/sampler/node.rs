//! Bounds on the irradiance that the four parts of a node of a [`Tree`](super::tree::Tree) send to a vertex.

use glam::{Vec3A, Vec4};
use std::array;

/// Parts that a node has; a [`Vec4`] holds a number for each.
pub(super) const WIDTH: usize = 4;

/// A quarter each of a run of leaves: a ball around its pieces and a cone around the normals of their fronts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// Of directions, which have no place, their mean m.
    pub(super) centre: [Vec4; 3],
    /// Of directions (1 − m²)/4, so that the estimate is right for those all around.
    pub(super) radius: Vec4,
    pub(super) axis: [Vec4; 3],
    /// Cosine and sine of half of the cone's opening.
    pub(super) spread: [Vec4; 2],
    /// Share of the power of all lights; zero where a run of fewer than four leaves has no such part.
    pub(super) power: Vec4,
    /// 1 where something emits from its back as well.
    pub(super) both_sides: Vec4,
    /// The part's node, where it has more than one leaf.
    pub(super) below: [u32; WIDTH],
}

/// Lengths, and cosines and sines of angles in [0, π] times the lengths.
#[derive(Clone, Copy)]
struct Scaled {
    length: Vec4,
    cos: Vec4,
    sin: Vec4,
}

impl Scaled {
    #[inline]
    fn of(length: Vec4, cos: Vec4) -> Self {
        Self { length, cos, sin: (length * length - cos * cos).max(Vec4::ZERO).sqrt() }
    }

    /// max(0, self − other), and the products of the lengths.
    #[inline]
    fn beyond(self, other: Self) -> Self {
        let length = self.length * other.length;
        let inside = (self.cos * other.length).cmpge(other.cos * self.length);
        let cos = self.cos * other.cos + self.sin * other.sin;
        let sin = self.sin * other.cos - self.cos * other.sin;
        Self { length, cos: Vec4::select(inside, length, cos), sin: Vec4::select(inside, Vec4::ZERO, sin) }
    }
}

#[inline]
fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Node {
    /// Bounds on the irradiance at a vertex, but for a factor: power × cos θ' × cos θ_i' / d², where θ' is the least angle
    /// of any of the normals with the direction to the vertex, and θ_i' that of the vertex's normal with any direction to
    /// the ball. A bound is zero only where nothing arrives.
    #[inline]
    pub(super) fn irradiance(&self, position: Vec3A, normal: Vec3A) -> Vec4 {
        let [px, py, pz] = position.to_array().map(Vec4::splat);
        let away = [px - self.centre[0], py - self.centre[1], pz - self.centre[2]];
        let (square, ball_square) = (dot(&away, &away), self.radius * self.radius);
        let (distance, outside) = (square.sqrt(), square - ball_square);
        let ball = Scaled { length: distance, cos: outside.max(Vec4::ZERO).sqrt(), sin: self.radius };
        let cone = Scaled { length: Vec4::ONE, cos: self.spread[0], sin: self.spread[1] };
        let front = dot(&self.axis, &away);
        let facing = Vec4::select(self.both_sides.cmpgt(Vec4::ZERO), front.abs(), front);
        let leaving = Scaled::of(distance, facing).beyond(cone).beyond(ball);
        let arriving = Scaled::of(distance, dot(&normal.to_array().map(Vec4::splat), &away).abs()).beyond(ball);
        let inverse = Vec4::ONE / square.max(ball_square).max(Vec4::splat(f32::MIN_POSITIVE));
        let cosines = (leaving.cos.max(Vec4::ZERO) * inverse) * (arriving.cos * inverse);
        self.power * inverse * Vec4::select(outside.cmpgt(Vec4::ZERO), cosines, Vec4::ONE)
    }

    /// Estimates of the irradiance from afar at a surface with the normal n on the side that is lit, but for a factor: power × mean of
    /// max(0, n·ω) = (n·ω + |n·ω|)/2, for which stands (n·m + √((n·m)² + w))/2 with the mean direction m and the width w. It is zero only for
    /// a single direction behind the surface. Where both sides are lit, power × √((n·m)² + w).
    #[inline]
    pub(super) fn irradiance_from_afar(&self, normal: Vec3A, both_sides: bool) -> Vec4 {
        let along = dot(&normal.to_array().map(Vec4::splat), &self.centre);
        let size = (along * along + self.radius).sqrt();
        self.power * if both_sides { size } else { 0.5 * (along + size) }
    }

    /// Probabilities of the parts by such weights.
    #[inline]
    pub(super) fn probabilities(&self, weights: Vec4) -> Vec4 {
        let total = weights.element_sum();
        if total > 0.0 && total.is_finite() { weights / total } else { self.power / self.power.element_sum() }
    }
}

/// Where leaves `first` to `last` − 1 are parted, with both ends.
#[inline]
pub(super) fn quarters(first: usize, last: usize) -> [usize; WIDTH + 1] {
    array::from_fn(|i| first + i * (last - first) / WIDTH)
}
