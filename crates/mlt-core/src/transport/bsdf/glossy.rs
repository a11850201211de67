//! Dielectric coat over a diffuse base.

use super::lacking::Tabulated;
use super::microfacet::Ggx;
use super::{Conductor, Evaluation, Lambert, choose};
use crate::transport::colour::Rgb;
use glam::{Vec2, Vec3A};
use std::f32::consts::FRAC_1_PI;

/// f_s = f_coat + ρ t(θₗ) t(θₑ)/(π t̄), t = 1 - A(θ), on either side, A(θ) = ∫ f_coat cosθ dω and t̄ = ∫₀¹ t 2μ dμ, channel by channel.
///
/// Reciprocal, and ∫ f_s cosθ dω = A + ρ t, which is 1 for ρ = 1 at every angle. Derivation: docs/theory-surfaces.md.
///
/// Source: Kelemen & Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling",
/// Eurographics 2001. Left out: light that the coat sends back to the base takes the base's colour no more than once.
#[derive(Clone, Copy, Debug)]
pub struct Glossy<D: Tabulated = Ggx> {
    /// The base's ρ.
    pub base: Lambert,
    /// F₀, F₉₀ and microfacets of the coat.
    pub coat: Conductor<D>,
    /// ρ/(π t̄), sr⁻¹.
    scale: Rgb,
}

impl<D: Tabulated> Glossy<D> {
    /// A coat over a base.
    pub fn new(base: Lambert, coat: Conductor<D>) -> Self {
        // Where the coat lets nothing through, t̄ is a rounding error.
        let through = (Rgb::ONE - coat.mean_albedo()).max(Rgb::splat(1e-6));
        let scale = base.reflectance * FRAC_1_PI / through;
        Self { base, coat, scale }
    }

    /// t, from A.
    #[inline]
    fn through(albedo: Rgb) -> Rgb {
        (Rgb::ONE - albedo).max(Rgb::ZERO)
    }

    /// Probability of sampling the coat: its share of the energy.
    #[inline]
    fn coat_probability(&self, albedo: Rgb) -> f32 {
        let base = (self.base.reflectance * Self::through(albedo)).max_element();
        let coat = albedo.max_element();
        if base > 0.0 { coat / (coat + base) } else { 1.0 }
    }

    /// f_s, and the mixture of the coat's and the base's densities.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let Some(met) = self.coat.meet(n, to_light, to_eye) else { return Evaluation::NOTHING };
        let [light, eye] = met.lacking.map(|lacking| self.coat.albedo(lacking));
        let base = self.base.evaluate(n, to_light, to_eye);
        let pdf = |p: f32, coat: f32, base: f32| p * coat + (1.0 - p) * base;
        let coat = met.evaluation;
        Evaluation {
            value: coat.value + self.scale * Self::through(light) * Self::through(eye),
            pdf_to_eye: pdf(self.coat_probability(light), coat.pdf_to_eye, base.pdf_to_eye),
            pdf_to_light: pdf(self.coat_probability(eye), coat.pdf_to_light, base.pdf_to_light),
        }
    }

    /// Samples the coat or the base.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let p = self.coat_probability(self.coat.albedo(self.coat.facets.lacking(n, given)));
        match choose(u[2], p) {
            (true, rest) => self.coat.sample(n, given, [u[0], u[1], rest]),
            (false, _) => Some(self.base.sample(n, given, Vec2::new(u[0], u[1]))),
        }
    }
}
