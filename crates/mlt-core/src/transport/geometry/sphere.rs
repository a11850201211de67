//! A sphere around a scene, into which distant lights send parallel rays.

use super::math::{frame, square_to_disk};
use glam::{Vec2, Vec3, Vec3A};
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

/// A sphere that holds all surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sphere {
    pub(crate) centre: Vec3A,
    pub(crate) radius: f32,
}

impl Sphere {
    /// About the middle of a bounding box.
    pub(crate) fn around(points: impl Iterator<Item = Vec3> + Clone) -> Self {
        let low = points.clone().fold(Vec3::INFINITY, Vec3::min);
        let high = points.clone().fold(Vec3::NEG_INFINITY, Vec3::max);
        let centre = 0.5 * (low + high);
        let radius = points.map(|p| p.distance_squared(centre)).fold(0.0, f32::max).sqrt();
        // A little more, for what rounding takes away.
        Self { centre: centre.into(), radius: (1.0001 * radius).max(f32::MIN_POSITIVE) }
    }

    /// A ray that goes along `direction` into the sphere, through a point of the disc that faces it, from the unit square.
    pub(crate) fn ray_along(&self, direction: Vec3A, u: Vec2) -> (Vec3A, Vec3A) {
        let (s, t) = frame(direction);
        let disc = square_to_disk(u).0;
        (self.centre + self.radius * (disc.x * s + disc.y * t - direction), direction)
    }

    /// Start, outside of the sphere, of the ray along `direction` through a point.
    pub(crate) fn start_of_ray(&self, direction: Vec3A, through: Vec3A) -> Vec3A {
        through - direction * ((through - self.centre).dot(direction) + self.radius)
    }

    /// Area of that disc, π R².
    pub(crate) fn cross_section(&self) -> f64 {
        PI * f64::from(self.radius).powi(2)
    }

    /// Density of that point of the disc, per its area: 1/(π R²).
    pub(crate) fn pdf(&self) -> f32 {
        FRAC_1_PI / (self.radius * self.radius)
    }
}
