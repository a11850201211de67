//! Blend of two surfaces.

use super::super::Rgb;
use super::Bsdf;
use glam::Vec3A;

/// f_s = (1 - w) f_a + w f_b, neither of them delta.
#[derive(Clone, Debug)]
pub struct Mix {
    /// Has the share 1 - w.
    pub a: Bsdf,
    /// Has the share w.
    pub b: Bsdf,
    /// w ∈ (0, 1).
    pub weight: f32,
}

impl Mix {
    /// (1 - w) f_a + w f_b.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        (1.0 - self.weight) * self.a.eval(n, to_light, to_eye) + self.weight * self.b.eval(n, to_light, to_eye)
    }

    /// (1 - w) p_a + w p_b.
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        (1.0 - self.weight) * self.a.pdf(n, given, sampled) + self.weight * self.b.pdf(n, given, sampled)
    }

    /// Samples b with probability w, else a; what is left of `u[2]` is passed on.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        // Below 1 also after rounding.
        let rest = |u2: f32, p: f32| (u2 / p).min(1.0 - f32::EPSILON);
        if u[2] < self.weight {
            self.b.sample(n, given, [u[0], u[1], rest(u[2], self.weight)])
        } else {
            self.a.sample(n, given, [u[0], u[1], rest(u[2] - self.weight, 1.0 - self.weight)])
        }
    }
}
