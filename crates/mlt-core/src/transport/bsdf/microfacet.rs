//! Isotropic GGX microfacets with Smith's shadowing.
//!
//! Everything is written in dot products of world-space vectors; a frame is built for sampling only. cosθ is that of a
//! direction to n, on the side of that direction (≥ 0). With r(cosθ) = √(cos²θ + α² sin²θ):
//!
//! * D(h) = α²/(π (α² cos²θₕ + sin²θₕ)²)
//! * Λ(v) = (r/cosθ - 1)/2,  G₁(v) = 1/(1 + Λ) = 2cosθ/(cosθ + r)
//! * G₂(a, b) = 1/(1 + Λ(a) + Λ(b)), directions on one side, heights correlated
//! * D_v(h) = G₁(v) (v·h) D(h)/cosθᵥ, the density of normals visible from v, sr⁻¹
//!
//! Sources: [Walter07], [Heitz14]. Light that meets the surface more than once: `albedo`.

use super::fresnel::reflect;
use crate::transport::geometry::math::{cross, frame, turn, unit};
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;
use std::fmt::Debug;

/// Directions with a cosine up to this, a few roundings of a dot product, count as tangent and scatter nothing.
pub const GRAZING: f32 = 1e-6;

/// A distribution of the normals of microfacets that reflect.
pub trait Microfacets: Copy + Debug {
    /// How they mirror `a` into `b`; `None`: not on one side.
    fn reflection(self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Reflection>;

    /// A normal on the side of `v` with density D_v; `None`: `v` is tangent.
    fn sample_normal(self, n: Vec3A, v: Vec3A, u: [f32; 2]) -> Option<Vec3A>;

    /// `given` mirrored about a normal that it sees; density: [`Reflection::pdf`]; `None`: it would go below the surface.
    #[inline]
    fn sample_reflection(self, n: Vec3A, given: Vec3A, u: [f32; 2]) -> Option<Vec3A> {
        let r = reflect(given, self.sample_normal(n, given, u)?);
        (n.dot(r) * 1f32.copysign(n.dot(given)) > GRAZING).then_some(r)
    }
}

/// The same distribution along all directions of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    /// α ∈ [10⁻⁶, 1], slope that half of the microfacets' area stays below; glTF's roughness².
    pub alpha: f32,
}

/// Scattering by the microfacets whose normal halves the angle between two directions.
#[derive(Debug)]
pub struct Reflection {
    /// cos of the half angle, h·a = h·b ≤ 1.
    pub cos_half: f32,
    /// D(h) G₂/(4 cosθₐ cosθ_b), sr⁻¹: f_s where microfacets reflect everything.
    pub value: f32,
    /// D_v(h)/(4 h·v) for v = b and v = a: densities of drawing a from b, and b from a, sr⁻¹.
    pub pdf: [f32; 2],
}

impl Reflection {
    /// From D(h), sr⁻¹, the half angle's cosine, and for `a` and `b` the cosine c and the root c (1 + 2 Λ) of each.
    #[inline(always)]
    pub(super) fn new(d: f32, cos_half: f32, [ca, cb]: [f32; 2], [ra, rb]: [f32; 2]) -> Self {
        let half_d = 0.5 * d;
        Self { cos_half, value: half_d / (ca * rb + cb * ra), pdf: [half_d / (cb + rb), half_d / (ca + ra)] }
    }
}

impl Ggx {
    /// D(h), sr⁻¹; either sign of `h`.
    ///
    /// sinθₕ comes from n × h: 1 - cos²θₕ would lose all digits at small α.
    #[inline]
    pub fn d(self, n: Vec3A, h: Vec3A) -> f32 {
        let a2 = self.alpha * self.alpha;
        let cos = n.dot(h);
        let t = a2 * cos * cos + cross(n, h).length_squared();
        FRAC_1_PI * a2 / (t * t)
    }

    /// r(cosθ).
    #[inline]
    fn root(self, cos: f32) -> f32 {
        let a2 = self.alpha * self.alpha;
        (a2 + (1.0 - a2).max(0.0) * cos * cos).sqrt()
    }

    /// G₁/cosθ = 2/(cosθ + r), finite up to grazing angles.
    #[inline]
    pub fn g1_over_cos(self, cos: f32) -> f32 {
        2.0 / (cos + self.root(cos))
    }

    /// G₂/G₁(a), the share of what `a` sees that leaves along `b`, on one side; 0 where b is below.
    #[inline]
    pub fn unmasked(self, cos_a: f32, cos_b: f32) -> f32 {
        let (ra, rb) = (self.root(cos_a), self.root(cos_b));
        (cos_b * (cos_a + ra) / (cos_a * rb + cos_b * ra)).max(0.0)
    }
}

