//! The watertight ray–triangle test, eight triangles at a time, and the accurate hit of the one that wins.
//!
//! Source: [WoopBenthinWald13]. The ray's dominant axis becomes z, the ray is sheared onto it, and three signed areas
//! in the (x, y) plane say on which side of each edge the ray passes. Two triangles that share an edge compute the
//! same two products for it, and rounding is monotonic, so the ray cannot pass on the wrong side of both. That is why
//! the areas are not fused: fl(fl(ab) − fl(cd)) never has the wrong sign, fl(ab − fl(cd)) may. An area of
//! zero counts as inside for both triangles, which replaces the paper's second test in double precision.

use super::coarse;
use super::simd::{Lanes, Simd, splat3};
use super::wide::TriangleBlock;
use crate::transport::geometry::{Hit, Ray};
use glam::{DVec2, Vec3A};

/// The map that takes the ray to the positive z axis: permute, move, shear.
pub(super) struct Shear<S: Simd> {
    axes: [usize; 3],
    origin: [S::Floats; 3],
    x: S::Floats,
    y: S::Floats,
    z: S::Floats,
}

/// The axes in cyclic order, the one along which the ray is fastest last.
#[inline(always)]
fn cyclic_axes(direction: Vec3A) -> [usize; 3] {
    let speed = direction.abs();
    let fastest = if speed.z >= speed.x && speed.z >= speed.y { 2 } else { usize::from(speed.y > speed.x) };
    // By arithmetic: a table would be looked up before it could be used.
    let next = |axis: usize| (axis + 1) & usize::from(axis == 2).wrapping_sub(1);
    [next(fastest), next(next(fastest)), fastest]
}

/// Which triangles of a block are hit, and where.
pub(super) struct Test<S: Simd> {
    /// A bit each.
    pub hits: u32,
    /// Ray parameters.
    t: S::Floats,
    /// Areas on the ray's side of each edge: weights of the vertices, but for `scale`.
    v: S::Floats,
    w: S::Floats,
    /// One over the sum of all three areas.
    scale: S::Floats,
    /// Squared distance from the ray to the farthest vertex, across the ray.
    extent: S::Floats,
}

/// The nearest hit so far.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    /// Ray parameter to the precision of the test; of no hit: the ray's end.
    pub t: f32,
    /// Index in the caller's array; `u32::MAX`: none yet.
    primitive: u32,
    block: u32,
    lane: u32,
    v: f32,
    w: f32,
    scale: f32,
    extent: f32,
}

impl<S: Simd> Shear<S> {
    /// For a ray with a finite, non-zero direction.
    #[inline(always)]
    pub(super) fn new(simd: S, origin: Vec3A, direction: Vec3A) -> Self {
        let axes @ [x, y, z] = cyclic_axes(direction);
        let (origin, direction) = (in_memory(origin), in_memory(direction));
        let along = direction[z & 3];
        Self {
            // The bound is for the compiler.
            axes: axes.map(|axis| axis.min(2)),
            origin: splat3(simd, [origin[x & 3], origin[y & 3], origin[z & 3]]),
            x: simd.splat(direction[x & 3] / along),
            y: simd.splat(direction[y & 3] / along),
            z: simd.splat(1.0 / along),
        }
    }

    /// Which triangles are hit with t_min < t ≤ t_max.
    #[inline(always)]
    pub(super) fn test(&self, simd: S, block: &TriangleBlock, [t_min, t_max]: [f32; 2]) -> Option<Test<S>> {
        let zero = simd.splat(0.0);
        let [ax, ay, az] = self.vertex(simd, block, 0);
        let [bx, by, bz] = self.vertex(simd, block, 1);
        let [cx, cy, cz] = self.vertex(simd, block, 2);
        let u = simd.sub(simd.mul(cx, by), simd.mul(cy, bx));
        let v = simd.sub(simd.mul(ax, cy), simd.mul(ay, cx));
        let w = simd.sub(simd.mul(bx, ay), simd.mul(by, ax));
        let least = simd.min(simd.min(u, v), w);
        let greatest = simd.max(simd.max(u, v), w);
        let inside = simd.or(simd.le(zero, least), simd.le(greatest, zero));
        // The reciprocal does not wait for the depth, and a hit's weights need it too.
        let scale = simd.div(simd.splat(1.0), simd.add(simd.add(u, v), w));
        let depth = simd.mul_add(u, az, simd.mul_add(v, bz, simd.mul(w, cz)));
        let t = simd.mul(depth, scale);
        let in_range = simd.and(simd.lt(simd.splat(t_min), t), simd.le(t, simd.splat(t_max)));
        let hits = simd.bits(simd.and(inside, in_range));
        let square = |x, y| simd.mul_add(x, x, simd.mul(y, y));
        let extent = simd.max(simd.max(square(ax, ay), square(bx, by)), square(cx, cy));
        (hits != 0).then_some(Test { hits, t, v, w, scale, extent })
    }

    /// Which triangles are hit with 0 < t ≤ t_max, by a t in f64.
    #[inline(always)]
    pub(super) fn test_coarse(
        &self,
        simd: S,
        block: &TriangleBlock,
        ray: impl Into<Ray>,
        t_max: f32,
    ) -> Option<Test<S>> {
        let mut test = self.test(simd, block, [f32::NEG_INFINITY, f32::INFINITY])?;
        let mut t = simd.store(test.t);
        test.hits = coarse::in_range(block, &ray.into(), test.hits, &mut t.0, t_max);
        test.t = simd.load(&t);
        (test.hits != 0).then_some(test)
    }

