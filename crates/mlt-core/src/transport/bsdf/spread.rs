//! Directions about as light leaves that microfacets scatter more than once.

use super::microfacet::Ggx;
use crate::transport::geometry::math::{frame, turn};
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;

/// q = cosθ/(π (cos²θ + α²) ln(1 + 1/α²)), sr⁻¹.
///
/// Beyond the angles at which the surface shadows itself, cosθ ≈ α, what is scattered twice falls like 1/cos²θ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    alpha2: f32,
    /// ln(1 + 1/α²).
    log: f32,
    /// 1/(π log).
    scale: f32,
}

impl Spread {
    /// For these microfacets.
    pub(super) fn new(ggx: Ggx) -> Self {
        let alpha2 = ggx.alpha * ggx.alpha;
        let log = libm::log1pf(1.0 / alpha2);
        Self { alpha2, log, scale: FRAC_1_PI / log }
    }

    /// q.
    #[inline]
    pub(super) fn pdf(self, cos: f32) -> f32 {
        self.scale * cos / (cos * cos + self.alpha2)
    }

    /// A direction on the side of `n`; cos²θ = α² ((1 + 1/α²)ᵘ - 1).
    #[inline]
    pub(super) fn sample(self, n: Vec3A, u: [f32; 2]) -> Vec3A {
        let cos2 = (self.alpha2 * libm::expm1f(u[0] * self.log)).min(1.0);
        let (sin, cos) = ((1.0 - cos2).sqrt(), cos2.sqrt());
        let (s, t) = frame(n);
        let azimuth = turn(u[1]);
        sin * (azimuth.x * s + azimuth.y * t) + cos * n
    }
}
