//! Light that came to places by way of specular surfaces.

use super::lobe::Lobe;
use crate::transport::geometry::Vertex;
use glam::Vec3A;

/// Light that came to a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photon {
    pub(super) at: Place,
    /// The specular vertex that it came from.
    pub(super) from: Vec3A,
}

/// A point of a surface. Those of two walls are far apart in the tree, even in the corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) position: Vec3A,
    pub(super) normal: Vec3A,
}

impl Place {
    pub(super) fn of(vertex: &Vertex) -> Self {
        Self { position: vertex.position, normal: vertex.geometric_normal }
    }

    /// Of a position below axis 3, of a normal of length `size` from there on.
    pub(super) fn coordinate(&self, axis: usize, size: f32) -> f32 {
        if axis < 3 { self.position[axis] } else { size * self.normal[axis - 3] }
    }
}

impl Photon {
    /// Where it came from.
    pub(super) fn direction(&self) -> Vec3A {
        Lobe::towards(self.from - self.at.position, 1.0).axis
    }

    /// Its directions at x.
    pub(super) fn lobe(&self, x: Vec3A) -> Lobe {
        let to_specular = self.from - x;
        let square = to_specular.length_squared().max(f32::MIN_POSITIVE);
        Lobe::towards(to_specular, 0.5 * (self.at.position - x).length_squared() / square)
    }
}
