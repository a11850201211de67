//! The way between two vertices, which light goes if nothing stands there.

use crate::transport::geometry::{Ray, Vertex};
use glam::Vec3A;

/// The way between two vertices, off their surfaces.
#[derive(Clone, Copy)]
pub(super) struct Way {
    from: Vec3A,
    to: Vec3A,
    /// Whether `to` is the direction of a way without end.
    pub(super) endless: bool,
}

impl Way {
    /// The way between two points. It starts where coordinates are finer: its end is rounded in proportion to its length, which would
    /// put it behind a small surface that is seen from a large one.
    #[inline(always)]
    pub(super) fn segment(a: &Vertex, b: &Vertex) -> Self {
        let towards_b = b.position - a.position;
        let (at_a, at_b) = (a.origin(towards_b), b.origin(-towards_b));
        let (from, to) = if a.error <= b.error { (at_a, at_b) } else { (at_b, at_a) };
        Self { from, to, endless: false }
    }

    /// The way between any two vertices: from a point to a distant one, and from the plane that parallel rays start from.
    pub(super) fn between(a: &Vertex, b: &Vertex) -> Self {
        if a.is_distant() | b.is_distant() {
            let (near, far) = if a.is_distant() { (b, a) } else { (a, b) };
            Self { from: near.origin(far.position), to: far.position, endless: true }
        } else if a.is_parallel() | b.is_parallel() {
            Self::segment(&a.opposite(b), &b.opposite(a))
        } else {
            Self::segment(a, b)
        }
    }

    /// The rest of it, as a step to its end or, of a way without end, in its direction.
    #[inline(always)]
    pub(super) fn step(&self) -> Vec3A {
        if self.endless { self.to } else { self.to - self.from }
    }

    /// The rest of it, behind a surface on it; nothing where the surface is within rounding of the end. From there the rest would lead back, and
    /// for ever back and forth among clear surfaces.
    #[inline(always)]
    pub(super) fn behind(&self, surface: &Vertex) -> Option<Self> {
        let step = self.step();
        let rest = Self { from: surface.origin(step), ..*self };
        (rest.step().dot(step) > 0.0).then_some(rest)
    }

    /// The ray that goes it.
    #[inline(always)]
    pub(super) fn ray(&self) -> Ray {
        let t_max = if self.endless { f32::INFINITY } else { 1.0 };
        Ray { origin: self.from.into(), direction: self.step().into(), t_max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point on a surface across the x axis, found to so much.
    fn across(x: f32, error: f32) -> Vertex {
        Vertex { error, ..Vertex::camera(Vec3A::X * x, Vec3A::X) }
    }

    #[test]
    fn a_way_ends_behind_a_surface_that_is_within_rounding_of_its_end() {
        let way = Way::segment(&across(0.0, 1e-6), &across(1.0, 1e-6));
        for (x, error, goes_on) in [(0.5, 1e-6, true), (0.9999, 1e-6, true), (0.9999, 1e-3, false), (0.5, 0.6, false)] {
            let rest = way.behind(&across(x, error));
            assert_eq!(rest.is_some(), goes_on, "{x} {error}");
            assert!(rest.is_none_or(|rest| rest.step().x > 0.0 && rest.to == way.to));
        }
        let endless = Way { endless: true, ..way };
        assert!(endless.behind(&across(0.9999, 1e-3)).is_some());
    }
}
