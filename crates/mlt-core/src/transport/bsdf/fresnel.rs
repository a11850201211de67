//! Fresnel reflectance, and the two directions that go with it.

use crate::transport::colour::Rgb;
use glam::Vec3A;

/// Share of unpolarised light that a smooth interface reflects.
///
/// F = (r∥² + r⊥²)/2,  r∥ = (η cosθ - cosθ')/(η cosθ + cosθ'),  r⊥ = (cosθ - η cosθ')/(cosθ + η cosθ')
///
/// `cos` = cosθ ≥ 0 on the side of the light, `eta` = η(far side)/η(near side), sinθ' = sinθ/η; 1 at total reflection.
///
/// Source: Born & Wolf, "Principles of Optics", 1.5.2.
#[inline]
pub fn dielectric(cos: f32, eta: f32) -> f32 {
    if eta == 1.0 {
        return 0.0;
    }
    let sin2_far = (1.0 - cos * cos).max(0.0) / (eta * eta);
    if sin2_far >= 1.0 {
        return 1.0;
    }
    let cos_far = (1.0 - sin2_far).sqrt();
    let parallel = (eta * cos - cos_far) / (eta * cos + cos_far);
    let perpendicular = (cos - eta * cos_far) / (cos + eta * cos_far);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// F = F₀ + (F₉₀ - F₀)(1 - cosθ)⁵.
///
/// Source: Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994.
#[inline]
pub fn schlick(f0: Rgb, f90: f32, cos: f32) -> Rgb {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    f0 + (Rgb::splat(f90) - f0) * (m2 * m2 * m)
}

/// F̄ = ∫₀¹ F 2μ dμ = F₀ + (F₉₀ - F₀)/21.
pub fn schlick_average(f0: Rgb, f90: f32) -> Rgb {
    f0 + (Rgb::splat(f90) - f0) / 21.0
}

/// `v` mirrored about the unit vector `h`: 2(v·h)h - v.
#[inline]
pub fn reflect(v: Vec3A, h: Vec3A) -> Vec3A {
    (2.0 * v.dot(h) * h - v).normalize_or_zero()
}

/// Where light that leaves along `v` comes from through an interface with normal `h`, v·h ≥ 0; `None`: total reflection.
///
/// t = -v/η + (cosθ/η - cosθ')h,  `eta` = η(far side)/η(near side)
#[inline]
pub fn refract(v: Vec3A, h: Vec3A, eta: f32) -> Option<Vec3A> {
    let cos = v.dot(h).min(1.0);
    let sin2_far = (1.0 - cos * cos) / (eta * eta);
    if sin2_far >= 1.0 {
        return None;
    }
    let t = (cos / eta - (1.0 - sin2_far).sqrt()) * h - v / eta;
    Some(t.normalize_or_zero())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_and_brewster() {
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        // At Brewster's angle only r⊥ is left: ((1-η²)/(1+η²))²/2.
        let cos = 1.5f32.atan().cos();
        let expected = 0.5 * ((1.0 - 2.25f32) / (1.0 + 2.25)).powi(2);
        assert!((dielectric(cos, 1.5) - expected).abs() < 1e-6);
    }

    #[test]
    fn same_from_both_sides() {
        for i in 1..100 {
            let cos = i as f32 / 100.0;
            let far = (1.0 - (1.0 - cos * cos) / 2.25f32).sqrt();
            // At grazing angles the way back magnifies the rounding of cosθ'.
            assert!((dielectric(cos, 1.5) - dielectric(far, 1.0 / 1.5)).abs() < 1e-6 / cos);
        }
        assert_eq!(dielectric(0.3, 1.0 / 1.5), 1.0);
        assert_eq!(dielectric(0.0, 1.0), 0.0);
    }

    #[test]
    fn refraction_obeys_snell_and_returns() {
        let v = Vec3A::new(0.6, 0.0, 0.8);
        let t = refract(v, Vec3A::Z, 1.5).unwrap();
        assert!((t.x + 0.4).abs() < 1e-6 && t.z < 0.0);
        assert!((refract(t, -Vec3A::Z, 1.0 / 1.5).unwrap() - v).length() < 1e-6);
        assert!(refract(v, Vec3A::Z, 0.5).is_none());
    }
}
