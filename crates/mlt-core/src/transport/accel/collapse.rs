//! From the binary tree to the 8-wide tree of least expected cost.
//!
//! Let A(n) be the half area of node n's box and N(n) its number of triangles. C(n, m) is the least cost of standing for
//! n's subtree by at most m boxes of a wide node above it:
//!
//! ```text
//! leaf(n)   = A(n) · c_block · ⌈N(n) / 8⌉                        if N(n) ≤ 16
//! inner(n)  = A(n) · c_node + min over i + j = 8 of C(left, i) + C(right, j)
//! C(n, 1)   = min(leaf(n), inner(n))
//! C(n, m)   = min(C(n, m − 1), min over i + j = m of C(left, i) + C(right, j))
//! ```
//!
//! Source: [YlitieKarrasLaine17], section 2.1, with blocks of triangles for leaves.

use super::binary::{BinaryNode, Content};
use super::coarse::size;
use super::wide::{Child, Node, TriangleBlock, WIDTH, WideTree};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Cost of testing eight boxes.
const NODE_COST: f32 = 1.0;
/// Cost of testing eight triangles.
const BLOCK_COST: f32 = 0.6;
/// Most triangles in a leaf.
const MAX_LEAF: u32 = 16;

/// How a subtree is best stood for.
#[derive(Clone, Copy, PartialEq)]
enum Choice {
    /// One box: a leaf.
    Leaf,
    /// One box: a wide node, whose boxes are shared out between the two children.
    Inner([u8; 2]),
    /// The children's boxes, this many each.
    Split([u8; 2]),
}

/// Folds the binary tree `binary` over `triangles`.
pub(super) fn collapse(binary: &[BinaryNode], triangles: &[[Vec3; 3]], coarse_size: f32) -> WideTree {
    let is_coarse = |index: u32| size(&triangles[index as usize]) > coarse_size;
    let (nodes, slots, depth) = fold(binary, MAX_LEAF, is_coarse);
    let blocks = slots.par_chunks(WIDTH).map(|primitives| TriangleBlock::new(primitives, triangles)).collect();
    let reach = binary.first().map_or(0.0, |root| root.min.abs().max(root.max.abs()).max_element());
    WideTree::new(nodes, blocks, depth, reach)
}

/// The wide nodes, what the leaves hold, eight places a block of which `u32::MAX` is empty, and the depth of a tree whose leaves hold at
/// most `most`. An empty tree is a root without boxes.
pub(super) fn fold(binary: &[BinaryNode], most: u32, is_coarse: impl Fn(u32) -> bool) -> (Vec<Node>, Vec<u32>, usize) {
    if binary.is_empty() {
        return (vec![Node::EMPTY], Vec::new(), 1);
    }
    let plan = Plan::new(binary, most);
    let folding =
        Folding { binary, plan: &plan, is_coarse, nodes: vec![Node::EMPTY], slots: Vec::new(), below: Vec::new() };
    folding.fold()
}

/// Levels whose two halves are planned in parallel; the rest of a branch is one task.
const PARALLEL_LEVELS: usize = 10;

/// C(n, m) for m from 1 on, and N(n).
#[derive(Clone, Copy)]
struct Costs {
    boxes: [f32; WIDTH - 1],
    triangles: u32,
}

/// The choices for every binary node, eight bytes each: those for at most m boxes are in byte m − 1.
///
/// Byte 0 is the left child's share of a wide node's boxes; 0 is a leaf. Byte m − 1 is the left child's share of m boxes; 0
/// is the same choice as for m − 1. Atomic, so that tasks can write without order: each node is one task's.
struct Plan<'a> {
    binary: &'a [BinaryNode],
    /// Most triangles in a leaf.
    most: u32,
    choices: Vec<AtomicU64>,
}

impl<'a> Plan<'a> {
    /// The least costs and their choices, children before parents.
    fn new(binary: &'a [BinaryNode], most: u32) -> Self {
        let choices = (0..binary.len()).into_par_iter().map(|_| AtomicU64::new(0)).collect();
        let plan = Self { binary, most, choices };
        plan.subtree(0, 0);
        plan
    }

    /// Plans what is at and below `n`, at some depth.
    fn subtree(&self, n: usize, depth: usize) -> Costs {
        match self.binary[n].content {
            Content::Children(first) if depth < PARALLEL_LEVELS => {
                let first = first as usize;
                let (left, right) =
                    rayon::join(|| self.subtree(first, depth + 1), || self.subtree(first + 1, depth + 1));
                self.inner(n, &left, &right)
            }
            _ => self.subtree_in_turn(n),
        }
    }

    /// The same by one task; no recursion, for a tree over bad input can be as deep as it has nodes.
    fn subtree_in_turn(&self, n: usize) -> Costs {
        // (binary node, whether its children are in `planned`)
        let mut pending = vec![(n, false)];
        let mut planned = Vec::new();
        while let Some((n, children_planned)) = pending.pop() {
            match self.binary[n].content {
                Content::Leaf(_) => planned.push(self.triangle(n)),
                Content::Children(first) if !children_planned => {
                    pending.extend([(n, true), (first as usize + 1, false), (first as usize, false)]);
                }
                Content::Children(_) => {
                    let (right, left) = (planned.pop(), planned.pop());
                    planned.extend(left.zip(right).map(|(left, right)| self.inner(n, &left, &right)));
                }
            }
        }
        planned[0]
    }