    /// One vertex of each triangle where the ray is the z axis, and z its parameter.
    #[inline(always)]
    fn vertex(&self, simd: S, block: &TriangleBlock, vertex: usize) -> [S::Floats; 3] {
        let moved = |i: usize| simd.sub(simd.load(&block.vertices[vertex][self.axes[i]]), self.origin[i]);
        let z = moved(2);
        [simd.neg_mul_add(self.x, z, moved(0)), simd.neg_mul_add(self.y, z, moved(1)), simd.mul(self.z, z)]
    }
}

/// To be indexed.
#[inline(always)]
fn in_memory(v: Vec3A) -> [f32; 4] {
    v.extend(0.0).to_array()
}

/// How many times longer than wide a triangle may look from the ray before its weights are computed in f64.
const SLENDER: f32 = 32.0;

impl Nearest {
    /// No hit on a ray that ends at `t_max`.
    #[inline(always)]
    pub(super) fn none(t_max: f32) -> Self {
        Self { t: t_max, primitive: u32::MAX, block: 0, lane: 0, v: 0.0, w: 0.0, scale: 0.0, extent: 0.0 }
    }

    /// Takes over the nearest of the hit lanes; of equals, the one that came first in the caller's array.
    #[inline(always)]
    pub(super) fn update<S: Simd>(&mut self, simd: S, test: &Test<S>, primitives: &[u32; 8], block: usize) {
        let (Lanes(t), Lanes(v), Lanes(w)) = (simd.store(test.t), simd.store(test.v), simd.store(test.w));
        let (Lanes(scale), Lanes(extent)) = (simd.store(test.scale), simd.store(test.extent));
        let mut hits = test.hits;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & 7;
            hits &= hits - 1;
            let primitive = primitives[lane];
            if t[lane] < self.t || (t[lane] == self.t && primitive < self.primitive) {
                *self = Self {
                    t: t[lane],
                    primitive,
                    block: block as u32,
                    lane: lane as u32,
                    v: v[lane],
                    w: w[lane],
                    scale: scale[lane],
                    extent: extent[lane],
                };
            }
        }
    }

    /// The hit, if there is one, of the ray that ends at `t_max`.
    ///
    /// Weights to the precision of the test are off by 10⁻⁷ times the triangle's length over its width, seen along the
    /// ray; where that is much they are computed again.
    #[inline(always)]
    pub(super) fn hit(&self, blocks: &[TriangleBlock], [origin, direction]: [Vec3A; 2], t_max: f32) -> Option<Hit> {
        if self.primitive == u32::MAX {
            return None;
        }
        if SLENDER < self.extent * self.scale.abs() {
            let ray = Ray { origin: origin.into(), direction: direction.into(), t_max };
            return Some(refine(&blocks[self.block as usize], ray, *self));
        }
        let u = (self.v * self.scale).min(1.0);
        let (v, most) = (self.w * self.scale, 1.0 - u);
        Some(Hit { primitive: self.primitive, t: self.t, u, v: if v < most { v } else { most } })
    }
}

/// The hit of the triangle that won, to double precision.
///
/// The test's own t is off by 10⁻⁵ on slivers. The areas are computed again in f64; where they say that the ray passes
/// outside, by less than the error of f32, the nearest point of the triangle's outline stands in. Then t is that of the
/// point with these weights: t, u and v agree even where the ray grazes the triangle.
///
/// Takes ray and candidate by value: a reference would keep them out of registers.
#[cold]
fn refine(block: &TriangleBlock, ray: Ray, candidate: Nearest) -> Hit {
    let [x, y, z] = cyclic_axes(ray.direction.into());
    let reciprocal = 1.0 / f64::from(ray.direction[z]);
    let shear = DVec2::new(ray.direction[x].into(), ray.direction[y].into()) * reciprocal;
    let (mut corners, mut depths) = ([DVec2::ZERO; 3], [0.0; 3]);
    for (vertex, (corner, depth)) in block.vertices.iter().zip(corners.iter_mut().zip(&mut depths)) {
        let moved = |axis: usize| f64::from(vertex[axis].0[candidate.lane as usize]) - f64::from(ray.origin[axis]);
        *depth = moved(z);
        *corner = DVec2::new(moved(x), moved(y)) - shear * *depth;
    }
    let [w, u, v] = weights_at_origin(corners);
    let t = ((w * depths[0] + u * depths[1] + v * depths[2]) * reciprocal) as f32;
    let u = u as f32;
    Hit {
        primitive: candidate.primitive,
        t: if t > 0.0 { t.min(ray.t_max) } else { candidate.t },
        u,
        v: (v as f32).min(1.0 - u),
    }
}

/// Barycentric weights of the origin, or of the outline's nearest point if the origin lies outside or on an edge.
#[inline(always)]
fn weights_at_origin(corners: [DVec2; 3]) -> [f64; 3] {
    let [a, b, c] = corners;
    let (u, v, w) = (b.perp_dot(c), c.perp_dot(a), a.perp_dot(b));
    if u.min(v).min(w) > 0.0 || u.max(v).max(w) < 0.0 {
        let scale = 1.0 / (u + v + w);
        return [u * scale, v * scale, w * scale];
    }
    nearest_on_outline(corners)
}

/// Barycentric weights of the outline's point nearest to the origin.
#[cold]
fn nearest_on_outline(corners: [DVec2; 3]) -> [f64; 3] {
    let mut nearest = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let edge = corners[j] - corners[i];
        // An edge without length gives NaN, which is never the nearest.
        let s = (-corners[i].dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        let distance = (corners[i] + s * edge).length_squared();
        if distance < nearest.0 {
            nearest = (distance, [0.0; 3]);
            (nearest.1[i], nearest.1[j]) = (1.0 - s, s);
        }
    }
    nearest.1
}
