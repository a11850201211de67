//! The acceleration structure: which triangle does a ray hit first, does it hit any.
//!
//! Three steps, one file each:
//!
//! * `binary`: a binary tree over the triangles, one to a leaf, is built from clusters (`cluster`) and improved by a library;
//! * `collapse`: dynamic programming folds it into the cheapest 8-wide tree (`wide` is its layout);
//! * `traverse`: a ray walks that tree, eight boxes or eight triangles at a time (`boxes` tests the boxes, `stack` keeps those
//!   that are left, `simd` is the arithmetic, `watertight` the triangle test and the accurate hit, `coarse` the same for triangles
//!   of a very different size).
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
mod simd;
mod stack;
mod traverse;
mod watertight;
mod wide;

#[cfg(test)]
mod tests;

pub use coarse::{COARSE, coarse_size, size};

use crate::instructions::InstructionSet;
use crate::transport::geometry::{Hit, Ray};
use glam::Vec3;
use wide::WideTree;

/// How long to build for; a better tree makes every ray faster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// For previews: the quickest build, rays 20–80 % slower than `Medium`.
    Fast,
    /// The default.
    #[default]
    Medium,
    /// For long renders: about six times the build, rays a few per cent faster.
    High,
}

/// Triangles in a bounding-volume hierarchy.
#[derive(Debug)]
pub struct Accel {
    tree: WideTree,
    instructions: InstructionSet,
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
        Self {
            tree: collapse::collapse(&nodes, triangles, coarse_size(triangles)),
            instructions: InstructionSet::detect(),
        }
    }

    /// The nearest hit with 0 < t ≤ t_max.
    ///
    /// The test rounds: from an origin on a triangle its t can come out as a tiny positive number instead of zero.
    /// None, too, for a ray with a zero or non-finite direction, or an origin that is not finite or beyond ±10¹⁸.
    #[inline(always)]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self.tree.has_coarse {
            false => traverse::closest::<false>(self.instructions, &self.tree, ray),
            true => traverse::closest::<true>(self.instructions, &self.tree, ray),
        }
    }

    /// Whether anything lies in 0 < t ≤ t_max; the same answer as `closest(ray).is_some()`, sooner.
    #[inline(always)]
    pub fn occluded(&self, ray: &Ray) -> bool {
        match self.tree.has_coarse {
            false => traverse::occluded::<false>(self.instructions, &self.tree, ray),
            true => traverse::occluded::<true>(self.instructions, &self.tree, ray),
        }
    }
}
