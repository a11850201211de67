//! The binary tree: clusters, whose nodes obvhs then moves to where they cost least.

use super::Quality;
use super::cluster::{Search, cluster};
use glam::{Vec3, Vec3A};
use obvhs::{aabb::Aabb, bvh2::reinsertion::ReinsertionOptimizer};
use rayon::prelude::*;

/// Largest usable coordinate: products of two differences still fit into an f32.
pub(super) const MAX_COORDINATE: f32 = 1e18;

/// A node of the binary tree; index 0 is the root.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    /// Smallest corner of the bounding box.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
    /// The content.
    pub content: Content,
}

/// Content of a binary node.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// One triangle or copy, as an index into the caller's array.
    Leaf(u32),
    /// Two nodes, at this index and the next.
    Children(u32),
}

impl BinaryNode {
    /// Half the surface of the box, to which the chance that a random ray meets it is proportional.
    pub(super) fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// Indices, ascending, of the triangles that can be hit: finite, and the first of those with the same three vertices.
///
/// Leaving out repeats changes no answer, for the smaller index wins a tie; it spares the builder a pile of boxes
/// that no plane separates, on which it takes quadratic time.
pub(super) fn usable(triangles: &[[Vec3; 3]]) -> Vec<u32> {
    let in_range = |t: &[Vec3; 3]| t.iter().all(|v| v.abs().cmple(Vec3::splat(MAX_COORDINATE)).all());
    let key = |t: &[Vec3; 3]| hash(&vertex_set(t));
    let mut keyed: Vec<_> =
        triangles.par_iter().enumerate().filter(|(_, t)| in_range(t)).map(|(i, t)| (key(t), i as u32)).collect();
    keyed.par_sort_unstable();
    let mut indices = Vec::with_capacity(keyed.len());
    for same in keyed.chunk_by(|a, b| a.0 == b.0) {
        match same {
            &[(_, alone)] => indices.push(alone),
            _ => indices.extend(first_of_repeats(triangles, same)),
        }
    }
    indices.par_sort_unstable();
    indices
}

/// Of the triangles that have the same hash, the first with each set of vertices.
fn first_of_repeats(triangles: &[[Vec3; 3]], keyed: &[(u64, u32)]) -> impl Iterator<Item = u32> {
    let mut sets: Vec<_> = keyed.iter().map(|&(_, i)| (vertex_set(&triangles[i as usize]), i)).collect();
    sets.sort_unstable();
    sets.dedup_by_key(|(set, _)| *set);
    sets.into_iter().map(|(_, index)| index)
}

/// The vertices' bits in an order of their own, so that equal sets have equal bits; adding zero makes −0 a +0.
fn vertex_set(triangle: &[Vec3; 3]) -> [[u32; 3]; 3] {
    let mut key = triangle.map(|v| (v + Vec3::ZERO).to_array().map(f32::to_bits));
    key.sort_unstable();
    key
}

/// Seldom the same for different sets.
fn hash(set: &[[u32; 3]; 3]) -> u64 {
    let mix = |hash: u64, &bits: &u32| (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    set.iter().flatten().fold(0, mix)
}

/// Half areas of leaves, in those of the root, beyond which no node is moved: so many boxes lie one in the other that each
/// move would be compared with most others.
const CROWDED: f32 = 1024.0;

fn bounds(triangle: &[Vec3; 3]) -> Aabb {
    let [a, b, c] = triangle.map(Vec3A::from);
    Aabb { min: a.min(b).min(c), max: a.max(b).max(c) }
}

fn is_crowded(boxes: &[Aabb]) -> bool {
    let (whole, areas) =
        boxes.iter().fold((Aabb::empty(), 0.0), |(whole, areas), b| (whole.union(b), areas + b.half_area()));
    areas > CROWDED * whole.half_area()
}

/// A binary tree over the triangles that `indices` names; empty if it names none.
pub(super) fn build(triangles: &[[Vec3; 3]], indices: &[u32], quality: Quality) -> Vec<BinaryNode> {
    let boxes: Vec<_> = indices.par_iter().map(|&i| bounds(&triangles[i as usize])).collect();
    over_boxes(&boxes, indices, quality)
}

/// A binary tree over boxes of what `indices` names.
///
/// Source of the moves: [MeisterBittner18a].
pub(super) fn over_boxes(boxes: &[Aabb], indices: &[u32], quality: Quality) -> Vec<BinaryNode> {
    let (reach, short_passes, moved) = match quality {
        Quality::Fast => (1, 0, 0.0),
        Quality::Medium => (14, 3, 0.05),
        Quality::High => (14, 1, 1.0),
    };
    let search = Search { reach, short_passes, precise: quality == Quality::High };
    let (mut bvh, stalled) = cluster(boxes, search);
    if moved > 0.0 && !stalled && !is_crowded(boxes) {
        let mut optimizer = ReinsertionOptimizer::default();
        optimizer.run(&mut bvh, moved, None);
        optimizer.run(&mut bvh, if quality == Quality::Medium { 2.0 * moved } else { moved }, None);
    }
    let original = |slot: u32| indices[bvh.primitive_indices[slot as usize] as usize];
    bvh.nodes
        .par_iter()
        .map(|node| BinaryNode {
            min: node.aabb().min.into(),
            max: node.aabb().max.into(),
            content: match node.is_leaf() {
                true => Content::Leaf(original(node.first_index)),
                false => Content::Children(node.first_index),
            },
        })
        .collect()
}
