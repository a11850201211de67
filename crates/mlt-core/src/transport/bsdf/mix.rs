//! Blend of two surfaces.

use super::{Bsdf, Evaluation, choose};
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
    /// (1 - w) f_a + w f_b, and densities alike.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let (a, b) = (self.a.evaluate(n, to_light, to_eye), self.b.evaluate(n, to_light, to_eye));
        let pdf = |a: f32, b: f32| (1.0 - self.weight) * a + self.weight * b;
        Evaluation {
            value: (1.0 - self.weight) * a.value + self.weight * b.value,
            pdf_to_eye: pdf(a.pdf_to_eye, b.pdf_to_eye),
            pdf_to_light: pdf(a.pdf_to_light, b.pdf_to_light),
        }
    }

    /// Samples b with probability w, else a.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let (b, rest) = choose(u[2], self.weight);
        (if b { &self.b } else { &self.a }).sample(n, given, [u[0], u[1], rest])
    }
}
