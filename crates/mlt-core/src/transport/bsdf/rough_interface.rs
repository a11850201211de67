//! Rough interface between two transparent media, met once.

use super::Evaluation;
use super::albedo::visible_average;
use super::fresnel::{dielectric, reflect, refract};
use super::microfacet::{GRAZING, Ggx, Microfacets};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// GGX microfacets that reflect F and refract 1 - F of what they meet.
///
/// * reflection: f_s = F D G₂/(4 cosθₗ cosθₑ)
/// * refraction: f_s = |h·l||h·e| (1 - F) tint D G₁(l) G₁(e) ηₑ²/(cosθₗ cosθₑ |ηₗ l + ηₑ e|²)
///
/// The medium is on the back of n, vacuum on its front; η² of the eye's side scales radiance.
///
/// Source: [Walter07], equations 20 and 21. Left out: heights correlated across the surface.
#[derive(Clone, Copy, Debug)]
pub struct RoughInterface {
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

impl RoughInterface {
    /// Index on the side where n·direction has this sign.
    #[inline]
    pub fn eta(&self, cos: f32) -> f32 {
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

    /// f_s, radiance scaling by ηₑ²/ηₗ² included; densities F D_v(h)/(4 h·given), or (1 - F) D_v(h) ηₛ²|h·sampled|/|η_g given + ηₛ sampled|².
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        if let Some(met) = self.ggx.reflection(n, to_light, to_eye) {
            let f = self.fresnel(e, met.cos_half);
            let [pdf_to_light, pdf_to_eye] = met.pdf.map(|pdf| f * pdf);
            return Evaluation { value: Rgb::splat(f * met.value), pdf_to_eye, pdf_to_light };
        }
        let Some(r) = self.refraction(n, to_light, to_eye) else { return Evaluation::NOTHING };
        let seen = [l, e].map(|cos| self.ggx.g1_over_cos(cos.abs()));
        let eta2 = [l, e].map(|cos| self.eta(cos) * self.eta(cos));
        let value = r.cos[0] * r.cos[1] * r.value;
        Evaluation {
            value: self.tint * (value * eta2[1] * seen[0] * seen[1]),
            pdf_to_eye: value * eta2[1] * seen[0],
            pdf_to_light: value * eta2[0] * seen[1],
        }
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

    /// ∫ f_s cosθ dω over both sides without tint, of a beam that comes along `given` about n = z.
    pub fn albedo(&self, given: Vec3A) -> f32 {
        let g = given.z;
        let side = 1f32.copysign(g);
        visible_average(self.ggx, given, |h| {
            let f = self.fresnel(g, h.dot(given));
            let reflected = self.ggx.unmasked(g.abs(), reflect(given, h).z * side);
            let behind = refract(given, h, self.eta(-g) / self.eta(g)).map_or(0.0, |t| (-t.z * side).max(0.0));
            f * reflected + (1.0 - f) * behind * self.ggx.g1_over_cos(behind)
        })
    }
}
