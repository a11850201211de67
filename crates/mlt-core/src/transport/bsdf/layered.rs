//! A clear coat and fibres over a surface.

use super::sheen::Sheen;
use super::{Conductor, Evaluation, Mix, choose};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// A coat that covers a share of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// Its reflection.
    pub lobe: Conductor,
    /// The share.
    pub share: f32,
}

/// f_s = f_top + min(t(θₗ), t(θₑ)) f_below, t = 1 − A(θ), A the greatest channel of ∫ f_top cosθ dω; a coat on top, fibres below it and
/// the base below those.
///
/// Reciprocal, and no more than A + t = 1 leaves. Derivation: docs/theory-surfaces.md. Left out: what the upper layers send back to those
/// below.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// On top.
    pub coat: Option<Coat>,
    /// Below the coat.
    pub sheen: Option<Sheen>,
    /// Below both.
    pub base: Mix,
}

impl Coat {
    /// A(θ).
    #[inline]
    fn albedo(&self, cos: f32) -> f32 {
        (self.share * self.lobe.albedo_at(cos).max_element()).clamp(0.0, 1.0)
    }
}

/// Probability of sampling an upper layer: more than its share, since its highlights are what is seen.
#[inline]
fn probability(albedo: f32) -> f32 {
    albedo.sqrt()
}

/// An upper layer over what lies below it; `albedo`: A of the directions to the light and to the eye.
#[inline]
fn over(top: Evaluation, below: Evaluation, albedo: [f32; 2]) -> Evaluation {
    let through = 1.0 - albedo[0].max(albedo[1]);
    let pdf = |given: f32, top: f32, below: f32| {
        let p = probability(given);
        p * top + (1.0 - p) * below
    };
    Evaluation {
        value: top.value + through * below.value,
        pdf_to_eye: pdf(albedo[0], top.pdf_to_eye, below.pdf_to_eye),
        pdf_to_light: pdf(albedo[1], top.pdf_to_light, below.pdf_to_light),
    }
}

impl Layered {
    /// f_s, and the mixture of the layers' densities.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let cos = [to_light, to_eye].map(|v| n.dot(v).abs());
        let mut found = self.base.evaluate(n, to_light, to_eye);
        if let Some(sheen) = &self.sheen {
            found = over(sheen.evaluate(n, to_light, to_eye), found, cos.map(|cos| sheen.albedo(cos)));
        }
        if let Some(coat) = &self.coat {
            let mut top = coat.lobe.evaluate(n, to_light, to_eye);
            top.value *= Rgb::splat(coat.share);
            found = over(top, found, cos.map(|cos| coat.albedo(cos)));
        }
        found
    }

    /// Samples one of the layers.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let cos = n.dot(given).abs();
        let mut rest = u[2];
        if let Some(coat) = &self.coat {
            let (taken, unused) = choose(rest, probability(coat.albedo(cos)));
            if taken {
                return coat.lobe.sample(n, given, [u[0], u[1], unused]);
            }
            rest = unused;
        }
        if let Some(sheen) = &self.sheen {
            let (taken, unused) = choose(rest, probability(sheen.albedo(cos)));
            if taken {
                return Some(sheen.sample(n, given, [u[0], u[1], unused]));
            }
            rest = unused;
        }
        self.base.sample(n, given, [u[0], u[1], rest])
    }
}
