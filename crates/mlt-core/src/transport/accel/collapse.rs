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
use super::wide::{Child, Node, TriangleBlock, WIDTH, WideTree};
use glam::Vec3;

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

/// C(n, m) and the choice that reaches it.
#[derive(Clone, Copy)]
struct Plan {
    cost: f32,
    choice: Choice,
}

/// Plans for one binary node: entry m − 1 is for at most m boxes.
type Plans = [Plan; WIDTH - 1];

/// Folds the binary tree `binary` over `triangles`.
pub fn collapse(binary: &[BinaryNode], triangles: &[[Vec3; 3]]) -> WideTree {
    let plans = plan(binary);
    let mut folding = Folding { binary, triangles, plans: &plans, tree: WideTree::empty() };
    if let Some(root) = binary.first() {
        folding.tree.max_coordinate = root.min.abs().max(root.max.abs()).max_element();
        folding.tree.depth = folding.fold();
    }
    folding.tree
}

impl WideTree {
    /// A root without boxes.
    fn empty() -> Self {
        Self { nodes: vec![Node::EMPTY], blocks: Vec::new(), depth: 1, max_coordinate: 0.0 }
    }
}

/// The plans of every binary node, children before parents.
fn plan(binary: &[BinaryNode]) -> Vec<Plans> {
    let mut plans = vec![[Plan { cost: f32::INFINITY, choice: Choice::Leaf }; WIDTH - 1]; binary.len()];
    let mut counts = vec![1u32; binary.len()];
    for &n in parents_first(binary).iter().rev() {
        let area = binary[n].half_area();
        let Content::Children(first) = binary[n].content else {
            plans[n] = [Plan { cost: area * BLOCK_COST, choice: Choice::Leaf }; WIDTH - 1];
            continue;
        };
        let (left, right) = (first as usize, first as usize + 1);
        counts[n] = counts[left] + counts[right];
        let leaf = match counts[n] <= MAX_LEAF {
            true => area * BLOCK_COST * counts[n].div_ceil(WIDTH as u32) as f32,
            false => f32::INFINITY,
        };
        plans[n] = plan_inner(leaf, area * NODE_COST, &plans[left], &plans[right]);
    }
    plans
}

/// Plans of a binary node from its children's.
fn plan_inner(leaf: f32, node: f32, left: &Plans, right: &Plans) -> Plans {
    let (below, shares) = best_shares(WIDTH, left, right);
    let one = match leaf <= node + below {
        true => Plan { cost: leaf, choice: Choice::Leaf },
        false => Plan { cost: node + below, choice: Choice::Inner(shares) },
    };
    let mut plans = [one; WIDTH - 1];
    for m in 2..WIDTH {
        let (cost, shares) = best_shares(m, left, right);
        plans[m - 1] =
            if cost < plans[m - 2].cost { Plan { cost, choice: Choice::Split(shares) } } else { plans[m - 2] };
    }
    plans
}

/// The least C(left, i) + C(right, j) over i + j = m, and (i, j).
fn best_shares(m: usize, left: &Plans, right: &Plans) -> (f32, [u8; 2]) {
    let mut best = (f32::INFINITY, [1, (m - 1) as u8]);
    for i in 1..m {
        let cost = left[i - 1].cost + right[m - i - 1].cost;
        if cost < best.0 {
            best = (cost, [i as u8, (m - i) as u8]);
        }
    }
    best
}

/// All nodes, each after its parent; no recursion, for a tree over bad input can be as deep as it has nodes.
fn parents_first(binary: &[BinaryNode]) -> Vec<usize> {
    let mut order = Vec::with_capacity(binary.len());
    order.extend((!binary.is_empty()).then_some(0));
    let mut next = 0;
    while let Some(&n) = order.get(next) {
        if let Content::Children(first) = binary[n].content {
            order.extend([first as usize, first as usize + 1]);
        }
        next += 1;
    }
    order
}

/// A wide tree in the making.
struct Folding<'a> {
    binary: &'a [BinaryNode],
    triangles: &'a [[Vec3; 3]],
    plans: &'a [Plans],
    tree: WideTree,
}

impl Folding<'_> {
    /// Fills the tree from the root down, depth first; returns its depth.
    fn fold(&mut self) -> usize {
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
                    pending.push((self.tree.nodes.len(), child, depth + 1));
                    self.tree.nodes.push(Node::EMPTY);
                    Child::inner(self.tree.nodes.len() - 1)
                };
                self.tree.nodes[wide].set(lane, min, max, target);
            }
        }
        max_depth
    }

    /// The binary nodes that become the boxes of the wide node for `n`, each with its plan.
    fn boxes(&self, n: usize) -> Vec<(usize, Choice)> {
        let Choice::Inner(shares) = self.plans[n][0].choice else {
            return vec![(n, Choice::Leaf)]; // the whole tree is one leaf
        };
        let mut boxes = Vec::with_capacity(WIDTH);
        let mut split = vec![(n, shares)];
        while let Some((n, shares)) = split.pop() {
            let Content::Children(first) = self.binary[n].content else { continue };
            for (child, share) in [(first as usize, shares[0]), (first as usize + 1, shares[1])] {
                match self.plans[child][share as usize - 1].choice {
                    Choice::Split(shares) => split.push((child, shares)),
                    choice => boxes.push((child, choice)),
                }
            }
        }
        boxes
    }

    /// Appends the triangles below `n` as blocks.
    fn leaf(&mut self, n: usize) -> Child {
        let mut primitives = Vec::with_capacity(MAX_LEAF as usize);
        let mut below = vec![n];
        while let Some(n) = below.pop() {
            match self.binary[n].content {
                Content::Triangle(index) => primitives.push(index),
                Content::Children(first) => below.extend([first as usize, first as usize + 1]),
            }
        }
        primitives.sort_unstable();
        let first = self.tree.blocks.len();
        self.tree.blocks.extend(primitives.chunks(WIDTH).map(|chunk| TriangleBlock::new(chunk, self.triangles)));
        Child::leaf(first, self.tree.blocks.len() - first)
    }
}
