//! Lights: what and where they are, and what they emit.
//!
//! Every light is mapped from the unit square in proportion to its power: a uniform point of the square has the density M/Φ, M being the
//! exitance there and Φ the light's power. Both refer to the light's own measure, which is area on a surface and solid angle on the
//! directions that an environment is seen in. What has no extent has all of its measure in one place, onto which the whole square is
//! mapped.

mod area;
mod emission;
mod environment;
mod even;
mod piece;
mod punctual;
mod sun;
mod triangle;
mod uneven;

use super::material::Material;
use crate::transport::colour::{Rgb, luminance};
use glam::{DVec2, Vec3, Vec3A};
use std::f32::consts::PI;

pub(crate) use area::Area;
pub use environment::Environment;
pub(super) use environment::Surroundings;
pub(crate) use piece::Piece;
pub use punctual::{Punctual, PunctualLight};
use punctual::{Rays, Source};
use sun::Sun;

/// A point of a light: the light, and coordinates in the unit square that it is mapped from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightPoint {
    /// Index of the light.
    pub light: u32,
    /// First coordinate, in [0, 1]; f64, since it also chooses the triangle of a mesh.
    pub u: f64,
    /// Second coordinate, in [0, 1].
    pub v: f64,
}

impl LightPoint {
    /// Its coordinates.
    #[inline]
    pub fn place(&self) -> DVec2 {
        DVec2::new(self.u, self.v)
    }
}

/// The shape of a light.
#[derive(Clone, Debug)]
pub struct Light {
    /// Radiance, its mean over the light; intensity of a point on its axis, irradiance of a direction across its rays.
    pub emission: Rgb,
    /// Emits from the back as well.
    pub both_sides: bool,
    /// Of a surface: ∫ |cosθ| dω over what its radiance goes into, in the mean over the surface: π, 2π from both sides, less into a
    /// cone.
    spread: f32,
    /// Measure of the whole light: of a surface its area times opacity, scene units²; of an environment 4π sr, of a sun its solid
    /// angle; 1 without extent.
    pub measure: f64,
    pub(crate) shape: Shape,
    mean_exitance: f64,
}

/// How the unit square lies on the light.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// On a surface.
    Area(Area),
    /// On the directions that a scene is seen from.
    Environment(Box<Surroundings>),
    /// On a disc of those.
    Sun(Sun),
    /// Wholly on a point.
    Point(Source),
    /// Wholly on a direction.
    Direction(Rays),
}

impl Light {
    /// A light of this mean radiance that sends it from its fronts into all directions.
    fn new(shape: Shape, measure: f64, emission: Rgb) -> Self {
        Self::spreading(shape, measure, emission, PI)
    }

    /// The same where ∫ |cosθ| dω over what a surface's radiance goes into is `spread`, in the mean over the surface.
    fn spreading(shape: Shape, measure: f64, emission: Rgb, spread: f32) -> Self {
        let brightness = luminance(emission);
        let mean_exitance = match &shape {
            Shape::Area(_) => f64::from(brightness * spread),
            Shape::Environment(around) => f64::from(brightness) * around.sphere().cross_section(),
            Shape::Sun(Sun { sphere, .. }) | Shape::Direction(Rays { sphere, .. }) => {
                f64::from(brightness) * sphere.cross_section()
            }
            Shape::Point(source) => f64::from(brightness * source.cone.solid_angle()),
        };
        Self { emission, both_sides: false, spread, measure, shape, mean_exitance }
    }

    /// The same light with another mean radiance, on the sides and into the directions that a material sends it, where only a share of it
    /// is there.
    pub(super) fn shining(self, material: &Material, emission: Rgb, opacity: f32) -> Self {
        let both_sides = material.emits_both_sides;
        // Over a closed surface, which a lamp with a cone is, the mean of |cosθ| is ¼ on the front.
        let front = material.cone.map_or(PI, |cone| 0.25 * cone.solid_angle());
        let spread = if both_sides { 2.0 * front } else { front };
        let light = Self::spreading(self.shape, self.measure * f64::from(opacity), emission, spread);
        Self { both_sides, ..light }
    }

    /// Mean of M, the power that is emitted per measure, luminance: π L of a surface, twice that for both sides; π R² L of
    /// an environment or a sun, R being the radius of a sphere around the scene; ∫ I dω of a point, π R² E of a direction.
    #[inline]
    pub fn mean_exitance(&self) -> f64 {
        self.mean_exitance
    }

    /// π times the largest intensity that it sends anywhere: of a surface that sends its radiance into all directions its power.
    pub(crate) fn brightness(&self) -> f64 {
        match &self.shape {
            Shape::Point(_) => f64::from(luminance(self.emission) * PI),
            Shape::Area(_) => self.power() * f64::from(self.spread.max(PI) / self.spread),
            _ => self.power(),
        }
    }

