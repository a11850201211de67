//! Thin transparent wall: two parallel interfaces so close that light is not displaced.

use super::fresnel::{dielectric, reflect};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// Share that a wall reflects, over all reflections between its two faces.
///
/// R' = R + (1-R)² R Σₖ R²ᵏ = 2R/(1+R), and 1 - R' passes; R: [`dielectric`] of one face.
#[inline]
pub fn slab_reflectance(cos: f32, ior: f32) -> f32 {
    let r = dielectric(cos, ior);
    2.0 * r / (1.0 + r)
}

/// Reflects R' and passes (1 - R')·tint straight on; the same from both sides, η = 1 on both; delta.
///
/// Left out: the tint of light that is reflected inside the wall.
#[derive(Clone, Copy, Debug)]
pub struct Thin {
    /// Index of refraction of the wall over that of its surroundings, ≥ 1.
    pub ior: f32,
    /// Factor on what is transmitted, ∈ [0, 1].
    pub tint: Rgb,
}

impl Thin {
    /// P(event) of the event that joins two directions with these n·direction, symmetric in them.
    #[inline]
    fn probability(&self, a: f32, b: f32) -> f32 {
        let r = slab_reflectance(0.5 * (a.abs() + b.abs()), self.ior);
        if a * b > 0.0 {
            r
        } else if a * b < 0.0 {
            1.0 - r
        } else {
            0.0
        }
    }

    /// R' or (1 - R')·tint, coefficient of δ.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        let tint = if l * e < 0.0 { self.tint } else { Rgb::ONE };
        tint * self.probability(l, e)
    }

    /// R' for a reflection, 1 - R' for a transmission.
    #[inline]
    pub fn event_probability(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        self.probability(n.dot(given), n.dot(sampled))
    }

    /// P(event)·|cosθ(sampled)|, coefficient of δ.
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        self.event_probability(n, given, sampled) * n.dot(sampled).abs()
    }

    /// Reflects with probability R', else goes straight on.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        self.delta_direction(n, given, u[2] >= slab_reflectance(n.dot(given).abs(), self.ior))
    }

    /// The reflected or the opposite direction; `None`: `given` is tangent.
    #[inline]
    pub fn delta_direction(&self, n: Vec3A, given: Vec3A, transmit: bool) -> Option<Vec3A> {
        let g = n.dot(given);
        let d = if transmit { -given } else { reflect(given, n) };
        (if transmit { g != 0.0 } else { n.dot(d) * g > 0.0 }).then_some(d)
    }
}
