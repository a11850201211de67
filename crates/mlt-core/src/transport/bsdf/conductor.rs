//! Rough metal, and the coat of a glossy surface.

use super::Evaluation;
use super::facets::Facets;
use super::fresnel::{schlick, schlick_average};
use super::lacking::{Lacking, Tabulated};
use super::microfacet::{GRAZING, Ggx};
use crate::transport::colour::Rgb;
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;

/// f_s = F(h·l) D G₂/(4 cosθₗ cosθₑ) + F_m m(θₗ) m(θₑ)/(π m̄) on either side, F by Schlick from F₀ and F₉₀.
///
/// The second term is what microfacets reflect more than once: of m (`Albedo`) it is the share F_m = F̄² Ē/(1 - F̄ m̄), with
/// F̄ and Ē = 1 - m̄ means over the hemisphere. White (F = 1) absorbs nothing. Derivation: docs/theory-surfaces.md.
///
/// Source: Kulla & Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH course, 2017.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<D: Tabulated = Ggx> {
    /// F₀ ∈ [0, 1], reflectance at normal incidence.
    pub f0: Rgb,
    /// F₉₀ ∈ [0, 1], reflectance at grazing angles.
    pub f90: f32,
    /// Microfacets.
    pub facets: Facets<D>,
    /// The greatest channel of F̄.
    average: f32,
    /// F_m.
    multiple: Rgb,
    /// 1/(π m̄), sr⁻¹.
    scale: f32,
}

/// Both directions on one side.
pub(super) struct Met {
    /// f_s and densities.
    pub evaluation: Evaluation,
    /// Lacking energy at the direction to the light and to the eye.
    pub lacking: [Lacking; 2],
}

impl Conductor {
    /// Microfacets that reflect F₀ at normal incidence and F₉₀ at grazing angles.
    pub fn new(f0: Rgb, f90: f32, ggx: Ggx) -> Self {
        Self::of(f0, f90, Facets::new(ggx))
    }

    /// [`Self::albedo`] at a direction of this cosine.
    #[inline]
    pub(super) fn albedo_at(&self, cos: f32) -> Rgb {
        self.albedo(self.facets.albedo.at(cos))
    }
}

impl<D: Tabulated> Conductor<D> {
    /// The same of microfacets that are known already.
    pub fn of(f0: Rgb, f90: f32, facets: Facets<D>) -> Self {
        let lacking = facets.mean.white;
        let f = schlick_average(f0, f90);
        Self {
            f0,
            f90,
            facets,
            average: f.max_element(),
            multiple: f * f * (1.0 - lacking) / (Rgb::ONE - f * lacking),
            scale: FRAC_1_PI / lacking,
        }
    }

    /// ∫ f_s cosθ dω of a direction where this is lacking, or the mean over the hemisphere of the mean of that.
    #[inline]
    pub(super) fn albedo(&self, lacking: Lacking) -> Rgb {
        let grazing = lacking.grazing;
        self.f0 * (1.0 - lacking.white - grazing) + self.f90 * grazing + self.multiple * lacking.white
    }

    /// Mean over the hemisphere of [`Self::albedo`], weighted by cosθ.
    pub(super) fn mean_albedo(&self) -> Rgb {
        self.albedo(self.facets.mean)
    }

    /// Light reflected once and again, if F were F̄ everywhere, over F̄: sampled in this proportion.
    #[inline]
    fn shares(&self, white: f32) -> [f32; 2] {
        [1.0 - white, self.average * white]
    }

    /// `None`: not on one side.
    #[inline]
    pub(super) fn meet(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Option<Met> {
        let single = self.facets.ggx.reflection(n, to_light, to_eye)?;
        let cos = [n.dot(to_light).abs(), n.dot(to_eye).abs()];
        let lacking = [to_light, to_eye].map(|v| self.facets.lacking(n, v));
        let multiple = self.scale * lacking[0].white * lacking[1].white;
        let pdf = |given: usize, sampled: usize| {
            let [once, again] = self.shares(lacking[given].white);
            (once * single.pdf[sampled] + again * self.facets.spread.pdf(cos[sampled])) / (once + again)
        };
        let evaluation = Evaluation {
            value: schlick(self.f0, self.f90, single.cos_half) * single.value + self.multiple * multiple,
            pdf_to_eye: pdf(0, 1),
            pdf_to_light: pdf(1, 0),
        };
        Some(Met { evaluation, lacking })
    }

    /// f_s, and (1 - p) D_v(h)/(4 h·given) + p q with p = F̄ m/(1 - m + F̄ m) and q of `Spread`.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        self.meet(n, to_light, to_eye).map_or(Evaluation::NOTHING, |met| met.evaluation)
    }

    /// Mirrors `given` about a visible normal, or draws from `Spread`.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let cos = n.dot(given);
        let [once, again] = self.shares(self.facets.lacking(n, given).white);
        if cos.abs() > GRAZING && u[2] * (once + again) < again {
            Some(self.facets.spread.sample(n * 1f32.copysign(cos), [u[0], u[1]]))
        } else {
            self.facets.ggx.sample_reflection(n, given, [u[0], u[1]])
        }
    }
}