    /// Whether it is more than one place.
    pub(crate) fn has_extent(&self) -> bool {
        !matches!(self.shape, Shape::Point(_) | Shape::Direction(_))
    }

    /// Φ, ∫ M over the light.
    pub fn power(&self) -> f64 {
        self.mean_exitance() * self.measure
    }

    /// Largest radiance; without extent, what shows as much where it falls on a surface at the distance 1.
    pub(crate) fn brightest(&self) -> Rgb {
        match &self.shape {
            Shape::Area(Area::Uneven(uneven)) => uneven.brightest,
            Shape::Area(_) | Shape::Sun(_) | Shape::Point(_) | Shape::Direction(_) => self.emission,
            Shape::Environment(around) => around.brightest(),
        }
    }

    /// Whether a distant light that has an extent is seen in a unit direction.
    pub(super) fn is_seen_in(&self, direction: Vec3A) -> bool {
        match &self.shape {
            Shape::Environment(_) => true,
            Shape::Sun(sun) => sun.holds(direction),
            Shape::Area(_) | Shape::Point(_) | Shape::Direction(_) => false,
        }
    }

    /// Radiance from a unit direction that a distant light is seen in.
    pub(super) fn radiance(&self, direction: Vec3A) -> Rgb {
        match &self.shape {
            Shape::Environment(around) => around.radiance(direction.into()),
            _ => self.emission,
        }
    }

    /// Of a distant light, which is seen in directions and not at points: radius of the sphere that it sends light into.
    pub(crate) fn radius_around(&self) -> Option<f32> {
        match &self.shape {
            Shape::Area(_) | Shape::Point(_) => None,
            Shape::Environment(around) => Some(around.sphere().radius),
            Shape::Sun(Sun { sphere, .. }) | Shape::Direction(Rays { sphere, .. }) => Some(sphere.radius),
        }
    }

    /// Its parts, as far as they lie between two corners of the unit square, in the order of their numbers; and the first one's number. A
    /// distant light has one.
    pub(crate) fn pieces(&self, low: DVec2, high: DVec2) -> (u32, Vec<Piece>) {
        match &self.shape {
            Shape::Area(area) => area.pieces(low, high),
            Shape::Point(source) => (0, vec![source.piece([low, high])]),
            Shape::Environment(around) => (0, vec![around.piece([low, high])]),
            Shape::Sun(sun) => (0, vec![sun.piece([low, high])]),
            Shape::Direction(rays) => (0, vec![Piece::of_directions([low, high], rays.towards.into())]),
        }
    }

    /// Lengths of the sides of the unit square, in any unit; a mesh has one.
    pub(crate) fn sides(&self) -> DVec2 {
        match &self.shape {
            Shape::Area(area) => area.sides(),
            // Half a turn from the top to the bottom, a whole one around; of a disc, about as much.
            Shape::Environment(_) | Shape::Sun(_) => DVec2::new(1.0, 2.0),
            Shape::Point(_) | Shape::Direction(_) => DVec2::ONE,
        }
    }

    /// Cells along u and v of as many columns and rows as were asked for; a mesh is cut along u alone, which runs through its
    /// triangles, and a column of an environment or a sun is one of azimuths, which are v. What has no extent is one cell.
    pub(crate) fn grid(&self, size: [u32; 2]) -> [u32; 2] {
        match &self.shape {
            Shape::Area(area) => area.grid(size),
            Shape::Environment(_) | Shape::Sun(_) => [size[1], size[0]],
            Shape::Point(_) | Shape::Direction(_) => [1, 1],
        }
    }

    /// Its centre of mass, or that of the scene around which it is.
    pub fn centre(&self) -> Vec3 {
        match &self.shape {
            Shape::Area(area) => area.centre(),
            Shape::Environment(around) => around.sphere().centre.into(),
            Shape::Sun(Sun { sphere, .. }) | Shape::Direction(Rays { sphere, .. }) => sphere.centre.into(),
            Shape::Point(source) => source.position,
        }
    }

    /// Coordinates of the point of a surface's triangle number `index` (in the order given) that is nearest to `position`, or of
    /// the direction `position` of a distant light; without extent all are the same.
    pub(crate) fn coordinates(&self, index: u32, position: Vec3) -> (f64, f64) {
        match &self.shape {
            Shape::Area(area) => area.coordinates(index, position),
            Shape::Environment(around) => around.coordinates(position),
            Shape::Sun(sun) => sun.coordinates(position),
            Shape::Point(_) | Shape::Direction(_) => (0.5, 0.5),
        }
    }
}
