//! Memory layout of the 8-wide tree.

use super::simd::Lanes;
use super::stack::LOCAL_LEVELS;
use glam::Vec3;

/// Boxes in a node, triangles in a block.
pub(super) const WIDTH: usize = 8;

/// Eight boxes and what they hold: four cache lines.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Planes of the boxes: x min, x max, y min, y max, z min, z max. An unused lane is an inside-out box.
    pub planes: [Lanes; 6],
    /// Content of each box.
    pub children: [Child; WIDTH],
}

const _: () = assert!(size_of::<Node>() == 256);

impl Node {
    /// A node with eight unused lanes.
    pub(super) const EMPTY: Self = {
        let (min, max) = (Lanes([f32::INFINITY; WIDTH]), Lanes([f32::NEG_INFINITY; WIDTH]));
        Self { planes: [min, max, min, max, min, max], children: [Child(0); WIDTH] }
    };

    /// Corners of the boxes in use.
    pub(super) fn boxes(&self) -> impl Iterator<Item = [Vec3; 2]> {
        let corner =
            |lane: usize, end: usize| Vec3::from_array([0, 1, 2].map(|axis| self.planes[2 * axis + end].0[lane]));
        let corners = (0..WIDTH).map(move |lane| [corner(lane, 0), corner(lane, 1)]);
        corners.filter(|[min, max]| min.cmple(*max).all())
    }

    /// Puts a box into a lane.
    pub(super) fn set(&mut self, lane: usize, min: Vec3, max: Vec3, child: Child) {
        for axis in 0..3 {
            self.planes[2 * axis].0[lane] = min[axis];
            self.planes[2 * axis + 1].0[lane] = max[axis];
        }
        self.children[lane] = child;
    }
}

/// An inner node (its index), or a leaf: the top bit, the index of its first block × 8, whether it is coarse × 4, its number of
/// blocks − 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Child(pub u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const COARSE: u32 = 1 << 2;

    /// Refers to `nodes[index]`.
    pub(super) fn inner(index: usize) -> Self {
        Self(index as u32)
    }

    /// Refers to `count` ≤ 4 blocks from `blocks[first]` on; `coarse`: one of their triangles is.
    pub(super) fn leaf(first: usize, count: usize, coarse: bool) -> Self {
        let coarse = if coarse { Self::COARSE } else { 0 };
        Self(Self::LEAF | (first as u32) << 3 | coarse | (count as u32 - 1))
    }

    /// Whether it refers to blocks.
    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Whether one of a leaf's triangles is coarse.
    #[inline(always)]
    pub(super) fn is_coarse(self) -> bool {
        self.0 & Self::COARSE != 0
    }

    /// Index of the node.
    #[inline(always)]
    pub(super) fn node(self) -> usize {
        self.0 as usize
    }

    /// Index of the leaf's first block.
    #[inline(always)]
    pub(super) fn first_block(self) -> usize {
        ((self.0 & !Self::LEAF) >> 3) as usize
    }

    /// Indices of the leaf's blocks.
    #[inline(always)]
    pub(super) fn blocks(self) -> std::ops::Range<usize> {
        self.first_block()..self.first_block() + (self.0 & 3) as usize + 1
    }
}

/// Eight triangles, vertex by vertex, axis by axis; an unused lane is NaN, which no ray hits.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(super) struct TriangleBlock {
    /// Coordinates: `vertices[vertex][axis]`.
    pub vertices: [[Lanes; 3]; 3],
    /// Index of each triangle in the caller's array.
    pub primitives: [u32; WIDTH],
}

const _: () = assert!(size_of::<TriangleBlock>() == 320);

impl TriangleBlock {
    /// Packs the triangles that at most eight `primitives` name; `u32::MAX` names none.
    pub(super) fn new(primitives: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut block = Self { vertices: [[Lanes([f32::NAN; WIDTH]); 3]; 3], primitives: [u32::MAX; WIDTH] };
        for (lane, &primitive) in primitives.iter().enumerate().filter(|&(_, &primitive)| primitive != u32::MAX) {
            for (vertex, position) in triangles[primitive as usize].iter().enumerate() {
                for axis in 0..3 {
                    block.vertices[vertex][axis].0[lane] = position[axis];
                }
            }
            block.primitives[lane] = primitive;
        }
        block
    }
}

/// An 8-wide tree; `nodes[0]` is the root and always there.
#[derive(Debug)]
pub(super) struct WideTree {
    /// Inner nodes.
    pub nodes: Vec<Node>,
    /// The leaves' triangles.
    pub blocks: Vec<TriangleBlock>,
    /// Levels of nodes.
    pub depth: usize,
    /// Largest absolute coordinate of any box, for the error bound of the box test.
    pub max_coordinate: f32,
    /// Whether no leaf is coarse and the stack of a walk needs no memory from the heap.
    pub is_plain: bool,
    /// Whether it is larger than the caches of one core, so that it pays to ask for memory ahead of its use.
    pub is_large: bool,
}

/// Bytes of a tree that such caches hold.
const CACHED: usize = 2 << 20;

impl WideTree {
    /// Memory that it takes, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }

    /// A tree of these parts.
    pub(super) fn new(nodes: Vec<Node>, blocks: Vec<TriangleBlock>, depth: usize, max_coordinate: f32) -> Self {
        let has_coarse = nodes.iter().flat_map(|node| &node.children).any(|child| child.is_leaf() && child.is_coarse());
        let is_plain = !has_coarse && depth <= LOCAL_LEVELS;
        let is_large = size_of_val(&nodes[..]) + size_of_val(&blocks[..]) > CACHED;
        Self { nodes, blocks, depth, max_coordinate, is_plain, is_large }
    }
}
