//! Walking the 8-wide tree.
//!
//! One generic walk serves both queries and both instruction sets. The nearest-hit query goes into the nearest box
//! first and keeps the others on a stack, sorted, with their distances, so that those beyond a hit are dropped unseen.
//! The any-hit query sorts nothing and stops at the first hit.
//!
//! **No box is missed.** Let ε = 2⁻²⁴ and M the largest absolute coordinate of the scene and the ray's origin. The
//! triangle test sees vertices displaced by at most 10 εM, and the box test's numerators are off by at most 4 εM, so every
//! box is widened by 16 εM. The quotients have relative errors of at most 2 ε each; the far ones are multiplied by
//! 1 + 8 ε. The widening is folded into the ray, once, and costs nothing a box.
//!
//! **What is unsafe** is to call code compiled for AVX2, and to leave the stack's array uninitialised (it is longer than
//! most walks are). Indices are checked: measured, that costs less than one per cent.
#![allow(unsafe_code)]

use super::super::ray::Ray;
use super::binary::MAX_COORDINATE;
use super::simd::{InstructionSet, Lanes, Portable, Simd, prefetch, splat3};
use super::watertight::Shear;
use super::wide::{Child, Node, WideTree};
use glam::Vec3;
use std::mem::MaybeUninit;

/// A triangle that the ray hits, before refinement.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Ray parameter to the precision of the test.
    pub t: f32,
    /// Index in the caller's array; `u32::MAX`: none yet.
    pub primitive: u32,
    /// Where the tree keeps it.
    pub block: u32,
    /// Its lane in that block.
    pub lane: u32,
}

/// The nearest triangle.
pub fn closest(instructions: InstructionSet, tree: &WideTree, ray: &Ray) -> Option<Candidate> {
    let (ray, unit) = normalised(ray)?;
    let hit = dispatch::<false>(instructions, tree, &ray)?;
    Some(Candidate { t: (f64::from(hit.t) * unit) as f32, ..hit })
}

/// Whether any triangle is hit.
pub fn occluded(instructions: InstructionSet, tree: &WideTree, ray: &Ray) -> bool {
    normalised(ray).is_some_and(|(ray, _)| dispatch::<true>(instructions, tree, &ray).is_some())
}

/// The ray with a direction of moderate length, and its t in units of the given ray's; none if it can hit nothing.
#[inline(always)]
fn normalised(ray: &Ray) -> Option<(Ray, f64)> {
    let length = ray.direction.abs().max_element();
    let sound = ray.origin.abs().cmple(Vec3::splat(MAX_COORDINATE)).all() && ray.direction.is_finite();
    if !(sound && length > 0.0 && ray.t_max > 0.0) {
        return None;
    }
    if (1e-6..=1e6).contains(&length) {
        return Some((*ray, 1.0));
    }
    // A power of two: the scaled ray is the same ray.
    let unit = libm::exp2(-libm::floor(libm::log2(f64::from(length))));
    let direction = (ray.direction.as_dvec3() * unit).as_vec3();
    Some((Ray { direction, t_max: (f64::from(ray.t_max) / unit) as f32, ..*ray }, unit))
}

#[inline(always)]
fn dispatch<const ANY: bool>(instructions: InstructionSet, tree: &WideTree, ray: &Ray) -> Option<Candidate> {
    match instructions {
        InstructionSet::Portable(simd) => walk_portable::<ANY>(simd, tree, ray),
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a value of `Avx2` exists only where the processor has all the features that the function enables.
        InstructionSet::Avx2(simd) => unsafe { walk_avx2::<ANY>(simd, tree, ray) },
    }
}

