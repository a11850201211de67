//! Light that comes from all directions, infinitely far away.
//!
//! Radiance is an equirectangular image of the directions ω, interpolated linearly in azimuth and in height, z = ω·up. Azimuth and height
//! are the coordinates in which solid angle is dω = dφ dz, so luminance, linear in both, is drawn exactly: see [`distribution`].
//!
//! A light subpath starts with a direction ω and a ray that goes along −ω from a uniform point of the disc of radius R that faces the scene
//! from there, R being that of a sphere around the scene: so M = π R² L, the power per solid angle, and x_1 has the density |cosθ_1|/(π R²)
//! per area. docs/theory-lights.md.

mod distribution;
mod guide;
mod surroundings;

use crate::transport::colour::Rgb;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

pub(in crate::transport::scene) use surroundings::Surroundings;

/// An environment, as a scene's description has it.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Columns and rows.
    size: [u32; 2],
    /// Radiance row by row, from the top (+y): pixel (i, j) of w × h is centred at azimuth 2π (i + ½)/w − π from +x towards +z and at the
    /// angle π (j + ½)/h from +y.
    pixels: Vec<Rgb>,
    /// Angle by which it is turned anticlockwise, seen from above, radians.
    pub rotation: f64,
    /// Factor of its radiance.
    pub strength: f32,
    /// Whether the camera sees it where no surface stands before it; it lights the scene in any case.
    pub visible: bool,
}

/// Columns and rows of the neutral sky.
const SKY: [u32; 2] = [64, 32];
/// Direction that the neutral sky is brightest in, not normalised: from above, a little from −x and less from +z, so that no two sides of
/// a box are lit alike.
const SKY_BRIGHTEST: DVec3 = DVec3::new(-0.5, 0.8, 0.33);
/// How much more than in the mean its radiance is there, and how much less in the opposite direction, as a share of the mean.
const SKY_SLOPE: f64 = 0.8;

impl Environment {
    /// From the pixels of an equirectangular image, row by row from the top, and the number of those that no radiance can have:
    /// what is negative or not finite becomes 0. `None` unless there are as many pixels as the size says, at least one.
    pub fn image(size: [u32; 2], mut pixels: Vec<Rgb>) -> Option<(Self, usize)> {
        let count = size[0] as usize * size[1] as usize;
        let mut repaired = 0;
        for pixel in &mut pixels {
            let whole = pixel.to_array().map(|x| if x.is_finite() { x.max(0.0) } else { 0.0 });
            repaired += usize::from(whole != pixel.to_array());
            *pixel = whole.into();
        }
        let environment = Self { size, pixels, rotation: 0.0, strength: 1.0, visible: true };
        (count > 0 && environment.pixels.len() == count).then_some((environment, repaired))
    }

    /// The same radiance from everywhere.
    pub fn constant(radiance: Rgb) -> Self {
        Self { size: [1, 1], pixels: vec![radiance], rotation: 0.0, strength: 1.0, visible: true }
    }

    /// A colourless sky of radiance (5 + 4 cosθ)/9 at the angle θ from its brightest direction, where it is 1. A diffuse surface whose normal
    /// is at that angle shows (5 + 2.67 cosθ)/9 times its albedo: shapes are told apart, and white is not overexposed.
    pub fn sky() -> Self {
        let brightest = SKY_BRIGHTEST.normalize();
        let radiance = |i: u32, j: u32| {
            let (azimuth, polar) = (azimuth(f64::from(i), SKY[0]), PI * (f64::from(j) + 0.5) / f64::from(SKY[1]));
            let (sin, cos) = (libm::sin(polar), libm::cos(polar));
            let direction = DVec3::new(sin * libm::cos(azimuth), cos, sin * libm::sin(azimuth));
            Rgb::splat(((1.0 + SKY_SLOPE * direction.dot(brightest)) / (1.0 + SKY_SLOPE)) as f32)
        };
        let pixels = (0..SKY[1]).flat_map(|j| (0..SKY[0]).map(move |i| radiance(i, j))).collect();
        Self { size: SKY, pixels, ..Self::constant(Rgb::ZERO) }
    }

    /// Columns and rows of its image.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether any light comes from it.
    pub fn is_lit(&self) -> bool {
        self.strength > 0.0 && self.pixels.iter().any(|pixel| pixel.max_element() > 0.0)
    }
}

/// Azimuth of a place between the centres of pixels, 0 being that of the first of so many columns.
fn azimuth(column: f64, columns: u32) -> f64 {
    TAU * (column + 0.5) / f64::from(columns) - PI
}
