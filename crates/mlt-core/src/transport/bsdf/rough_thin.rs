//! Thin transparent wall with a rough surface.

use super::super::Rgb;
use super::fresnel::reflect;
use super::microfacet::{GRAZING, Ggx};
use super::thin::slab_reflectance;
use glam::Vec3A;

/// A reflection lobe of share R', and the same lobe mirrored through the surface of share (1 - R')·tint.
///
/// f_s = R'(h·l) D G₂/(4 cosθₗ cosθₑ), or (1 - R'(h·l)) tint D G₂/(4 cosθₗ cosθₑ) with one direction mirrored through
/// the surface; R': [`slab_reflectance`]; η = 1 on both sides.
#[derive(Clone, Debug)]
pub struct RoughThin {
    /// Index of refraction of the wall over that of its surroundings, ≥ 1.
    pub ior: f32,
    /// Factor on what is transmitted, ∈ [0, 1].
    pub tint: Rgb,
    /// Microfacets.
    pub ggx: Ggx,
}

/// `v` mirrored through the plane with unit normal `n`.
#[inline]
fn through(n: Vec3A, v: Vec3A) -> Vec3A {
    v - 2.0 * n.dot(v) * n
}

impl RoughThin {
    /// The event's share at the microfacet and D G₂/(4 cosθₐ cosθ_b), after bringing both directions to one side.
    ///
    /// It is the direction on the back that is moved, so that eval and pdf see the same rounding.
    #[inline]
    fn lobe(&self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<(f32, f32, Vec3A, Vec3A)> {
        let reflected = n.dot(a) * n.dot(b) > 0.0;
        let front = |v: Vec3A| if reflected || n.dot(v) > 0.0 { v } else { through(n, v) };
        let (a, b) = (front(a), front(b));
        let (cos_half, value) = self.ggx.reflection(n, a, b)?;
        let r = slab_reflectance(cos_half, self.ior);
        Some((if reflected { r } else { 1.0 - r }, value, a, b))
    }

    /// f_s.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        let Some((share, value, ..)) = self.lobe(n, to_light, to_eye) else { return Rgb::ZERO };
        let tint = if n.dot(to_light) * n.dot(to_eye) > 0.0 { Rgb::ONE } else { self.tint };
        tint * (share * value)
    }

    /// R' or 1 - R' times D_v(h)/(4 h·given).
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        let lobe = self.lobe(n, given, sampled);
        lobe.map_or(0.0, |(share, _, given, sampled)| share * self.ggx.reflection_pdf(n, given, sampled))
    }

    /// Mirrors `given` about a visible normal; with probability 1 - R' through the surface as well.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let h = self.ggx.sample_normal(n, given, [u[0], u[1]])?;
        let r = reflect(given, h);
        if n.dot(r) * 1f32.copysign(n.dot(given)) <= GRAZING {
            return None;
        }
        let reflected = u[2] < slab_reflectance(h.dot(given).min(1.0), self.ior);
        Some(if reflected { r } else { through(n, r) })
    }
}
