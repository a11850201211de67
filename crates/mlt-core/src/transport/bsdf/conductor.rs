//! Rough metal.

use super::super::Rgb;
use super::fresnel::schlick;
use super::microfacet::Ggx;
use glam::Vec3A;

/// f_s = F(h·l) D G₂/(4 cosθₗ cosθₑ) on either side, F by Schlick from F₀: glTF's metal.
#[derive(Clone, Debug)]
pub struct Conductor {
    /// F₀ ∈ [0, 1], reflectance at normal incidence.
    pub f0: Rgb,
    /// Microfacets.
    pub ggx: Ggx,
}

impl Conductor {
    /// f_s where both directions are on one side.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        let lobe = self.ggx.reflection(n, to_light, to_eye);
        lobe.map_or(Rgb::ZERO, |(cos, value)| schlick(self.f0, 1.0, cos) * value)
    }

    /// D_v(h)/(4 h·given).
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        self.ggx.reflection_pdf(n, given, sampled)
    }

    /// Mirrors `given` about a visible normal.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        self.ggx.sample_reflection(n, given, [u[0], u[1]])
    }
}
