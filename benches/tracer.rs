//! Tracers, which the benchmarks of rays compare: anything that finds hits.

use glam::{Vec3, Vec3A};
use mlt_core::transport::accel::Accel;
use mlt_core::transport::geometry::Ray;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::{BvhBuildParams, ray::Ray as ObvhsRay, ray::RayHit, triangle::Triangle};
use std::time::Duration;

/// Finds hits.
pub trait Tracer {
    /// Ray parameter of the nearest hit.
    fn nearest(&self, ray: &Ray) -> Option<f32>;
    /// Whether there is any.
    fn occluded(&self, ray: &Ray) -> bool;

    /// How many rays hit, by their nearest hits, whose distances it adds up so that they have to be found.
    fn count_nearest(&self, rays: &[Ray]) -> usize {
        let found = rays.iter().filter_map(|ray| self.nearest(ray));
        let (hits, sum) = found.fold((0, 0.0), |(hits, sum), t| (hits + 1, sum + t));
        std::hint::black_box(sum);
        hits
    }

    /// How many rays hit.
    fn count_occluded(&self, rays: &[Ray]) -> usize {
        rays.iter().filter(|ray| self.occluded(ray)).count()
    }
}

impl Tracer for Accel {
    #[inline(always)]
    fn nearest(&self, ray: &Ray) -> Option<f32> {
        self.closest(ray).map(|hit| hit.t)
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray) -> bool {
        self.occluded(ray)
    }
}

fn obvhs_triangles(triangles: &[[Vec3; 3]]) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle { v0: t[0].into(), v1: t[1].into(), v2: t[2].into() }).collect()
}

fn in_order(triangles: &[Triangle], indices: &[u32]) -> Vec<Triangle> {
    indices.iter().map(|&i| triangles[i as usize]).collect()
}

fn obvhs_ray(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(Vec3A::from(ray.origin), Vec3A::from(ray.direction), 0.0, ray.t_max)
}

/// A tree of obvhs with its own traversal, and the triangles in the tree's order.
pub struct Obvhs<T>(T, Vec<Triangle>);

impl Obvhs<Bvh2> {
    /// The binary tree.
    pub fn binary(triangles: &[[Vec3; 3]]) -> Self {
        let triangles = obvhs_triangles(triangles);
        let tree = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let ordered = in_order(&triangles, &tree.primitive_indices);
        Self(tree, ordered)
    }
}

impl Obvhs<CwBvh> {
    /// The compressed 8-wide tree.
    pub fn wide(triangles: &[[Vec3; 3]]) -> Self {
        let triangles = obvhs_triangles(triangles);
        let tree = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let ordered = in_order(&triangles, &tree.primitive_indices);
        Self(tree, ordered)
    }
}

macro_rules! traverse_obvhs {
    ($tree:ty) => {
        impl Tracer for Obvhs<$tree> {
            #[inline(always)]
            fn nearest(&self, ray: &Ray) -> Option<f32> {
                let mut hit = RayHit::none();
                self.0.ray_traverse(obvhs_ray(ray), &mut hit, |ray, i| self.1[i].intersect(ray)).then_some(hit.t)
            }

            #[inline(always)]
            fn occluded(&self, ray: &Ray) -> bool {
                !self.0.ray_traverse_miss(obvhs_ray(ray), |ray, i| self.1[i].intersect(ray))
            }
        }
    };
}

traverse_obvhs!(Bvh2);
traverse_obvhs!(CwBvh);
