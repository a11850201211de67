//! GGX microfacets whose slopes differ along and across a direction of the surface.
//!
//! With t a tangent of the surface, b = n × t, and α_t, α_b along them, Smith's shadowing and the visible normals are those of isotropic GGX
//! after stretching: with r(v) = √((v·n)² + α_t² (v·t)² + α_b² (v·b)²),
//!
//! * D(h) = 1/(π α_t α_b ((h·t)²/α_t² + (h·b)²/α_b² + (h·n)²)²)
//! * Λ(v) = (r/cosθ − 1)/2, and G₁, G₂ and D_v from it as in [`microfacet`](super::microfacet)
//!
//! Source: [Heitz14], section 5.3.

use super::microfacet::{GRAZING, Microfacets, Reflection, half, visible_cap};
use crate::transport::geometry::math::{cross, unit};
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;

/// Distribution of microfacet normals.
#[derive(Clone, Copy, Debug)]
pub struct AnisotropicGgx {
    /// Unit tangent that α_t is along.
    pub tangent: Vec3A,
    /// α_t and α_b ∈ [10⁻⁶, 1].
    pub alphas: [f32; 2],
}

impl AnisotropicGgx {
    /// v·t, v·b and v·n.
    #[inline]
    pub(super) fn local(self, n: Vec3A, v: Vec3A) -> [f32; 3] {
        [v.dot(self.tangent), v.dot(cross(n, self.tangent)), v.dot(n)]
    }

    /// r(v).
    #[inline]
    fn root(self, [x, y, z]: [f32; 3]) -> f32 {
        let [x, y] = [self.alphas[0] * x, self.alphas[1] * y];
        (x * x + y * y + z * z).sqrt()
    }

    /// D(h), sr⁻¹; either sign of h.
    #[inline]
    fn d(self, [x, y, z]: [f32; 3]) -> f32 {
        let [x, y] = [x / self.alphas[0], y / self.alphas[1]];
        let t = x * x + y * y + z * z;
        FRAC_1_PI / (self.alphas[0] * self.alphas[1] * t * t)
    }

    /// G₂/G₁(a), the share of what `a` sees that leaves along `b`, both about n = z; 0 where b is below.
    pub(super) fn unmasked(self, a: Vec3A, b: Vec3A) -> f32 {
        let (ra, rb) = (self.root(self.local(Vec3A::Z, a)), self.root(self.local(Vec3A::Z, b)));
        (b.z * (a.z + ra) / (a.z * rb + b.z * ra)).max(0.0)
    }
}

impl Microfacets for AnisotropicGgx {
    #[inline]
    fn reflection(self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Reflection> {
        let (h, cos_half) = half(n, a, b)?;
        let (ca, cb) = (n.dot(a).abs(), n.dot(b).abs());
        let (ra, rb) = (self.root(self.local(n, a)), self.root(self.local(n, b)));
        Some(Reflection::new(self.d(self.local(n, h)), cos_half, [ca, cb], [ra, rb]))
    }

    #[inline]
    fn sample_normal(self, n: Vec3A, v: Vec3A, u: [f32; 2]) -> Option<Vec3A> {
        let n = n * 1f32.copysign(n.dot(v));
        let [x, y, z] = self.local(n, v);
        if z.is_nan() || z <= GRAZING {
            return None;
        }
        let [along, across] = self.alphas;
        let h = visible_cap(unit(Vec3A::new(along * x, across * y, z)), u);
        (along * h.x * self.tangent + across * h.y * cross(n, self.tangent) + h.z * n).try_normalize()
    }
}
