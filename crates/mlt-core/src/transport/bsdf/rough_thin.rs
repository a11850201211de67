//! Thin transparent wall with a rough surface.

use super::albedo::cosine_average;
use super::facets::Facets;
use super::fresnel::reflect;
use super::metallic_roughness::INDEX_MATCHED;
use super::microfacet::{GRAZING, Ggx, Microfacets};
use super::thin::slab_reflectance;
use super::{Evaluation, RoughDielectric, choose};
use crate::transport::colour::Rgb;
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;

/// A reflection lobe of share R', and the same lobe mirrored through the surface of share (1 - R')·tint.
///
/// f_s = R'(h·l) D G₂/(4 cosθₗ cosθₑ) + R̄' m(θₗ) m(θₑ)/(π m̄), or the same with 1 - R' in place of R', times tint, with one
/// direction mirrored through the surface; R': `slab_reflectance`, R̄' its mean over the hemisphere, m: `Albedo`; η = 1 on
/// both sides. Untinted it absorbs nothing.
#[derive(Clone, Copy, Debug)]
pub struct RoughThin {
    /// Index of refraction of the wall over that of its surroundings, ≥ 1.
    pub ior: f32,
    /// Factor on what is transmitted, ∈ [0, 1].
    pub tint: Rgb,
    /// Microfacets.
    pub facets: Facets,
    /// R̄'.
    reflected: f32,
    /// 1/(π m̄), sr⁻¹.
    scale: f32,
}

/// `v` mirrored through the plane with unit normal `n`.
#[inline]
pub(super) fn through(n: Vec3A, v: Vec3A) -> Vec3A {
    v - 2.0 * n.dot(v) * n
}

impl RoughThin {
    /// A wall of this index and tint.
    pub fn new(ior: f32, tint: Rgb, ggx: Ggx) -> Self {
        Self::of(ior, tint, Facets::new(ggx), Self::mean_reflectance(ior))
    }

    /// The same of microfacets and a [`mean_reflectance`](Self::mean_reflectance) that are known already.
    pub fn of(ior: f32, tint: Rgb, facets: Facets, reflected: f32) -> Self {
        Self { ior, tint, facets, reflected, scale: FRAC_1_PI / facets.mean.white }
    }

    /// The interface of a solid of the same index and tint; `None`: it does not bend light.
    pub fn solid(&self) -> Option<RoughDielectric> {
        let bends = (self.ior - 1.0).abs() > INDEX_MATCHED;
        bends.then(|| RoughDielectric::new(self.ior, self.tint, self.facets.ggx))
    }

    /// R̄'.
    pub fn mean_reflectance(ior: f32) -> f32 {
        cosine_average(|cos| [slab_reflectance(cos, ior)])[0]
    }

    /// f_s, and (1 - m) R' or 1 - R' times D_v(h)/(4 h·given), and m R̄' or 1 - R̄' times q of `Spread`.
    ///
    /// Both directions are brought to the front; it is the one on the back that is moved, so that values and densities see the
    /// same rounding.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let is_reflected = n.dot(to_light) * n.dot(to_eye) > 0.0;
        let front = |v: Vec3A| if is_reflected || n.dot(v) > 0.0 { v } else { through(n, v) };
        let Some(single) = self.facets.ggx.reflection(n, front(to_light), front(to_eye)) else {
            return Evaluation::NOTHING;
        };
        let r = slab_reflectance(single.cos_half, self.ior);
        let (once, again, tint) = match is_reflected {
            true => (r, self.reflected, Rgb::ONE),
            false => (1.0 - r, 1.0 - self.reflected, self.tint),
        };
        let cos = [n.dot(to_light).abs(), n.dot(to_eye).abs()];
        let lacking = cos.map(|cos| self.facets.albedo.at(cos).white);
        let pdf = |given: usize, sampled: usize| {
            let multiple = lacking[given] * again * self.facets.spread.pdf(cos[sampled]);
            (1.0 - lacking[given]) * once * single.pdf[sampled] + multiple
        };
        let multiple = self.scale * lacking[0] * lacking[1];
        Evaluation {
            value: tint * (once * single.value + again * multiple),
            pdf_to_eye: pdf(0, 1),
            pdf_to_light: pdf(1, 0),
        }
    }

    /// Mirrors `given` about a visible normal, or draws from `Spread`; with probability 1 - R' or 1 - R̄' through the surface as well.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let h = self.facets.ggx.sample_normal(n, given, [u[0], u[1]])?;
        let side = n * 1f32.copysign(n.dot(given));
        let (multiple, rest) = choose(u[2], self.facets.albedo.at(side.dot(given)).white);
        let (r, reflected) = if multiple {
            (self.facets.spread.sample(side, [u[0], u[1]]), self.reflected)
        } else {
            (reflect(given, h), slab_reflectance(h.dot(given).min(1.0), self.ior))
        };
        let stays = side.dot(r) > GRAZING;
        stays.then(|| if rest < reflected { r } else { through(n, r) })
    }
}