    fn triangle(&self, n: usize) -> Costs {
        Costs { boxes: [self.binary[n].half_area() * BLOCK_COST; WIDTH - 1], triangles: 1 }
    }

    /// Plans a binary node from its children's costs.
    fn inner(&self, n: usize, left: &Costs, right: &Costs) -> Costs {
        let area = self.binary[n].half_area();
        let triangles = left.triangles + right.triangles;
        let leaf = match triangles <= self.most {
            true => area * BLOCK_COST * triangles.div_ceil(WIDTH as u32) as f32,
            false => f32::INFINITY,
        };
        let (below, share) = best_share(WIDTH, left, right);
        let node = area * NODE_COST + below;
        let mut shares = [0; 8];
        let mut boxes = [leaf; WIDTH - 1];
        if node < leaf || triangles > self.most {
            (boxes[0], shares[0]) = (node, share);
        }
        for m in 2..WIDTH {
            let (cost, share) = best_share(m, left, right);
            boxes[m - 1] = boxes[m - 2];
            if cost < boxes[m - 2] {
                (boxes[m - 1], shares[m - 1]) = (cost, share);
            }
        }
        self.choices[n].store(u64::from_le_bytes(shares), Relaxed);
        Costs { boxes, triangles }
    }

    /// How `n` is best stood for by at most `m` boxes.
    fn choice(&self, n: usize, m: u8) -> Choice {
        let shares = self.choices[n].load(Relaxed).to_le_bytes();
        match (1..m).rev().find(|&i| shares[i as usize] != 0) {
            Some(i) => Choice::Split([shares[i as usize], i + 1 - shares[i as usize]]),
            None if shares[0] == 0 => Choice::Leaf,
            None => Choice::Inner([shares[0], WIDTH as u8 - shares[0]]),
        }
    }
}

/// The least C(left, i) + C(right, j) over i + j = m, and i.
fn best_share(m: usize, left: &Costs, right: &Costs) -> (f32, u8) {
    let mut best = (f32::INFINITY, 1);
    for i in 1..m {
        let cost = left.boxes[i - 1] + right.boxes[m - i - 1];
        if cost < best.0 {
            best = (cost, i as u8);
        }
    }
    best
}

/// A wide tree in the making.
struct Folding<'a, F> {
    binary: &'a [BinaryNode],
    plan: &'a Plan<'a>,
    is_coarse: F,
    nodes: Vec<Node>,
    /// Triangles of the blocks, eight each; `u32::MAX`: none.
    slots: Vec<u32>,
    /// For the walk below a leaf.
    below: Vec<usize>,
}

impl<F: Fn(u32) -> bool> Folding<'_, F> {
    /// Fills the tree from the root down, depth first; returns its nodes, the triangles of its blocks, and its depth.
    fn fold(mut self) -> (Vec<Node>, Vec<u32>, usize) {
        // (wide node to fill, binary node that it stands for, depth)
        let mut pending = vec![(0, 0, 1)];
        let mut max_depth = 0;
        while let Some((wide, n, depth)) = pending.pop() {
            max_depth = max_depth.max(depth);
            for (lane, (child, choice)) in self.boxes(n).into_iter().enumerate() {
                let BinaryNode { min, max, .. } = self.binary[child];
                let target = if choice == Choice::Leaf {
                    self.leaf(child)
                } else {
                    pending.push((self.nodes.len(), child, depth + 1));
                    self.nodes.push(Node::EMPTY);
                    Child::inner(self.nodes.len() - 1)
                };
                self.nodes[wide].set(lane, min, max, target);
            }
        }
        (self.nodes, self.slots, max_depth)
    }

    /// The binary nodes that become the boxes of the wide node for `n`, each with its choice.
    fn boxes(&self, n: usize) -> Vec<(usize, Choice)> {
        let Choice::Inner(shares) = self.plan.choice(n, 1) else {
            return vec![(n, Choice::Leaf)]; // the whole tree is one leaf
        };
        let mut boxes = Vec::with_capacity(WIDTH);
        let mut split = vec![(n, shares)];
        while let Some((n, shares)) = split.pop() {
            let Content::Children(first) = self.binary[n].content else { continue };
            for (child, share) in [(first as usize, shares[0]), (first as usize + 1, shares[1])] {
                match self.plan.choice(child, share) {
                    Choice::Split(shares) => split.push((child, shares)),
                    choice => boxes.push((child, choice)),
                }
            }
        }
        boxes
    }

    /// Appends the triangles below `n` as blocks.
    fn leaf(&mut self, n: usize) -> Child {
        let first = self.slots.len();
        self.below.push(n);
        while let Some(n) = self.below.pop() {
            match self.binary[n].content {
                Content::Leaf(index) => self.slots.push(index),
                Content::Children(first) => self.below.extend([first as usize, first as usize + 1]),
            }
        }
        let coarse = self.slots[first..].iter().any(|&index| (self.is_coarse)(index));
        self.slots[first..].sort_unstable();
        self.slots.resize(self.slots.len().next_multiple_of(WIDTH), u32::MAX);
        Child::leaf(first / WIDTH, (self.slots.len() - first) / WIDTH, coarse)
    }
}
