//! Rough interface between two transparent media.

use super::super::Rgb;
use super::fresnel::{dielectric, reflect, refract};
use super::microfacet::{GRAZING, Ggx};
use glam::Vec3A;

/// GGX microfacets that reflect F and refract 1 - F of what they meet.
///
/// * reflection: f_s = F D G₂/(4 cosθₗ cosθₑ)
/// * refraction: f_s = |h·l||h·e| (1 - F) tint D G₁(l) G₁(e) ηₑ²/(cosθₗ cosθₑ |ηₗ l + ηₑ e|²)
///
/// The medium is on the back of n, vacuum on its front; η² of the eye's side scales radiance.
///
/// Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, eqs. 20 and 21. Left out:
/// heights correlated across the surface.
#[derive(Clone, Debug)]
pub struct RoughDielectric {
    /// Index of refraction of the medium over that of its surroundings, > 0; |ior - 1| > 10⁻³.
    pub ior: f32,
    /// Factor on what is transmitted, ∈ [0, 1], at each crossing.
    pub tint: Rgb,
    /// Microfacets.
    pub ggx: Ggx,
}

/// The microfacet that refracts one direction into the other.
struct Refraction {
    /// |h·a| and |h·b|.
    cos: [f32; 2],
    /// (1 - F) D(h)/|ηₐ a + η_b b|², sr⁻¹.
    value: f32,
}

impl RoughDielectric {
    /// Index on the side where n·direction has this sign.
    #[inline]
    fn eta(&self, cos: f32) -> f32 {
        if cos > 0.0 { 1.0 } else { self.ior }
    }

    /// F where microfacet and direction, on the side of `cos`, enclose the angle with cosine `cos_h`.
    #[inline]
    fn fresnel(&self, cos: f32, cos_h: f32) -> f32 {
        dielectric(cos_h.min(1.0), self.eta(-cos) / self.eta(cos))
    }

    /// `None`: not on two sides, tangent, or joined by no visible microfacet. Symmetric in `a` and `b`.
    #[inline]
    fn refraction(&self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Refraction> {
        let (ca, cb) = (n.dot(a), n.dot(b));
        let two_sides = ca.min(cb) < -GRAZING && ca.max(cb) > GRAZING;
        if !two_sides {
            return None;
        }
        let sum = self.eta(ca) * a + self.eta(cb) * b;
        let length2 = sum.length_squared();
        let h = sum.try_normalize()?;
        let h = h * 1f32.copysign(n.dot(h));
        let (ha, hb) = (h.dot(a), h.dot(b));
        if ha * ca <= 0.0 || hb * cb <= 0.0 {
            return None;
        }
        // F on the rarer side, where no total reflection can turn up by rounding.
        let rare = if (self.ior >= 1.0) == (ca > 0.0) { ha } else { hb };
        let f = dielectric(rare.abs().min(1.0), self.ior.max(1.0 / self.ior));
        Some(Refraction { cos: [ha.abs(), hb.abs()], value: (1.0 - f) * self.ggx.d(n, h) / length2 })
    }

    /// f_s, radiance scaling by ηₑ²/ηₗ² included.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        if let Some((cos_h, value)) = self.ggx.reflection(n, to_light, to_eye) {
            return Rgb::splat(self.fresnel(n.dot(to_eye), cos_h) * value);
        }
        let Some(r) = self.refraction(n, to_light, to_eye) else { return Rgb::ZERO };
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        let eta = self.eta(e);
        let shadowing = self.ggx.g1_over_cos(l.abs()) * self.ggx.g1_over_cos(e.abs());
        self.tint * (r.cos[0] * r.cos[1] * eta * eta * shadowing * r.value)
    }

    /// F D_v(h)/(4 h·given), or (1 - F) D_v(h) ηₛ²|h·sampled|/|η_g given + ηₛ sampled|².
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        let g = n.dot(given);
        if let Some((cos_h, _)) = self.ggx.reflection(n, given, sampled) {
            return self.fresnel(g, cos_h) * self.ggx.reflection_pdf(n, given, sampled);
        }
        let Some(r) = self.refraction(n, given, sampled) else { return 0.0 };
        let eta = self.eta(n.dot(sampled));
        r.cos[0] * r.cos[1] * eta * eta * self.ggx.g1_over_cos(g.abs()) * r.value
    }

    /// Reflects about a visible normal with probability F, else refracts; `None`: it would end on the wrong side.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let h = self.ggx.sample_normal(n, given, [u[0], u[1]])?;
        let g = n.dot(given);
        let side = 1f32.copysign(g);
        if u[2] < self.fresnel(g, h.dot(given)) {
            let r = reflect(given, h);
            (n.dot(r) * side > GRAZING).then_some(r)
        } else {
            let t = refract(given, h, self.eta(-g) / self.eta(g))?;
            (n.dot(t) * side < -GRAZING).then_some(t)
        }
    }
}
