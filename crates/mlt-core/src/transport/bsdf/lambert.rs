//! Ideal diffuse reflection.

use super::Evaluation;
use crate::transport::colour::Rgb;
use crate::transport::geometry::math::cosine_hemisphere;
use glam::{Vec2, Vec3A};
use std::f32::consts::FRAC_1_PI;

/// f_s = ρ/π on either side of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    /// ρ ∈ [0, 1], reflected share of energy.
    pub reflectance: Rgb,
}

impl Lambert {
    /// ρ/π where both directions are on one side.
    #[inline(always)]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        if n.dot(to_light) * n.dot(to_eye) > 0.0 { self.reflectance * FRAC_1_PI } else { Rgb::ZERO }
    }

    /// |cosθ|/π where both directions are on one side.
    #[inline(always)]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        let cos = n.dot(sampled);
        if n.dot(given) * cos > 0.0 { cos.abs() * FRAC_1_PI } else { 0.0 }
    }

    /// Both, and the density of the way back.
    #[inline(always)]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let (cos_light, cos_eye) = (n.dot(to_light), n.dot(to_eye));
        let scale = if cos_light * cos_eye > 0.0 { FRAC_1_PI } else { 0.0 };
        Evaluation {
            value: self.reflectance * scale,
            pdf_to_eye: cos_eye.abs() * scale,
            pdf_to_light: cos_light.abs() * scale,
        }
    }

    /// Cosine-weighted on the side of `given`.
    #[inline(always)]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: Vec2) -> Vec3A {
        cosine_hemisphere(n * 1f32.copysign(n.dot(given)), u)
    }
}
