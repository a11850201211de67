//! Coordinates on triangles, and intervals of the unit square that they take.

use glam::Vec3;

/// Weights of the second and third vertex of a triangle at a point of the unit square, preserving relative area.
#[inline(always)]
pub(super) fn on_triangle(u: f64, v: f64) -> [f32; 2] {
    let root = u.clamp(0.0, 1.0).sqrt() as f32;
    [root * (1.0 - v as f32), root * v as f32]
}

/// Where a part begins and ends.
pub(super) fn interval(cumulative: &[f64], i: usize) -> (f64, f64) {
    (if i == 0 { 0.0 } else { cumulative[i - 1] }, cumulative[i])
}

/// (s, t), each clamped to [0, 1], of the point s·e + t·f nearest to p.
pub(super) fn weights(p: Vec3, e: Vec3, f: Vec3) -> (f64, f64) {
    let (p, e, f) = (p.as_dvec3(), e.as_dvec3(), f.as_dvec3());
    let n = e.cross(f);
    let d = n.length_squared();
    (p.cross(f).dot(n).clamp(0.0, d) / d, e.cross(p).dot(n).clamp(0.0, d) / d)
}
