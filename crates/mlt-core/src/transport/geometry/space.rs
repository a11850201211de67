//! The renderer's own coordinates.

use glam::{DAffine3, DMat3, DVec3, Vec3};

/// A translation and a scaling by a power of two that bring a scene to size 1 near the origin, where f32 is finest.
///
/// Radiance does not change under either. The scene is moved only if it, or most of it, lies far from the origin for its size:
/// near the origin the author's coordinates are already as fine as they can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    origin: DVec3,
    scale: f64,
    /// Radius of a sphere around the scene, in these coordinates.
    pub(crate) radius: f32,
}

impl Space {
    /// The space for a scene of these points.
    pub(crate) fn around(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let whole = Extent::of(points.clone());
        if !whole.low.is_finite() || !whole.high.is_finite() {
            return Self { origin: DVec3::ZERO, scale: 1.0, radius: 1.0 };
        }
        let most = Extent::of_most(points);
        let origin = if whole.is_far(FAR) {
            whole.centre()
        } else if most.is_far(VERY_FAR) {
            most.centre()
        } else {
            DVec3::ZERO
        };
        let reach = (whole.low - origin).abs().max((whole.high - origin).abs()).max_element();
        let scale = if reach > 0.0 { libm::exp2(-libm::ceil(libm::log2(reach))) } else { 1.0 };
        let radius = (whole.half().length() * scale).max(f64::from(f32::MIN_POSITIVE)) as f32;
        Self { origin, scale, radius }
    }

    /// A world length in these coordinates.
    pub(crate) fn length(&self, world: f64) -> f32 {
        (world * self.scale) as f32
    }

    /// The world position of a point in these coordinates.
    pub(crate) fn world(&self, point: Vec3) -> DVec3 {
        point.as_dvec3() / self.scale + self.origin
    }

    /// A world position in these coordinates.
    pub(crate) fn point(&self, world: DVec3) -> Vec3 {
        ((world - self.origin) * self.scale).as_vec3()
    }

    /// The map from the world to these coordinates.
    pub(crate) fn map(&self) -> DAffine3 {
        let matrix3 = DMat3::from_diagonal(DVec3::splat(self.scale));
        DAffine3 { matrix3, translation: -self.origin * self.scale }
    }

    /// The map from these coordinates to the world.
    pub(crate) fn to_world(self) -> DAffine3 {
        DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(1.0 / self.scale)), translation: self.origin }
    }
}

/// Distance from the origin, in half widths, from which on a scene is moved.
const FAR: f64 = 4.0;
/// The same for most of a scene, where the rest keeps it from being far: six bits of 24 are lost there.
const VERY_FAR: f64 = 64.0;
/// Points that stand for all when most are asked for.
const SAMPLE: usize = 4096;

/// A box.
#[derive(Clone, Copy)]
struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    fn of(points: impl Iterator<Item = DVec3>) -> Self {
        let (low, high) =
            points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        Self { low, high }
    }

    /// Holds three quarters of the points along each axis, so that a few far away do not count.
    fn of_most(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let step = points.clone().count().div_ceil(SAMPLE).max(1);
        let sample: Vec<_> = points.step_by(step).collect();
        let quantiles = [0, 1, 2].map(|axis| {
            let mut along: Vec<_> = sample.iter().map(|p| p[axis]).collect();
            along.sort_unstable_by(f64::total_cmp);
            [along.len() / 8, along.len() - 1 - along.len() / 8].map(|i| along[i])
        });
        let [low, high] = [0, 1].map(|end| DVec3::from_array(quantiles.map(|q| q[end])));
        Self { low, high }
    }

    fn centre(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    fn half(&self) -> DVec3 {
        0.5 * (self.high - self.low)
    }

    fn is_far(&self, half_widths: f64) -> bool {
        self.low.abs().max(self.high.abs()).max_element() > half_widths * self.half().max_element()
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

    #[test]
    fn a_stray_point_does_not_cost_a_far_scene_its_detail() {
        let at = DVec3::new(1e4, -7e3, 0.0);
        let room = (0..64).map(|i| at + DVec3::new(f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)));
        let space = Space::around(room.chain([DVec3::splat(1e6)]));
        let [a, b] = [0.5, 0.5001].map(|x| space.point(at + DVec3::new(x, 1.5, 1.5)));
        assert!((f64::from(b.x - a.x) / space.scale / 1e-4 - 1.0).abs() < 1e-2);
        let near = Space::around((0..64).map(|i| DVec3::splat(f64::from(i))).chain([DVec3::splat(1e6)]));
        assert_eq!(near.origin, DVec3::ZERO);
    }
}
