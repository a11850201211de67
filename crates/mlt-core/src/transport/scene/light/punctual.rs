//! Lights without extent: points, spots and directions. Nothing meets them by chance, and no camera sees them.
//!
//! A point's own measure is the unit mass on it, and so is a direction's; what a point emits is an intensity, what a direction
//! sends is an irradiance across its rays.

use super::piece::Piece;
use super::{Light, Shape};
use crate::transport::colour::{Rgb, luminance};
use crate::transport::geometry::math::{frame, turn};
use crate::transport::geometry::{Space, Sphere};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec3A};
use std::f32::consts::{PI, TAU};

/// A light without extent, as a file says it.
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    /// Name in the scene file.
    pub name: String,
    /// Radiance × world units² of a point or a spot, its intensity on the axis; radiance × sr of a direction, its irradiance across the
    /// rays.
    pub emission: Rgb,
    /// How it emits.
    pub kind: Punctual,
}

/// How a light without extent emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Punctual {
    /// The same in all directions.
    Point {
        /// World position.
        position: DVec3,
    },
    /// In a cone.
    Spot {
        /// World position.
        position: DVec3,
        /// Unit vector along the axis, away from the light.
        axis: Vec3,
        /// Angles with the axis up to which all, and from which on nothing is emitted, radians.
        cone: [f32; 2],
    },
    /// From infinitely far away.
    Directional {
        /// Unit vector along the rays, away from the light.
        along: Vec3,
    },
}

/// A point that emits into a cone, or everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    pub(crate) position: Vec3,
    axis: Vec3A,
    /// Cosines of the angles with the axis up to which all, and from which on nothing is emitted.
    cosines: [f32; 2],
}

/// Parallel rays into the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    /// Unit vector to the light.
    pub(crate) towards: Vec3A,
    /// Around the scene.
    pub(super) sphere: Sphere,
}

impl PunctualLight {
    /// Whether it sends any light.
    pub(crate) fn is_lit(&self) -> bool {
        luminance(self.emission) > 0.0
    }

    /// The light in a scene's own coordinates.
    pub(crate) fn light(&self, space: &Space, sphere: Sphere) -> Light {
        let per_length = space.length(1.0);
        let (shape, scale) = match self.kind {
            Punctual::Point { position } => {
                let cosines = [-1.0; 2];
                (Shape::Point(Source { position: space.point(position), axis: Vec3A::Z, cosines }), per_length.powi(2))
            }
            Punctual::Spot { position, axis, cone } => {
                let source =
                    Source { position: space.point(position), axis: axis.into(), cosines: cone.map(libm::cosf) };
                (Shape::Point(source), per_length.powi(2))
            }
            Punctual::Directional { along } => (Shape::Direction(Rays { towards: (-along).into(), sphere }), 1.0),
        };
        Light::new(shape, 1.0, scale * self.emission, false)
    }
}

impl Source {
    /// Share of the axis's intensity that goes into a direction: ((cosθ − cosθ_o)/(cosθ_i − cosθ_o))², between 0 and 1.
    ///
    /// Source: glTF's extension KHR_lights_punctual.
    pub(super) fn share(&self, direction: Vec3A) -> f32 {
        let [inner, outer] = self.cosines;
        if outer <= -1.0 {
            return 1.0;
        }
        ((self.axis.dot(direction) - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2)
    }

    /// ∫ of that share over all directions, sr: 2π ((1 − cosθ_i) + (cosθ_i − cosθ_o)/3).
    pub(super) fn solid_angle(&self) -> f32 {
        let [inner, outer] = self.cosines;
        let rim = (inner - outer).max(if outer <= -1.0 { 0.0 } else { 1e-3 });
        // What is narrower than the rim is cut off by the axis.
        let top = ((1.0 - outer) / rim.max(f32::MIN_POSITIVE)).min(1.0);
        TAU * ((1.0 - outer - rim).max(0.0) + rim * top * top * top / 3.0)
    }

    /// A uniform direction of the cone, from the unit square.
    pub(super) fn direction(&self, u: Vec2) -> Vec3A {
        let cos = 1.0 - u.x * (1.0 - self.cosines[1]);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (s, t) = frame(self.axis);
        let about = turn(u.y);
        (sin * (about.x * s + about.y * t) + cos * self.axis).normalize()
    }

    /// Its density in the cone, sr⁻¹.
    pub(super) fn pdf(&self) -> f32 {
        1.0 / (TAU * (1.0 - self.cosines[1]))
    }

    /// Bounds for the tree of lights.
    pub(super) fn piece(&self, square: [DVec2; 2]) -> Piece {
        let spread = libm::acos(f64::from(self.cosines[1].clamp(-1.0, 1.0)));
        Piece { square, low: self.position, high: self.position, normal: self.axis.into(), spread }
    }

    /// Unit vector along the axis.
    pub(super) fn axis(&self) -> Vec3A {
        self.axis
    }
}

impl Rays {
    /// Area of the disc that rays into the scene start on.
    pub(super) fn cross_section(&self) -> f64 {
        f64::from(PI * self.sphere.radius * self.sphere.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spot's power is the integral of its shares, by the midpoint rule over the cosine; for equal angles, and for wide ones.
    #[test]
    fn solid_angles_are_integrals_of_shares() {
        for cone in [[0.2f32, 0.5], [0.0, 0.7], [0.4, 0.4], [0.0, 0.0], [1.5, 1.57], [0.0, 3.0]] {
            let source = Source { position: Vec3::ZERO, axis: Vec3A::Z, cosines: cone.map(libm::cosf) };
            let n = 400_000;
            let share = |i: i32| {
                let cos = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
                f64::from(source.share(Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos)))
            };
            let sum: f64 = (0..n).map(share).sum::<f64>() * 2.0 / f64::from(n) * f64::from(TAU);
            let found = f64::from(source.solid_angle());
            assert!((found - sum).abs() < 1e-3 * sum + 1e-6, "{cone:?}: {found} {sum}");
        }
        let point = Source { position: Vec3::ZERO, axis: Vec3A::Z, cosines: [-1.0; 2] };
        assert!((point.solid_angle() - 4.0 * PI).abs() < 1e-5 && (point.pdf() * 4.0 * PI - 1.0).abs() < 1e-6);
    }
}
