//! glTF's punctual lights: points, spots and directions. They have no extent, unless a direction is a sun's: nothing meets them by chance,
//! and no camera sees them.
//!
//! A point's own measure is the unit mass on it, and so is a direction's; what a point emits is an intensity, what a direction
//! sends is an irradiance across its rays.

use super::super::cone::Cone;
use super::piece::Piece;
use super::{Light, Shape, Sun};
use crate::transport::colour::{Rgb, luminance};
use crate::transport::geometry::{Space, Sphere};
use glam::{DVec2, DVec3, Vec3, Vec3A};

/// A light without a surface, as a file says it.
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    /// Name in the scene file.
    pub name: String,
    /// Radiance × world units² of a point or a spot, its intensity on the axis; radiance × sr of a direction, its irradiance across the
    /// rays in the middle of what it is seen as.
    pub emission: Rgb,
    /// How it emits.
    pub kind: Punctual,
}

/// How a light without a surface emits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
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
        /// Angle that it is seen at, as a disc, radians; 0: no extent.
        angle: f32,
    },
}

/// A point that emits into a cone, or everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    pub(crate) position: Vec3,
    pub(super) cone: Cone,
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

    /// Whether it is more than one place.
    pub(crate) fn has_extent(&self) -> bool {
        matches!(self.kind, Punctual::Directional { angle, .. } if Sun::half_angle(angle).is_some())
    }

    /// The light in a scene's own coordinates.
    pub(crate) fn light(&self, space: &Space, sphere: Sphere) -> Light {
        let per_length = space.length(1.0);
        let (shape, scale) = match self.kind {
            Punctual::Point { position } => {
                (Shape::Point(Source { position: space.point(position), cone: Cone::EVERYWHERE }), per_length.powi(2))
            }
            Punctual::Spot { position, axis, cone } => {
                let source = Source { position: space.point(position), cone: Cone::new(axis, cone) };
                (Shape::Point(source), per_length.powi(2))
            }
            Punctual::Directional { along, angle } => {
                let towards = Vec3A::from(-along);
                if let Some(half) = Sun::half_angle(angle) {
                    return Sun::light(towards, half, self.emission, sphere);
                }
                (Shape::Direction(Rays { towards, sphere }), 1.0)
            }
        };
        Light::new(shape, 1.0, scale * self.emission)
    }
}

impl Source {
    /// Bounds for the tree of lights.
    pub(super) fn piece(&self, square: [DVec2; 2]) -> Piece {
        Piece {
            square,
            low: self.position,
            high: self.position,
            normal: self.cone.axis.into(),
            spread: self.cone.angle(),
        }
    }
}
