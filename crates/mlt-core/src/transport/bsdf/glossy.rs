//! Dielectric coat over a diffuse base.

use super::super::Rgb;
use super::fresnel::schlick;
use super::{Conductor, Lambert};
use glam::{Vec2, Vec3A};

/// f_s = (1 - max F) ρ/π + F D G₂/(4 cosθₗ cosθₑ),  F = F₀ + (F₉₀ - F₀)(1 - h·l)⁵, on either side.
///
/// Source: glTF 2.0, appendix B.3, KHR_materials_specular. As there, base and coat together may reflect more than they get at
/// grazing angles; averaged over the hemisphere they do not, for ρ up to 0.95.
#[derive(Clone, Debug)]
pub struct Glossy {
    /// The base's ρ.
    pub base: Lambert,
    /// F₀ and microfacets of the coat.
    pub coat: Conductor,
    /// F₉₀ ∈ [0, 1], the coat's reflectance at grazing angles.
    pub f90: f32,
}

impl Glossy {
    /// f_s where both directions are on one side.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        let Some((cos_h, value)) = self.coat.ggx.reflection(n, to_light, to_eye) else { return Rgb::ZERO };
        let f = schlick(self.coat.f0, self.f90, cos_h);
        self.base.eval(n, to_light, to_eye) * (1.0 - f.max_element()) + f * value
    }

    /// Probability of sampling the coat: about its share of the energy.
    ///
    /// The base's part, (1 - max F₀)ρ, must not vanish at grazing angles: there h·l, and so the base, is far from its limit.
    #[inline]
    fn coat_probability(&self, n: Vec3A, given: Vec3A) -> f32 {
        let coat = schlick(self.coat.f0, self.f90, n.dot(given).abs()).max_element();
        let base = (1.0 - self.coat.f0.max_element()) * self.base.reflectance.max_element();
        if base > 0.0 { coat / (coat + base) } else { 1.0 }
    }

    /// The mixture of the coat's and the base's densities.
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        let p = self.coat_probability(n, given);
        p * self.coat.pdf(n, given, sampled) + (1.0 - p) * self.base.pdf(n, given, sampled)
    }

    /// Samples the coat or the base.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        if u[2] < self.coat_probability(n, given) {
            self.coat.sample(n, given, u)
        } else {
            Some(self.base.sample(n, given, Vec2::new(u[0], u[1])))
        }
    }
}
