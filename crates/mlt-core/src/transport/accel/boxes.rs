//! The test of a ray against the boxes of a node.
//!
//! **No box is missed.** Let ε = 2⁻²⁴ and M the largest absolute coordinate of the scene and the ray's origin. The
//! triangle test sees vertices displaced by at most 10 εM, and the box test's numerators are off by at most 4 εM, so every
//! box is widened by 16 εM. The quotients have relative errors of at most 3 ε each; the far ones are multiplied by
//! 1 + 8 ε. Both are folded into the ray, once, and cost nothing a box.

use super::segment::Segment;
use super::simd::{Simd, splat3};
use super::wide::Node;
use glam::Vec3A;

/// 16 ε, ε = 2⁻²⁴.
const WIDENING: f32 = 16.0 / 16_777_216.0;
/// 1 + 8 ε.
const FAR_FACTOR: f32 = 1.0 + 8.0 / 16_777_216.0;

/// Least speed along an axis; the largest is at least 10¹² times as much.
const SLOWEST: f32 = 1e-18;

/// The ray, made ready for boxes: the plane at p is met at t = p · reciprocal − shift.
pub(super) struct BoxTest<S: Simd> {
    near_plane: [usize; 3],
    near_reciprocal: [S::Floats; 3],
    near_shift: [S::Floats; 3],
    far_reciprocal: [S::Floats; 3],
    far_shift: [S::Floats; 3],
}

impl<S: Simd> BoxTest<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &Segment, scene_coordinate: f32) -> Self {
        let Segment { origin, direction, .. } = *ray;
        let widening = WIDENING * Vec3A::splat(origin.abs().max_element()).max(Vec3A::splat(scene_coordinate));
        // A slower component moves the ray by less than the widening before it has left the scene.
        let least = Vec3A::splat(SLOWEST);
        let reciprocal = 1.0 / Vec3A::select(direction.abs().cmplt(least), least.copysign(direction), direction);
        let far_reciprocal = FAR_FACTOR * reciprocal;
        let widening = widening.copysign(reciprocal);
        let backwards = reciprocal.cmplt(Vec3A::ZERO).bitmask() as usize;
        Self {
            near_plane: [backwards & 1, 2 + (backwards >> 1 & 1), 4 + (backwards >> 2)],
            near_reciprocal: splat3(simd, reciprocal.to_array()),
            near_shift: splat3(simd, ((origin + widening) * reciprocal).to_array()),
            far_reciprocal: splat3(simd, far_reciprocal.to_array()),
            far_shift: splat3(simd, ((origin - widening) * far_reciprocal).to_array()),
        }
    }

    /// Which boxes the ray meets with 0 ≤ t ≤ t_max, and where it enters them.
    #[inline(always)]
    pub(super) fn test(&self, simd: S, node: &Node, t_max: f32) -> (S::Mask, S::Floats) {
        let near = |axis: usize| {
            let plane = simd.load(&node.planes[self.near_plane[axis]]);
            simd.mul_sub(plane, self.near_reciprocal[axis], self.near_shift[axis])
        };
        let far = |axis: usize| {
            let plane = simd.load(&node.planes[self.near_plane[axis] ^ 1]);
            simd.mul_sub(plane, self.far_reciprocal[axis], self.far_shift[axis])
        };
        let enter = simd.max(simd.max(near(0), near(1)), simd.max(near(2), simd.splat(0.0)));
        let leave = simd.min(simd.min(far(0), far(1)), simd.min(far(2), simd.splat(t_max)));
        (simd.le(enter, leave), enter)
    }
}
