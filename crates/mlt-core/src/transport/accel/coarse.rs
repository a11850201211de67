//! Triangles that are much larger than the detail around them.
//!
//! In f32 the test's t is off by a few units in the last place of the distance to the triangle's farthest vertex: on a plain of
//! a thousand kilometres by decimetres, however near the ray meets it. Where a scene has triangles so much larger than its
//! smallest ones that this would show, t is computed in f64, from the triangle's plane; the test still says which triangles the
//! ray passes through, so that it stays watertight.

use super::wide::TriangleBlock;
use crate::transport::geometry::Ray;
use glam::Vec3;

/// How many times larger than the smallest triangle a triangle is whose t has an error that may show: 1/250 of the former's
/// size.
pub const COARSE: f32 = 16_384.0;

/// Triangles whose bounding box has a side longer than this are coarse.
pub fn coarse_size<'a>(triangles: impl IntoIterator<Item = &'a [Vec3; 3]>) -> f32 {
    let sizes = triangles.into_iter().map(size).filter(|&size| size > 0.0 && size.is_finite());
    COARSE * sizes.fold(f32::INFINITY, f32::min)
}

/// Longest side of a triangle's bounding box.
pub fn size(&[a, b, c]: &[Vec3; 3]) -> f32 {
    (a.max(b).max(c) - a.min(b).min(c)).max_element()
}

/// Of the lanes `hits` of a block, through whose triangles the ray passes, those with 0 < t ≤ t_max by f64; sets their t.
#[cold]
pub(super) fn in_range(block: &TriangleBlock, ray: &Ray, mut hits: u32, t: &mut [f32; 8], t_max: f32) -> u32 {
    let mut found = 0;
    while hits != 0 {
        let lane = hits.trailing_zeros() as usize & 7;
        hits &= hits - 1;
        let exact = ray.plane_parameter(block.vertices.map(|axes| Vec3::from_array(axes.map(|x| x.0[lane]))));
        if exact > 0.0 && exact <= f64::from(t_max) {
            t[lane] = exact as f32;
            found |= 1 << lane;
        }
    }
    found
}
