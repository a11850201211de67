//! The acceleration structure: which triangle does a ray hit first, does it hit any.
//!
//! Three steps, one file each:
//!
//! * `binary`: a binary tree over the triangles, one to a leaf, is built from clusters (`cluster`) and improved by a library;
//! * `collapse`: dynamic programming folds it into the cheapest 8-wide tree (`wide` is its layout);
//! * `traverse`: a ray (`segment`) walks that tree, eight boxes or eight triangles at a time (`boxes` tests the boxes, `stack` keeps those
//!   that are left, `simd` is the arithmetic, `watertight` the triangle test and the accurate hit, `coarse` the same for triangles
//!   of a very different size);
//! * `instances`: a tree of the same kind over copies of shapes, which share the shapes' trees.
//!
//! Callers may rely on this:
//!
//! * a ray that starts inside a closed mesh does not leak through its edges or vertices;
//! * the same query gives the same bits on every machine and every number of threads: the vector code and its
//!   portable twin are one generic function with the same rounding steps;
//! * of two triangles at exactly the same t, the one with the smaller index wins.

mod binary;
mod boxes;
mod cluster;
mod coarse;
mod collapse;
mod instances;
mod segment;
mod simd;
mod stack;
mod traverse;
mod watertight;
mod wide;

#[cfg(test)]
mod tests;

pub use coarse::{COARSE, coarse_size, size};
pub(crate) use instances::Copies;
pub use instances::Instance;

use crate::instructions::InstructionSet;
use crate::transport::geometry::{Hit, Ray};
use glam::Vec3;
use instances::Instances;
use traverse::{Triangles, closest, occluded};
use wide::WideTree;

/// How long to build for; a better tree makes every ray faster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quality {
    /// For previews: the quickest build, rays 20–80 % slower than `Medium`.
    Fast,
    /// The default.
    #[default]
    Medium,
    /// For long renders: about six times the build, rays a few per cent faster.
    High,
}

/// Triangles, and copies of shapes, in a bounding-volume hierarchy.
#[derive(Debug)]
pub struct Accel {
    tree: WideTree,
    kind: Kind,
    /// Number of triangles, those of copies left out.
    count: u32,
    instances: Option<Instances>,
    instructions: InstructionSet,
}

/// Contents of a structure.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Triangles in a plain tree.
    Plain,
    /// Triangles in any tree.
    Any,
    /// Copies of shapes, too.
    Instances,
}

impl Accel {
    /// Builds over `triangles` with medium quality; see [`Accel::with_quality`].
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        Self::with_quality(triangles, Quality::default())
    }

    /// Builds over `triangles`; empty input is a structure that nothing hits.
    ///
    /// Triangles with a NaN, an infinity or a coordinate beyond ±10¹⁸ are left out. Of triangles with the same three
    /// vertices, in any order, only the first can be hit. Takes n log n time.
    pub fn with_quality(triangles: &[[Vec3; 3]], quality: Quality) -> Self {
        let indices = binary::usable(triangles);
        let nodes = binary::build(triangles, &indices, quality);
        let tree = collapse::collapse(&nodes, triangles, coarse_size(triangles));
        let kind = if tree.is_plain { Kind::Plain } else { Kind::Any };
        Self { tree, kind, count: triangles.len() as u32, instances: None, instructions: InstructionSet::detect() }
    }

    /// With copies of shapes, whose triangles' indices follow those of the triangles, copy by copy.
    pub(crate) fn with_copies(self, copies: Copies) -> Self {
        if copies.places.is_empty() {
            return self;
        }
        let instances = Some(Instances::new(copies, self.count));
        Self { kind: Kind::Instances, instances, ..self }
    }

    /// The copy that a triangle of this index is in; `None`: it is in none.
    pub fn instance(&self, primitive: u32) -> Option<Instance<'_>> {
        self.instances.as_ref().filter(|_| primitive >= self.count).map(|instances| instances.find(primitive))
    }

    /// Memory that it takes, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.tree.bytes() + self.instances.as_ref().map_or(0, Instances::bytes)
    }

    /// The nearest hit with 0 < t ≤ t_max.
    ///
    /// The test rounds: from an origin on a triangle its t can come out as a tiny positive number instead of zero.
    /// None, too, for a ray with a zero or non-finite direction, or an origin that is not finite or beyond ±10¹⁸.
    #[inline(always)]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self.kind {
            Kind::Plain => closest(self.instructions, Triangles::<true>(&self.tree), ray),
            Kind::Any => closest(self.instructions, Triangles::<false>(&self.tree), ray),
            Kind::Instances => self.closest_of_all(*ray),
        }
    }

    /// Whether anything lies in 0 < t ≤ t_max; the same answer as `closest(ray).is_some()`, sooner.
    #[inline(always)]
    pub fn occluded(&self, ray: &Ray) -> bool {
        match self.kind {
            Kind::Plain => occluded(self.instructions, Triangles::<true>(&self.tree), ray),
            Kind::Any => occluded(self.instructions, Triangles::<false>(&self.tree), ray),
            Kind::Instances => self.is_any_hit(*ray),
        }
    }

    /// The nearest hit among the triangles and the copies. Takes the ray by value: a reference would keep it out of registers.
    #[inline(never)]
    fn closest_of_all(&self, ray: Ray) -> Option<Hit> {
        let own = closest(self.instructions, Triangles::<false>(&self.tree), &ray);
        let nearer = Ray { t_max: own.map_or(ray.t_max, |hit| hit.t), ..ray };
        let copy = self.instances.as_ref().and_then(|copies| closest(self.instructions, copies, &nearer));
        match (own, copy) {
            (Some(own), Some(copy)) if copy.t >= own.t => Some(own),
            (own, copy) => copy.or(own),
        }
    }

    /// Whether the triangles or the copies are hit.
    #[inline(never)]
    fn is_any_hit(&self, ray: Ray) -> bool {
        occluded(self.instructions, Triangles::<false>(&self.tree), &ray)
            || self.instances.as_ref().is_some_and(|copies| occluded(self.instructions, copies, &ray))
    }
}
