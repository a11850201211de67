//! A ray and what it hits.

use glam::Vec3;

/// The segment { origin + t·direction : 0 < t ≤ t_max }.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, scene units.
    pub origin: Vec3,
    /// Any non-zero length; t is in units of it.
    pub direction: Vec3,
    /// Largest t, inclusive.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }

    /// Where it meets the plane of a triangle, in f64: not finite if it is parallel to it.
    pub fn plane_parameter(&self, corners: [Vec3; 3]) -> f64 {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        (a - self.origin.as_dvec3()).dot(normal) / self.direction.as_dvec3().dot(normal)
    }

    /// origin + t·direction, rounded once.
    pub fn at(&self, t: f64) -> Vec3 {
        (self.origin.as_dvec3() + t * self.direction.as_dvec3()).as_vec3()
    }
}

/// The nearest point of a triangle mesh on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle, in the order the accelerator was given them.
    pub primitive: u32,
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the triangle's second vertex, in [0, 1].
    pub u: f32,
    /// Barycentric weight of its third vertex, in [0, 1].
    pub v: f32,
}
