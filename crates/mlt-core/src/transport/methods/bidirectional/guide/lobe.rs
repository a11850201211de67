//! Lobes of directions whose tails are heavy.
//!
//! Source: [KatoMcCullagh20].

use crate::transport::geometry::math::{frame, turn, unit};
use glam::Vec3A;
use std::f32::consts::PI;

/// Least width: a thousandth of a radian.
const LEAST_WIDTH: f32 = 5e-7;

/// A spherical Cauchy distribution of directions, of density q = ε (2 + ε)/(4π (1 − ω·d + ε)²).
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// d.
    pub(super) axis: Vec3A,
    /// ε.
    width: f32,
}

impl Lobe {
    /// About a vector; about any direction, and wide, where that is none.
    pub(super) fn towards(vector: Vec3A, width: f32) -> Self {
        match vector.length_squared() {
            square if square > 0.0 && square.is_finite() => {
                Self { axis: unit(vector), width: width.clamp(LEAST_WIDTH, 1.0) }
            }
            _ => Self { axis: Vec3A::Z, width: 1.0 },
        }
    }

    /// By inversion of the distribution of z, z/(z + ε) (2 + ε)/2.
    pub(super) fn sample(&self, u: f32, v: f32) -> Vec3A {
        let part = 2.0 * u / (2.0 + self.width);
        let z = (self.width * part / (1.0 - part)).min(2.0);
        let (about, (s, t)) = (turn(v), frame(self.axis));
        unit((1.0 - z) * self.axis + (z * (2.0 - z)).sqrt() * (about.x * s + about.y * t))
    }

    /// q, sr⁻¹.
    pub(super) fn density(&self, direction: Vec3A) -> f32 {
        // 1 − cosθ, without the cancellation.
        let z = 0.5 * (direction - self.axis).length_squared();
        self.width * (2.0 + self.width) / (4.0 * PI * (z + self.width).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform_f32};

    /// Shares of directions within angles of the axis, counted and integrated.
    #[test]
    fn a_lobe_is_drawn_as_its_density_says() {
        let n = 20_000;
        for width in [1e-4_f32, 0.03, 1.0] {
            let lobe = Lobe { axis: unit(Vec3A::new(0.3, -0.8, 0.5)), width };
            let (side, _) = frame(lobe.axis);
            let at = |z: f32| (1.0 - z) * lobe.axis + (z * (2.0 - z)).max(0.0).sqrt() * side;
            for part in [0.3, 1.0, 20.0] {
                let most = (part * width).min(2.0);
                let middle = |i: u16| most * (f32::from(i) + 0.5) / 10_000.0;
                let expected: f32 = (0..10_000).map(|i| 2.0 * PI * lobe.density(at(middle(i))) * most / 10_000.0).sum();
                let within = |i: &u64| {
                    let rng = &mut generator(1, Purpose::Sample, 0, 0, *i);
                    let direction = lobe.sample(uniform_f32(rng), uniform_f32(rng));
                    0.5 * (direction - lobe.axis).length_squared() < most
                };
                let (found, expected) = ((0..n).filter(within).count() as f64, f64::from(expected) * n as f64);
                let error = (expected * (1.0 - expected / n as f64)).max(1.0).sqrt();
                assert!((found - expected).abs() < 4.5 * error, "{width} {part}: {found} of {expected}");
            }
        }
    }
}
