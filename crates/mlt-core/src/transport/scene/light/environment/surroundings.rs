//! An environment around a scene.

use super::distribution::{Distribution, Place};
use super::{Environment, azimuth};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Sphere;
use crate::transport::geometry::math::{acos, atan2, turn, unit};
use crate::transport::scene::light::{Light, Piece, Shape};
use glam::{DVec2, DVec3, Vec3, Vec3A};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Rows and columns of samples of a piece, for the mean of its directions.
const SAMPLES: u32 = 16;

/// An environment with the sphere that it sends light into.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    size: [u32; 2],
    distribution: Distribution,
    /// By which it is turned, as a share of a turn.
    rotation: f64,
    /// The sphere around the scene.
    sphere: Sphere,
}

impl Surroundings {
    /// The light of an environment around a scene.
    pub(in crate::transport::scene) fn light(environment: Environment, sphere: Sphere) -> Light {
        let Environment { size, mut pixels, rotation, strength, .. } = environment;
        pixels.iter_mut().for_each(|pixel| *pixel = (*pixel * strength).min(Rgb::MAX));
        let distribution = Distribution::new(size.map(|n| n as usize), &pixels);
        let rows: Vec<DVec3> =
            pixels.chunks_exact(size[0] as usize).map(|row| row.iter().map(|p| p.as_dvec3()).sum()).collect();
        let mean = [0, 1, 2].map(|channel| (distribution.integral(|row| rows[row][channel]) / (4.0 * PI)) as f32);
        let around = Self { size, distribution, rotation: rotation / TAU, sphere };
        let shape = Shape::Environment(Box::new(around));
        Light::new(shape, 4.0 * PI, mean.into())
    }

    /// Around the scene.
    pub(crate) fn sphere(&self) -> &Sphere {
        &self.sphere
    }

    /// Largest radiance of a pixel, channel by channel.
    pub(crate) fn brightest(&self) -> Rgb {
        self.distribution.brightest()
    }

    /// The unit direction towards a point of the unit square.
    pub(crate) fn direction(&self, u: f64, v: f64) -> Vec3A {
        let (column, z) = match self.distribution.even() {
            // As of one pixel, without a search.
            Some(_) => (v, 1.0 - 2.0 * u),
            None => self.distribution.column_and_height(u, v),
        };
        let azimuth = azimuth(column, self.size[0]) * TAU.recip() - self.rotation;
        let around = turn(fraction(azimuth) as f32);
        let radius = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt() as f32;
        unit(Vec3A::new(radius * around.x, z as f32, radius * around.y))
    }

    /// The part between two corners of the unit square: its directions have density by power there.
    pub(in crate::transport::scene::light) fn piece(&self, [low, high]: [DVec2; 2]) -> Piece {
        let places = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| DVec2::new(i.into(), j.into())));
        let at = |place: DVec2| low + (high - low) * (place + 0.5) / f64::from(SAMPLES);
        let directions = places.map(at).map(|at| self.direction(at.x, at.y));
        let mean = directions.sum::<Vec3A>() / (SAMPLES * SAMPLES) as f32;
        Piece::of_directions([low, high], mean.into())
    }

    /// The point of the unit square that a direction comes from.
    pub(crate) fn coordinates(&self, direction: Vec3) -> (f64, f64) {
        self.distribution.coordinates(&self.place(direction)).into()
    }

    /// Radiance from a unit direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> Rgb {
        self.distribution.even().unwrap_or_else(|| self.distribution.radiance(&self.place(direction)))
    }

    fn place(&self, direction: Vec3) -> Place {
        let polar = f64::from(acos(direction.y)) * FRAC_1_PI;
        let columns = f64::from(self.size[0]);
        let from_first = f64::from(atan2(direction.z, direction.x)) * TAU.recip() + 0.5 + self.rotation - 0.5 / columns;
        self.distribution.place(f64::from(direction.y), polar, fraction(from_first))
    }
}

/// x − ⌊x⌋, of numbers of few turns.
#[inline]
fn fraction(x: f64) -> f64 {
    let rest = x - f64::from(x as i32);
    if rest < 0.0 { rest + 1.0 } else { rest }
}
