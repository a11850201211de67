//! The acceleration structure.

use super::ray::{Hit, Ray};
use glam::Vec3;

/// Triangles in a bounding-volume hierarchy.
pub struct Accel;

impl Accel {
    /// Builds over `triangles`.
    pub fn new(_triangles: &[[Vec3; 3]]) -> Self {
        Self
    }

    /// The nearest hit with 0 < t ≤ t_max.
    pub fn closest(&self, _ray: &Ray) -> Option<Hit> {
        None
    }

    /// Whether anything lies in 0 < t ≤ t_max.
    pub fn occluded(&self, _ray: &Ray) -> bool {
        false
    }
}
