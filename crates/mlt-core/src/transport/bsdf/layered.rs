//! A clear coat and fibres over a surface.

use super::microfacet::GRAZING;
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
    /// Its unit normal; `None`: that of the base.
    pub normal: Option<Vec3A>,
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
    /// cosθ to its own normal, on the side where a direction is of the base's normal `n`: negative where only the base is seen from there.
    #[inline]
    fn cos(&self, n: Vec3A, v: Vec3A) -> f32 {
        self.normal.unwrap_or(n).dot(v) * 1f32.copysign(n.dot(v))
    }

    /// A(θ).
    #[inline]
    fn albedo(&self, n: Vec3A, v: Vec3A) -> f32 {
        let cos = self.cos(n, v);
        if cos < 0.0 { 0.0 } else { (self.share * self.lobe.albedo_at(cos).max_element()).clamp(0.0, 1.0) }
    }

    /// f_s |ω·n_c|/|ω·n|, ω = to_light and n_c its own normal, on its share.
    #[inline]
    fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let Some(own) = self.normal else {
            let found = self.lobe.evaluate(n, to_light, to_eye);
            return Evaluation { value: found.value * Rgb::splat(self.share), ..found };
        };
        let cos = self.cos(n, to_light);
        if cos.min(self.cos(n, to_eye)) <= 0.0 {
            return Evaluation::NOTHING;
        }
        let found = self.lobe.evaluate(own, to_light, to_eye);
        Evaluation { value: found.value * (self.share * cos / n.dot(to_light).abs().max(GRAZING)), ..found }
    }

    #[inline]
    fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let sampled = self.lobe.sample(self.normal.unwrap_or(n), given, u)?;
        (n.dot(sampled) * n.dot(given) > 0.0).then_some(sampled)
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
            let top = coat.evaluate(n, to_light, to_eye);
            found = over(top, found, [to_light, to_eye].map(|v| coat.albedo(n, v)));
        }
        found
    }

    /// Samples one of the layers.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let cos = n.dot(given).abs();
        let mut rest = u[2];
        if let Some(coat) = &self.coat {
            let (taken, unused) = choose(rest, probability(coat.albedo(n, given)));
            if taken {
                return coat.sample(n, given, [u[0], u[1], unused]);
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