#[inline(never)]
fn walk_portable<const ANY: bool>(simd: Portable, tree: &WideTree, ray: &Ray) -> Option<Candidate> {
    walk::<_, ANY>(simd, tree, ray)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn walk_avx2<const ANY: bool>(simd: super::simd::Avx2, tree: &WideTree, ray: &Ray) -> Option<Candidate> {
    walk::<_, ANY>(simd, tree, ray)
}

/// The nearest candidate, or with `ANY` the first that turns up.
#[inline(always)]
fn walk<S: Simd, const ANY: bool>(simd: S, tree: &WideTree, ray: &Ray) -> Option<Candidate> {
    let mut local = LocalStack([MaybeUninit::uninit(); LOCAL_STACK]);
    let mut heap;
    let entries = if tree.stack_size <= LOCAL_STACK {
        &mut local.0[..]
    } else {
        heap = vec![MaybeUninit::uninit(); tree.stack_size];
        &mut heap[..]
    };
    walk_with::<S, ANY>(simd, tree, ray, Stack { entries, len: 0 })
}

#[inline(always)]
fn walk_with<S: Simd, const ANY: bool>(simd: S, tree: &WideTree, ray: &Ray, mut stack: Stack) -> Option<Candidate> {
    let boxes = BoxTest::new(simd, ray, tree.max_coordinate);
    let shear = Shear::new(simd, ray.origin, ray.direction);
    let mut best = Candidate { t: ray.t_max, primitive: u32::MAX, block: 0, lane: 0 };
    let mut current = Child::inner(0);
    loop {
        if current.is_leaf() {
            for index in current.blocks() {
                let block = &tree.blocks[index];
                let (hits, t) = shear.test(simd, block, best.t);
                if hits != 0 {
                    best.update(hits, &simd.store(t), &block.primitives, index);
                    if ANY {
                        return Some(best);
                    }
                }
            }
        } else {
            let node = &tree.nodes[current.node()];
            let (hits, distances) = boxes.test(simd, node, best.t);
            if hits != 0 {
                current = match ANY {
                    true => stack.push_unsorted(hits, node),
                    false => stack.push_sorted(hits, &simd.store(distances), node, tree),
                };
                continue;
            }
        }
        match stack.pop_until(best.t) {
            Some(next) => current = next,
            None => return (best.primitive != u32::MAX).then_some(best),
        }
    }
}

impl Candidate {
    /// Takes over the nearest of the hit lanes; of equals, the one that came first in the caller's array.
    #[inline(always)]
    fn update(&mut self, mut hits: u32, t: &Lanes, primitives: &[u32; 8], block: usize) {
        while hits != 0 {
            let lane = next_lane(&mut hits);
            let (t, primitive) = (t.0[lane], primitives[lane]);
            if t < self.t || (t == self.t && primitive < self.primitive) {
                *self = Self { t, primitive, block: block as u32, lane: lane as u32 };
            }
        }
    }
}

/// Takes the lowest set bit.
#[inline(always)]
fn next_lane(bits: &mut u32) -> usize {
    let lane = bits.trailing_zeros() as usize & 7;
    *bits &= *bits - 1;
    lane
}

/// 16 ε of the module's comment, ε = 2⁻²⁴.
const WIDENING: f32 = 16.0 / 16_777_216.0;
/// 1 + 8 ε.
const FAR_FACTOR: f32 = 1.0 + 8.0 / 16_777_216.0;

/// The ray, made ready for boxes: the plane at p is met at t = p · reciprocal − shift.
struct BoxTest<S: Simd> {
    near_plane: [usize; 3],
    near_reciprocal: [S::Floats; 3],
    near_shift: [S::Floats; 3],
    far_reciprocal: [S::Floats; 3],
    far_shift: [S::Floats; 3],
}

impl<S: Simd> BoxTest<S> {
    #[inline(always)]
    fn new(simd: S, ray: &Ray, scene_coordinate: f32) -> Self {
        let widening = Vec3::splat(WIDENING * scene_coordinate.max(ray.origin.abs().max_element()));
        // A slower component moves the ray by less than the widening before it has left the scene.
        let least = Vec3::splat(1e-12 * ray.direction.abs().max_element());
        let reciprocal =
            1.0 / Vec3::select(ray.direction.abs().cmplt(least), least.copysign(ray.direction), ray.direction);
        let widening = widening.copysign(reciprocal);
        let backwards = |axis: usize| usize::from(reciprocal[axis] < 0.0);
        Self {
            near_plane: [backwards(0), 2 + backwards(1), 4 + backwards(2)],
            near_reciprocal: splat3(simd, reciprocal.to_array()),
            near_shift: splat3(simd, ((ray.origin + widening) * reciprocal).to_array()),
            far_reciprocal: splat3(simd, (reciprocal * FAR_FACTOR).to_array()),
            far_shift: splat3(simd, ((ray.origin - widening) * reciprocal * FAR_FACTOR).to_array()),
        }
    }

    /// Which boxes the ray meets with 0 ≤ t ≤ t_max (a bit each), and where it enters them.
    #[inline(always)]
    fn test(&self, simd: S, node: &Node, t_max: f32) -> (u32, S::Floats) {
        let near = |axis: usize| {
            let plane = simd.load(&node.planes[self.near_plane[axis]]);
            simd.mul_sub(plane, self.near_reciprocal[axis], self.near_shift[axis])
        };
        let far = |axis: usize| {
            let plane = simd.load(&node.planes[self.near_plane[axis] ^ 1]);
            simd.mul_sub(plane, self.far_reciprocal[axis], self.far_shift[axis])
        };
        let enter = simd.max(simd.max(near(0), near(1)), simd.max(near(2), simd.splat(0.0)));
        let leave = simd.min(simd.min(far(0), simd.min(far(1), far(2))), simd.splat(t_max));
        (simd.bits(simd.le(enter, leave)), enter)
    }
}

/// Room for a tree 36 levels deep.
const LOCAL_STACK: usize = 256;

#[repr(align(64))]
struct LocalStack([MaybeUninit<u64>; LOCAL_STACK]);

/// What is still to visit: distance in the upper half, child in the lower. Distances are not negative, so their bits
/// order as they do.
struct Stack<'a> {
    /// The first `len` are initialised.
    entries: &'a mut [MaybeUninit<u64>],
    len: usize,
}

