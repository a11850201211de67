//! Suns: distant lights that are seen as a disc of directions, each of the same radiance.

use super::{Light, Piece, Shape};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Sphere;
use crate::transport::geometry::math::{frame, turn, unit};
use glam::{DVec2, Vec3, Vec3A};
use std::f32::consts::PI as PI_F32;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Narrowest disc, half its angle, radians: f32 tells its directions apart to 10⁻⁴ of that.
const NARROWEST: f64 = 5e-4;

/// The directions within α of an axis.
///
/// The unit square is mapped onto them by u = sin²(θ/2)/sin²(α/2), θ being the angle with the axis, and the turn v about it: solid angle
/// is dω = 2 d(sin²(θ/2)) dφ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sun {
    /// Unit vector to its middle.
    towards: Vec3A,
    /// sin²(α/2).
    half_sine_squared: f64,
    /// Around the scene.
    pub(super) sphere: Sphere,
}

impl Sun {
    /// Half of the angle that it is seen at, no more than a right one; `None` where it is too narrow to be told from one direction.
    pub(super) fn half_angle(angle: f32) -> Option<f64> {
        Some(0.5 * f64::from(angle)).filter(|&half| half >= NARROWEST).map(|half| half.min(FRAC_PI_2))
    }

    /// The light of a disc of half the angle `half` that sends the irradiance E across the direction of its middle, E = ∫ L cosθ dω =
    /// π L sin²α.
    pub(super) fn light(towards: Vec3A, half: f64, irradiance: Rgb, sphere: Sphere) -> Light {
        let half_sine_squared = libm::sin(0.5 * half).powi(2);
        let emission = irradiance * (1.0 / (PI * libm::sin(half).powi(2))) as f32;
        let shape = Shape::Sun(Self { towards, half_sine_squared, sphere });
        Light::new(shape, 2.0 * TAU * half_sine_squared, emission)
    }

    /// The unit direction towards a point of the unit square.
    pub(super) fn direction(&self, u: f64, v: f64) -> Vec3A {
        let square = u * self.half_sine_squared;
        let sin = (2.0 * (square * (1.0 - square)).sqrt()) as f32;
        let (s, t) = frame(self.towards);
        let about = turn(v as f32);
        unit(sin * (about.x * s + about.y * t) + (1.0 - 2.0 * square) as f32 * self.towards)
    }

    /// The point of the unit square that a direction comes from.
    pub(super) fn coordinates(&self, direction: Vec3) -> (f64, f64) {
        let direction = Vec3A::from(direction);
        let (s, t) = frame(self.towards);
        let v = libm::atan2f(direction.dot(t), direction.dot(s)) / (2.0 * PI_F32);
        (self.square(direction).min(1.0), f64::from(v - v.floor()))
    }

    /// A part of the unit square, with the mean of the whole disc: its height is (1 + cosα)/2.
    pub(super) fn piece(&self, square: [DVec2; 2]) -> Piece {
        Piece::of_directions(square, ((1.0 - self.half_sine_squared) as f32 * self.towards).into())
    }

    /// Whether a unit direction is one of its own.
    pub(super) fn holds(&self, direction: Vec3A) -> bool {
        self.square(direction) <= 1.0
    }

    /// u. From the chord, whose length is 2 sin(θ/2), nothing cancels.
    fn square(&self, direction: Vec3A) -> f64 {
        0.25 * f64::from(direction.distance_squared(self.towards)) / self.half_sine_squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform};

    const SPHERE: Sphere = Sphere { centre: Vec3A::ZERO, radius: 2.0 };

    fn sun(half: f64) -> (Light, Sun) {
        let light = Sun::light(Vec3A::new(0.48, 0.6, 0.64), half, Rgb::splat(3.0), SPHERE);
        let Shape::Sun(sun) = light.shape else { panic!("a sun") };
        (light, sun)
    }

    #[test]
    fn a_direction_leads_back_to_its_point_of_the_square() {
        let mut rng = generator(1, Purpose::Sample, 0, 0, 0);
        for half in [NARROWEST, 4.6e-3, 0.1, 1.0, FRAC_PI_2] {
            let (sun, mut outside) = (sun(half).1, 0);
            for _ in 0..2000 {
                let (u, v) = (uniform(&mut rng), uniform(&mut rng));
                let direction = sun.direction(u, v);
                let (x, y) = sun.coordinates(direction.into());
                let off = (y - v).abs().min(1.0 - (y - v).abs());
                assert!((x - u).abs() < 1e-3 && off < 1e-3 + 1e-4 / u.sqrt(), "{half}: {u}, {v} and {x}, {y}");
                outside += u32::from(!sun.holds(direction));
            }
            assert!(outside <= 2, "{half}: {outside} directions of its own are not");
        }
    }

    /// ∫ L cosθ dω over its directions is E, and ∫ dω its measure, by points of the square; sinα in place of its square is not.
    #[test]
    fn irradiance_is_that_of_the_file() {
        for half in [0.01, 0.3, 1.2, FRAC_PI_2] {
            let (light, sun) = sun(half);
            let n = 1000;
            let cosines =
                (0..n).map(|i| f64::from(sun.direction((f64::from(i) + 0.5) / f64::from(n), 0.3).dot(sun.towards)));
            let irradiance = |radiance: f64| radiance * light.measure * cosines.clone().sum::<f64>() / f64::from(n);
            let found = irradiance(f64::from(light.emission.x));
            assert!((found - 3.0).abs() < 1e-3, "{half}: {found}");
            let wrong = irradiance(3.0 / (PI * libm::sin(half)));
            assert!((wrong - 3.0).abs() > 0.1 || half > 1.5, "{half}: {wrong}");
            assert!((light.measure - TAU * (1.0 - half.cos())).abs() < 1e-9);
        }
    }
}
