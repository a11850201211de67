//! The renderer's own coordinates.

use glam::{DVec3, Vec3};

/// A translation and a scaling by a power of two that bring a scene to size 1 near the origin, where f32 is finest.
///
/// Radiance does not change under either. The scene is moved only if it lies far from the origin for its size: near the
/// origin the author's coordinates are already as fine as they can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    origin: DVec3,
    scale: f64,
    /// Radius of a sphere around the scene, in these coordinates.
    pub(super) radius: f32,
}

impl Space {
    /// The space for a scene of these points.
    pub(super) fn around(points: impl Iterator<Item = DVec3>) -> Self {
        let (low, high) =
            points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        if !low.is_finite() || !high.is_finite() {
            return Self { origin: DVec3::ZERO, scale: 1.0, radius: 1.0 };
        }
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let far = low.abs().max(high.abs()).max_element() > 4.0 * half.max_element();
        let origin = if far { centre } else { DVec3::ZERO };
        let reach = (low - origin).abs().max((high - origin).abs()).max_element();
        let scale = if reach > 0.0 { libm::exp2(-libm::ceil(libm::log2(reach))) } else { 1.0 };
        Self { origin, scale, radius: (half.length() * scale).max(f64::from(f32::MIN_POSITIVE)) as f32 }
    }

    /// A world position in these coordinates.
    pub(super) fn point(&self, world: DVec3) -> Vec3 {
        ((world - self.origin) * self.scale).as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_scene_far_away_keeps_its_detail() {
        let at = DVec3::splat(1e5);
        let corners = [at, at + DVec3::new(1e-3, 2e-3, 0.0)];
        let space = Space::around(corners.into_iter());
        let size = space.point(corners[1]) - space.point(corners[0]);
        assert!((size.y / size.x - 2.0).abs() < 1e-5);
        assert!(size.y > 0.5 && size.y < 2.0);
    }

    #[test]
    fn a_scene_at_the_origin_is_only_scaled() {
        let space = Space::around([DVec3::ZERO, DVec3::new(550.0, 548.8, 559.2)].into_iter());
        assert_eq!(space.point(DVec3::new(512.0, 1.0, 0.0)), Vec3::new(0.5, 1.0 / 1024.0, 0.0));
    }
}
