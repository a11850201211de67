//! Perfect mirror.

use super::fresnel::{reflect, schlick};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// Reflects F = F₀ + (1 - F₀)(1 - cosθ)⁵ into the mirrored direction, on either side; delta.
///
/// A smooth metal of glTF. Left out: the phase and the exact Fresnel term of a complex index.
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    /// F₀ ∈ [0, 1], reflectance at normal incidence.
    pub f0: Rgb,
}

impl Mirror {
    /// F where both directions are on one side, coefficient of δ.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        if l * e > 0.0 { schlick(self.f0, 1.0, 0.5 * (l + e).abs()) } else { Rgb::ZERO }
    }

    /// 1 where both directions are on one side.
    #[inline]
    pub fn event_probability(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        if n.dot(given) * n.dot(sampled) > 0.0 { 1.0 } else { 0.0 }
    }

    /// |cosθ(sampled)| where both directions are on one side, coefficient of δ.
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        self.event_probability(n, given, sampled) * n.dot(sampled).abs()
    }

    /// The mirrored direction; a mirror transmits nothing.
    #[inline]
    pub fn delta_direction(&self, n: Vec3A, given: Vec3A, transmit: bool) -> Option<Vec3A> {
        let r = reflect(given, n);
        (!transmit && n.dot(r) * n.dot(given) > 0.0).then_some(r)
    }
}