impl Stack<'_> {
    #[inline(always)]
    fn push(&mut self, entry: u64) {
        self.entries[self.len].write(entry);
        self.len += 1;
    }

    #[inline(always)]
    fn get(&self, index: usize) -> u64 {
        debug_assert!(index < self.len);
        // SAFETY: every caller asks below `len`, and `push` has written all of those.
        unsafe { self.entries[index].assume_init() }
    }

    /// Takes the last entry that starts within `t_max`, dropping those that do not.
    #[inline(always)]
    fn pop_until(&mut self, t_max: f32) -> Option<Child> {
        while self.len > 0 {
            self.len -= 1;
            // SAFETY: it lay below the old `len`.
            let entry = unsafe { self.entries[self.len].assume_init() };
            if f32::from_bits((entry >> 32) as u32) <= t_max {
                return Some(Child(entry as u32));
            }
        }
        None
    }

    /// Pushes all children hit but one, which it returns.
    #[inline(always)]
    fn push_unsorted(&mut self, mut hits: u32, node: &Node) -> Child {
        loop {
            let child = node.children[next_lane(&mut hits)];
            if hits == 0 {
                return child;
            }
            self.push(u64::from(child.0));
        }
    }

    /// Pushes all children hit but the nearest, the farthest first, and returns the nearest.
    #[inline(always)]
    fn push_sorted(&mut self, mut hits: u32, distances: &Lanes, node: &Node, tree: &WideTree) -> Child {
        let mut next = || {
            let lane = next_lane(&mut hits);
            let child = node.children[lane];
            child.prefetch(tree);
            (u64::from(distances.0[lane].to_bits()) << 32 | u64::from(child.0), hits == 0)
        };
        let (mut nearest, mut done) = next();
        let base = self.len;
        while !done {
            let entry;
            (entry, done) = next();
            let farther = entry.max(nearest);
            nearest = entry.min(nearest);
            let mut slot = self.len;
            self.push(farther);
            while slot > base && self.get(slot - 1) < farther {
                self.entries[slot] = self.entries[slot - 1];
                slot -= 1;
            }
            self.entries[slot].write(farther);
        }
        Child(nearest as u32)
    }
}

impl Child {
    /// Brings what it refers to nearer to the processor.
    #[inline(always)]
    fn prefetch(self, tree: &WideTree) {
        match self.is_leaf() {
            true => prefetch(&tree.blocks, self.first_block()),
            false => prefetch(&tree.nodes, self.node()),
        }
    }
}
