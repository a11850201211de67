//! The straight line between two vertices of a path, the first of which is the one towards the light.
//!
//! A distant light's vertex is a direction, and its measure is solid angle. Light from there is dE = L |cosθ| dω at the other end,
//! so the edge has neither 1/d² nor a cosine of its own. The same holds at the other end for an orthographic camera. A point without a
//! surface has no cosine of its own either.

use crate::transport::geometry::math::abs_dot;
use crate::transport::geometry::{Place, Vertex};
use glam::Vec3A;

/// The edge between two vertices.
pub(crate) struct Edge {
    /// Unit direction from the first to the second.
    pub(crate) direction: Vec3A,
    /// τ over the squared length; τ where an end is infinitely far away.
    pub(crate) inverse_square: f32,
    /// |cosθ| at both ends, to the geometric normals.
    pub(crate) cosines: [f32; 2],
}

impl Edge {
    /// A connection; `None` if the two coincide.
    #[inline(always)]
    pub(crate) fn between(x: &Vertex, y: &Vertex) -> Option<Self> {
        if !Vertex::are_on_surfaces(x, y) {
            return Self::between_others(x, y);
        }
        let (direction, inverse_square) = Self::straight(x, y)?;
        Some(Self::new(direction, inverse_square, [x, y]))
    }

    /// Edge that a ray followed, in this unit direction from `x` to `y`.
    ///
    /// The positions do not give it back: they are rounded, and the ray starts off the surface, by as much as a pane of glass may
    /// be thick. What follows behind a specular surface depends on it. The length is less exact and matters less: between specular
    /// surfaces it is a factor of f and of every density.
    #[inline(always)]
    pub(crate) fn along(direction: Vec3A, x: &Vertex, y: &Vertex) -> Self {
        if !Vertex::are_on_surfaces(x, y) {
            return Self::along_others(direction, x, y);
        }
        Self::new(direction, 1.0 / Self::square(x, y), [x, y])
    }

    /// Direction and 1/d²; `None` if the two coincide.
    #[inline(always)]
    fn straight(x: &Vertex, y: &Vertex) -> Option<(Vec3A, f32)> {
        // Root and reciprocal do not wait for each other.
        let step = y.position - x.position;
        let square = step.length_squared();
        let inverse_square = 1.0 / square;
        let direction = step * (inverse_square * square.sqrt());
        (square > 0.0 && inverse_square.is_finite()).then_some((direction, inverse_square))
    }

    #[inline(always)]
    fn square(x: &Vertex, y: &Vertex) -> f32 {
        x.position.distance_squared(y.position).max(f32::MIN_POSITIVE)
    }

    /// A connection of which an end is not on a surface; none ends at a light that a camera subpath has met.
    #[inline(always)]
    fn between_others(x: &Vertex, y: &Vertex) -> Option<Self> {
        if y.is_distant() {
            return None;
        }
        if x.is_distant() | y.is_parallel() {
            let direction = if y.is_parallel() { -y.geometric_normal } else { -x.position };
            return Some(Self::of_others(direction, 1.0, [x, y]));
        }
        let (direction, inverse_square) = Self::straight(x, y)?;
        Some(Self::of_others(direction, inverse_square, [x, y]))
    }

    /// The same of an edge that a ray followed.
    #[inline(always)]
    fn along_others(direction: Vec3A, x: &Vertex, y: &Vertex) -> Self {
        let endless = x.is_distant() | y.is_parallel();
        Self::of_others(direction, if endless { 1.0 } else { 1.0 / Self::square(x, y) }, [x, y])
    }

    #[inline(always)]
    fn of_others(direction: Vec3A, inverse_square: f32, ends: [&Vertex; 2]) -> Self {
        let cos = |end: &Vertex| match end.place {
            Place::Surface => abs_dot(end.geometric_normal, direction),
            Place::Distant | Place::Direction | Place::Point | Place::Parallel => 1.0,
        };
        Self { direction, inverse_square, cosines: ends.map(cos) }
    }

    #[inline(always)]
    fn new(direction: Vec3A, inverse_square: f32, ends: [&Vertex; 2]) -> Self {
        Self { direction, inverse_square, cosines: ends.map(|end| abs_dot(end.geometric_normal, direction)) }
    }

    /// The same edge where the share `passed` gets through.
    #[inline(always)]
    pub(crate) fn veiled(self, passed: f32) -> Self {
        Self { inverse_square: self.inverse_square * passed, ..self }
    }

    /// G τ = |cosθ cosθ'| τ / d².
    #[inline(always)]
    pub(crate) fn geometric_term(&self) -> f64 {
        f64::from(self.cosines[0] * self.cosines[1]) * f64::from(self.inverse_square)
    }
}
