//! A ray as the tree is walked along it.

use super::binary::MAX_COORDINATE;
use crate::transport::geometry::Ray;
use glam::Vec3A;

/// A ray, ready for arithmetic on four lanes.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub origin: Vec3A,
    pub direction: Vec3A,
    pub t_max: f32,
}

impl Segment {
    /// Whether it is finite, not empty, and has a direction of moderate length.
    #[inline(always)]
    pub(super) fn is_sound(&self) -> bool {
        let (origin, direction) = (self.origin.abs(), self.direction.abs());
        let finite = origin.cmple(Vec3A::splat(MAX_COORDINATE)) & direction.cmple(Vec3A::splat(1e6));
        finite.all() && direction.cmpge(Vec3A::splat(1e-6)).any() && self.t_max > 0.0
    }

    /// The same with a direction of moderate length, and its t in units of the given ray's; `None` if it can hit nothing.
    pub(super) fn scaled(&self) -> Option<(Self, f64)> {
        let length = self.direction.abs().max_element();
        let reachable = self.origin.abs().cmple(Vec3A::splat(MAX_COORDINATE)).all();
        if !(reachable && self.direction.is_finite() && length > 0.0) {
            return None;
        }
        // A power of two: the scaled ray is the same ray.
        let unit = libm::exp2(-libm::floor(libm::log2(f64::from(length))));
        let direction = (self.direction.as_dvec3() * unit).as_vec3a();
        let t_max = (f64::from(self.t_max) / unit) as f32;
        (t_max > 0.0).then_some((Self { direction, t_max, ..*self }, unit))
    }
}

impl From<Segment> for Ray {
    fn from(segment: Segment) -> Self {
        Self { origin: segment.origin.into(), direction: segment.direction.into(), t_max: segment.t_max }
    }
}