impl Microfacets for Ggx {
    #[inline]
    fn reflection(self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Reflection> {
        let (h, cos_half) = half(n, a, b)?;
        let (ca, cb) = (n.dot(a).abs(), n.dot(b).abs());
        let (ra, rb) = (self.root(ca), self.root(cb));
        Some(Reflection::new(self.d(n, h), cos_half, [ca, cb], [ra, rb]))
    }

    #[inline]
    fn sample_normal(self, n: Vec3A, v: Vec3A, u: [f32; 2]) -> Option<Vec3A> {
        let n = n * 1f32.copysign(n.dot(v));
        let cos = n.dot(v);
        if cos.is_nan() || cos <= GRAZING {
            return None;
        }
        let (s, t) = frame(n);
        let h = visible_cap(unit(Vec3A::new(self.alpha * v.dot(s), self.alpha * v.dot(t), cos)), u);
        (self.alpha * h.x * s + self.alpha * h.y * t + h.z * n).try_normalize()
    }
}

/// A normal, of any length, of the unit hemisphere about z that the unit direction `w` sees, in proportion to its projected area.
///
/// 1 - z and 1 + z of the cap's point are formed without cancellation.
///
/// Source: Dupuy & Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023.
#[inline]
pub(super) fn visible_cap(w: Vec3A, u: [f32; 2]) -> Vec3A {
    let below = u[1] * (1.0 + w.z);
    let sin = (below * (2.0 - below)).max(0.0).sqrt();
    let azimuth = sin * turn(u[0]);
    Vec3A::new(azimuth.x + w.x, azimuth.y + w.y, 1.0 + w.z - below)
}

/// Unit half vector, and the cosine of the half angle, |a + b|/2 ≤ 1; `None`: not on one side, or tangent.
#[inline]
pub(super) fn half(n: Vec3A, a: Vec3A, b: Vec3A) -> Option<(Vec3A, f32)> {
    let (ca, cb) = (n.dot(a), n.dot(b));
    let one_side = ca.min(cb) > GRAZING || ca.max(cb) < -GRAZING;
    let (sum, length) = (a + b, (a + b).length());
    (one_side && length > 0.0).then(|| (sum / length, (0.5 * length).min(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::{Rng, SeedableRng};

    /// ∫ D cosθ dω = 1, in t = tanθ/α.
    #[test]
    fn projected_area_is_one() {
        for alpha in [1.0, 0.3, 1e-2, 1e-4, 1e-6f32] {
            let steps = 100_000;
            let mut sum = 0.0f64;
            for i in 0..steps {
                // t = x/(1-x)
                let x = (i as f64 + 0.5) / steps as f64;
                let (t, dt) = (x / (1.0 - x), 1.0 / (1.0 - x).powi(2) / steps as f64);
                let tan = t * alpha as f64;
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let h = Vec3A::new((tan * cos) as f32, 0.0, cos as f32);
                sum +=
                    Ggx { alpha }.d(Vec3A::Z, h) as f64 * cos.powi(4) * tan * std::f64::consts::TAU * dt * alpha as f64;
            }
            assert!((sum - 1.0).abs() < 1e-3, "α = {alpha}: {sum}");
        }
    }

    /// Seen along n, P(tanθₕ < t α) = t²/(1 + t²); Kolmogorov–Smirnov, down to the smallest α.
    #[test]
    fn sampled_slopes_at_small_alpha() {
        let n = Vec3A::new(0.36, -0.48, 0.8);
        let mut rng = Pcg64Mcg::seed_from_u64(11);
        let mut uniform = || (rng.next_u32() >> 8) as f32 / (1u32 << 24) as f32;
        let mut distance = |alpha: f32, assumed: f64| {
            let draws = 20_000;
            let mut slopes: Vec<f64> = (0..draws)
                .map(|_| Ggx { alpha }.sample_normal(n, n, [uniform(), uniform()]).unwrap())
                .map(|h| (n.cross(h).length() / n.dot(h)) as f64 / assumed)
                .collect();
            slopes.sort_by(f64::total_cmp);
            let cdf = |t: f64| t * t / (1.0 + t * t);
            let d = |(i, t): (usize, &f64)| (cdf(*t) - (i as f64 + 0.5) / draws as f64).abs();
            slopes.iter().enumerate().map(d).fold(0.0, f64::max) * (draws as f64).sqrt()
        };
        for alpha in [0.5, 1e-2, 1e-4, 1e-5] {
            assert!(distance(alpha, alpha as f64) < 1.95);
            assert!(distance(alpha, alpha as f64 * 1.05) > 1.95);
        }
    }
}
