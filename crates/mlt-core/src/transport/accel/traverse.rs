//! Walking the 8-wide tree.
//!
//! Both queries are one generic function each, for both instruction sets and for whatever the leaves hold. At each level the
//! nearest-hit query keeps a key for every box that the ray meets: its distance, with the lane in the last bits. The next box is
//! the one with the least key, found without a branch; one that lies beyond a hit ends the level. It is found before the box ahead of it is visited,
//! so that its memory can be asked for early where the tree is large. The any-hit query takes boxes as they come and stops
//! at the first hit. Plain trees, without coarse triangles and not very deep, are walked by code that knows of no others.
//!
//! **What is unsafe** here is to call code compiled for AVX2. Indices are checked: measured, that costs less than one per cent.
#![allow(unsafe_code, reason = "calls of code compiled for AVX2")]

use super::boxes::BoxTest;
use super::segment::Segment;
use super::simd::{KEY_LANE, Simd};
use super::stack::Stack;
use super::watertight::{Nearest, Shear, Test};
use super::wide::{Child, Node, TriangleBlock, WideTree};
use crate::instructions::{InstructionSet, Portable};
use crate::transport::geometry::{Hit, Ray};
use glam::Vec3A;

/// A structure that rays can walk.
pub(super) trait Structure: Copy {
    /// The nearest hit of a sound ray.
    fn nearest<S: Simd>(self, simd: S, ray: &Segment) -> Option<Hit>;
    /// Whether anything is hit by a sound ray.
    fn any<S: Simd>(self, simd: S, ray: &Segment) -> bool;
}

/// The leaves of a tree, as one ray meets them.
pub(super) trait Leaves<S: Simd> {
    /// Ray parameter of the nearest hit so far; of none: the ray's end.
    fn t(&self) -> f32;
    /// Takes over the nearest hit in a leaf if it is nearer.
    fn look(&mut self, simd: S, leaf: Child);
    /// Whether anything in a leaf is hit.
    fn any(&self, simd: S, leaf: Child) -> bool;
}

