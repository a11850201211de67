//! Small geometry: frames and maps from the unit square.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Two unit vectors that complete the unit vector `n` to a right-handed frame (s, t, n).
///
/// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
#[inline]
pub fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// Maps the unit square onto the unit disk, preserving relative area.
///
/// Source: Shirley & Chiu, "A Low Distortion Map Between Disk and Square", 1997.
#[inline]
pub fn square_to_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (r, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * (p.y / p.x)) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y)) };
    r * Vec2::new(angle.cos(), angle.sin())
}

/// A direction about the unit vector `n` with density cosθ/π, sr⁻¹.
#[inline]
pub fn cosine_hemisphere(n: Vec3, u: Vec2) -> Vec3 {
    let d = square_to_disk(u);
    let z = (1.0 - d.length_squared()).max(0.0).sqrt();
    let (s, t) = frame(n);
    d.x * s + d.y * t + z * n
}

/// `a`·`b` of the vectors, absolute.
#[inline]
pub fn abs_dot(a: Vec3, b: Vec3) -> f32 {
    a.dot(b).abs()
}
