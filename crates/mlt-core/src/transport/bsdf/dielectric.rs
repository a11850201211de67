//! Smooth interface between two transparent media.

use super::fresnel::{dielectric, reflect, refract};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// Reflects F and refracts 1 - F, with the exact Fresnel term; delta.
///
/// The medium is on the back of n, vacuum on its front. Left out: absorption and dispersion inside the medium.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric {
    /// Index of refraction of the medium over that of its surroundings, > 0.
    pub ior: f32,
    /// Factor on what is transmitted, ∈ [0, 1], at each crossing.
    pub tint: Rgb,
}

impl Dielectric {
    /// Index on the side where n·direction has this sign.
    #[inline]
    fn eta(&self, cos: f32) -> f32 {
        if cos > 0.0 { 1.0 } else { self.ior }
    }

    /// P(event) of the event that joins two directions with these n·direction, symmetric in them.
    ///
    /// F is found on the rarer side for a refraction, where no total reflection can turn up by rounding.
    #[inline]
    fn probability(&self, a: f32, b: f32) -> f32 {
        if a * b > 0.0 {
            dielectric(0.5 * (a + b).abs(), self.eta(-a) / self.eta(a))
        } else if a * b < 0.0 {
            let rare = if (self.ior >= 1.0) == (a > 0.0) { a } else { b };
            1.0 - dielectric(rare.abs(), self.ior.max(1.0 / self.ior))
        } else {
            0.0
        }
    }

    /// F·η²(eye side) or (1 - F)·tint·η²(eye side), coefficient of δ.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        let eta = self.eta(e);
        let tint = if l * e < 0.0 { self.tint } else { Rgb::ONE };
        tint * (self.probability(l, e) * eta * eta)
    }

    /// F for a reflection, 1 - F for a refraction.
    #[inline]
    pub fn event_probability(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        self.probability(n.dot(given), n.dot(sampled))
    }

    /// P(event)·η²(sampled side)·|cosθ(sampled)|, coefficient of δ.
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        let (g, s) = (n.dot(given), n.dot(sampled));
        let eta = self.eta(s);
        self.probability(g, s) * eta * eta * s.abs()
    }

    /// Reflects with probability F, else refracts.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let g = n.dot(given);
        let f = dielectric(g.abs(), self.eta(-g) / self.eta(g));
        self.delta_direction(n, given, u[2] >= f)
    }

    /// The reflected or the refracted direction; `None`: total reflection, or `given` is tangent.
    #[inline]
    pub fn delta_direction(&self, n: Vec3A, given: Vec3A, transmit: bool) -> Option<Vec3A> {
        let g = n.dot(given);
        if !transmit {
            let r = reflect(given, n);
            return (n.dot(r) * g > 0.0).then_some(r);
        }
        let t = refract(given, n * 1f32.copysign(g), self.eta(-g) / self.eta(g))?;
        (n.dot(t) * g < 0.0).then_some(t)
    }
}