/// One query, compiled for an instruction set and for a structure. Rays travel in seven registers: through memory, what is written
/// one number at a time and read several at once has to be waited for.
macro_rules! query {
    ($query:ident -> $answer:ty, $walk:ident, $scaled:ident, $portable:ident, $avx2:ident) => {
        #[inline(always)]
        pub(super) fn $query<T: Structure>(instructions: InstructionSet, structure: T, ray: &Ray) -> $answer {
            let Ray { origin: o, direction: d, t_max } = *ray;
            match instructions {
                InstructionSet::Portable(simd) => $portable(simd, structure, o.x, o.y, o.z, d.x, d.y, d.z, t_max),
                #[cfg(target_arch = "x86_64")]
                // SAFETY: a value of `Avx2` exists only where the processor has all the features that are enabled.
                InstructionSet::Avx2(simd) => unsafe { $avx2(simd, structure, o.x, o.y, o.z, d.x, d.y, d.z, t_max) },
            }
        }

        query!(fn $portable(Portable) -> $answer, $walk, $scaled, #[inline(never)]);

        #[cfg(target_arch = "x86_64")]
        query!(
            fn $avx2(crate::instructions::Avx2) -> $answer, $walk, $scaled,
            #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        );
    };
    (fn $name:ident($set:ty) -> $answer:ty, $walk:ident, $scaled:ident, $(#[$attribute:meta])*) => {
        $(#[$attribute])*
        #[allow(clippy::too_many_arguments, reason = "the ray travels in registers")]
        fn $name<T: Structure>(
            simd: $set, structure: T, ox: f32, oy: f32, oz: f32, dx: f32, dy: f32, dz: f32, t_max: f32,
        ) -> $answer {
            let ray = Segment { origin: Vec3A::new(ox, oy, oz), direction: Vec3A::new(dx, dy, dz), t_max };
            // What is infinitely far is not hit.
            let finite = Segment { t_max: t_max.min(f32::MAX), ..ray };
            if ray.is_sound() {
                structure.$walk(simd, &finite)
            } else {
                $scaled(simd, structure, ray)
            }
        }
    };
}

query!(closest -> Option<Hit>, nearest, nearest_scaled, closest_portable, closest_avx2);
query!(occluded -> bool, any, any_scaled, occluded_portable, occluded_avx2);

/// Takes the ray by value: a reference would keep it out of registers.
#[cold]
fn nearest_scaled<S: Simd, T: Structure>(simd: S, structure: T, ray: Segment) -> Option<Hit> {
    let (ray, unit) = ray.scaled()?;
    let hit = closest(simd.set(), structure, &ray.into())?;
    Some(Hit { t: (f64::from(hit.t) * unit) as f32, ..hit })
}

#[cold]
fn any_scaled<S: Simd, T: Structure>(simd: S, structure: T, ray: Segment) -> bool {
    ray.scaled().is_some_and(|(ray, _)| occluded(simd.set(), structure, &ray.into()))
}

/// Boxes of a node that are still to be visited.
#[derive(Clone, Copy)]
struct Level<'a, K> {
    /// Of the node's boxes.
    keys: K,
    /// The least of them.
    key: u32,
    /// Boxes, a bit each.
    left: u32,
    node: &'a Node,
}

impl<'a, K: Copy> Level<'a, K> {
    /// The boxes of a node that the ray meets with 0 ≤ t ≤ t_max.
    #[inline(always)]
    fn enter<S: Simd<Keys = K>>(simd: S, boxes: &BoxTest<S>, node: &'a Node, t_max: f32) -> Self {
        let (mask, distances) = boxes.test(simd, node, t_max);
        let keys = simd.keys(distances, mask);
        Self { keys, key: simd.least(keys), left: simd.bits(mask), node }
    }
}

/// Shows the leaves that a ray meets to `leaves`, the nearer ones first, as far as they can hold a nearer hit. `LOCAL`: whether the stack
/// needs no memory from the heap.
#[inline(always)]
pub(super) fn nearest_hit<S: Simd, const LOCAL: bool>(
    simd: S,
    tree: &WideTree,
    ray: &Segment,
    leaves: &mut impl Leaves<S>,
) {
    let boxes = BoxTest::new(simd, ray, tree.max_coordinate);
    let mut stack = Stack::<_, LOCAL>::new(tree.depth);
    let mut level = Level::enter(simd, &boxes, &tree.nodes[0], ray.t_max);
    loop {
        let key = level.key;
        if key & !KEY_LANE > leaves.t().to_bits() {
            match stack.pop() {
                Some(above) => level = above,
                None => return,
            }
            continue;
        }
        let lane = key & KEY_LANE;
        level.keys = simd.without(level.keys, key);
        level.key = simd.least(level.keys);
        level.left &= !(1 << lane);
        if tree.is_large {
            tree.prefetch(simd, level.node.children[(level.key & KEY_LANE) as usize]);
        }
        let child = level.node.children[lane as usize];
        if child.is_leaf() {
            leaves.look(simd, child);
        } else {
            if level.left != 0 {
                stack.push(level);
            }
            level = Level::enter(simd, &boxes, &tree.nodes[child.node()], leaves.t());
        }
    }
}

impl WideTree {
    /// Asks for what a box holds, ahead of its use.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, child: Child) {
        if child.is_leaf() {
            simd.prefetch(self.blocks.as_ptr().wrapping_add(child.first_block()));
        } else {
            simd.prefetch(self.nodes.as_ptr().wrapping_add(child.node()));
        }
    }
}

/// Whether one of `leaves` that a ray meets is hit; `LOCAL` as above.
#[inline(always)]
pub(super) fn any_hit<S: Simd, const LOCAL: bool>(
    simd: S,
    tree: &WideTree,
    ray: &Segment,
    leaves: &impl Leaves<S>,
) -> bool {
    let boxes = BoxTest::new(simd, ray, tree.max_coordinate);
    let mut stack = Stack::<_, LOCAL>::new(tree.depth);
    let mut node = &tree.nodes[0];
    let mut left = simd.bits(boxes.test(simd, node, ray.t_max).0);
    loop {
        if left == 0 {
            match stack.pop() {
                Some(above) => (node, left) = above,
                None => return false,
            }
        }
        let lane = left.trailing_zeros() as usize & 7;
        left &= left - 1;
        let child = node.children[lane];
        if child.is_leaf() {
            if leaves.any(simd, child) {
                return true;
            }
        } else {
            if left != 0 {
                stack.push((node, left));
            }
            node = &tree.nodes[child.node()];
            left = simd.bits(boxes.test(simd, node, ray.t_max).0);
        }
    }
}

/// A tree over triangles: a plain one, or any.
#[derive(Clone, Copy)]
pub(super) struct Triangles<'a, const PLAIN: bool>(pub &'a WideTree);

impl<const PLAIN: bool> Structure for Triangles<'_, PLAIN> {
    #[inline(always)]
    fn nearest<S: Simd>(self, simd: S, ray: &Segment) -> Option<Hit> {
        let mut blocks = Blocks::<S, PLAIN>::new(simd, self.0, ray);
        nearest_hit::<_, PLAIN>(simd, self.0, ray, &mut blocks);
        blocks.nearest.hit(&self.0.blocks, [ray.origin, ray.direction], ray.t_max)
    }

    #[inline(always)]
    fn any<S: Simd>(self, simd: S, ray: &Segment) -> bool {
        any_hit::<_, PLAIN>(simd, self.0, ray, &Blocks::<S, PLAIN>::new(simd, self.0, ray))
    }
}

/// Blocks of triangles, for one ray.
struct Blocks<'a, S: Simd, const PLAIN: bool> {
    tree: &'a WideTree,
    ray: &'a Segment,
    shear: Shear<S>,
    nearest: Nearest,
}

impl<'a, S: Simd, const PLAIN: bool> Blocks<'a, S, PLAIN> {
    #[inline(always)]
    fn new(simd: S, tree: &'a WideTree, ray: &'a Segment) -> Self {
        Self { tree, ray, shear: Shear::new(simd, ray.origin, ray.direction), nearest: Nearest::none(ray.t_max) }
    }

    /// The hits up to `t_max` in one of a leaf's blocks.
    #[inline(always)]
    fn test(&self, simd: S, leaf: Child, block: &TriangleBlock, t_max: f32) -> Option<Test<S>> {
        match !PLAIN && leaf.is_coarse() {
            true => self.shear.test_coarse(simd, block, *self.ray, t_max),
            false => self.shear.test(simd, block, [0.0, t_max]),
        }
    }
}

impl<S: Simd, const PLAIN: bool> Leaves<S> for Blocks<'_, S, PLAIN> {
    #[inline(always)]
    fn t(&self) -> f32 {
        self.nearest.t
    }

    #[inline(always)]
    fn look(&mut self, simd: S, leaf: Child) {
        for index in leaf.blocks() {
            let block = &self.tree.blocks[index];
            if let Some(test) = self.test(simd, leaf, block, self.nearest.t) {
                self.nearest.update(simd, &test, &block.primitives, index);
            }
        }
    }

    #[inline(always)]
    fn any(&self, simd: S, leaf: Child) -> bool {
        for block in &self.tree.blocks[leaf.blocks()] {
            if self.test(simd, leaf, block, self.ray.t_max).is_some() {
                return true;
            }
        }
        false
    }
}
