//! The tree whose cuts are the strata over the lights.
//!
//! The root is all lights. A group is a run of the lights along a Hilbert curve through their centres and halves where its
//! power halves; a light halves along its longer side, a mesh along the curve that its triangles are sorted by. The nodes
//! are not stored: a node says what it covers, and its halves are found in O(log n).

use super::cell::Cell;
use crate::transport::geometry::hilbert;
use crate::transport::scene::{Light, Lights};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Most halvings of one light.
pub const MOST_HALVINGS: u32 = 12;

/// A part of the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// Lights number `first` to `last` − 1 along the curve.
    Group {
        /// First of them.
        first: u32,
        /// One past the last.
        last: u32,
    },
    /// One of the 2^depth cells of a light.
    Cell {
        /// Number of the light along the curve.
        position: u32,
        /// Number of halvings.
        depth: u32,
        /// The halves taken, one bit each, the first halving's highest.
        path: u32,
    },
}

impl Node {
    /// Sorts nodes of a cut along the curve.
    pub(crate) fn order(&self) -> (u32, u32) {
        match *self {
            Self::Group { first, .. } => (first, 0),
            Self::Cell { position, depth, path } => (position, path << (MOST_HALVINGS - depth)),
        }
    }
}

/// The lights of a scene in spatial order.
#[derive(Debug)]
pub struct LightTree<'a> {
    lights: &'a [Light],
    order: Vec<u32>,
    /// Power of the lights before each, and of all.
    cumulative: Vec<f64>,
}

impl<'a> LightTree<'a> {
    /// Sorts the lights.
    pub fn new(lights: &'a Lights) -> Self {
        let lights = &lights.lights[..];
        let order = hilbert::order(&lights.iter().map(Light::centre).collect::<Vec<_>>());
        let mut power = 0.0;
        let after = order.iter().map(|&i| {
            power += lights[i as usize].power();
            power
        });
        let cumulative = std::iter::once(0.0).chain(after).collect();
        Self { lights, order, cumulative }
    }

    /// All lights.
    pub fn root(&self) -> Node {
        Node::Group { first: 0, last: self.order.len() as u32 }
    }

    /// Emitted power.
    pub fn power(&self, node: Node) -> f64 {
        match node {
            Node::Group { first, last } => self.cumulative[last as usize] - self.cumulative[first as usize],
            Node::Cell { position, depth, .. } => self.light(position).1.power() / f64::from(1u32 << depth),
        }
    }

    /// The two parts of a node; `None` for a cell that is not cut any further.
    pub fn halves(&self, node: Node) -> Option<[Node; 2]> {
        match node {
            Node::Group { first, last } if last - first > 1 => {
                let middle = self.middle(first, last);
                Some([Node::Group { first, last: middle }, Node::Group { first: middle, last }])
            }
            Node::Group { first, .. } => self.halves(Node::Cell { position: first, depth: 0, path: 0 }),
            Node::Cell { position, depth, path } => (depth < MOST_HALVINGS && self.light(position).1.has_extent())
                .then(|| [2 * path, 2 * path + 1].map(|path| Node::Cell { position, depth: depth + 1, path })),
        }
    }

    /// The cells that a node consists of.
    pub fn cells(&self, node: Node) -> Vec<Cell> {
        match node {
            Node::Group { first, last } => {
                self.order[first as usize..last as usize].iter().map(|&light| Cell::whole(light)).collect()
            }
            Node::Cell { position, depth, path } => vec![self.cell(position, depth, path)],
        }
    }

    /// The cut into at most `count` nodes, of which each but the indivisible has at least the power `least`: the most
    /// powerful node is halved next.
    pub fn cut(&self, count: usize, least: f64) -> Vec<Node> {
        let weigh = |node| Weighed { power: self.power(node), node };
        let (mut open, mut closed) = (BinaryHeap::from([weigh(self.root())]), Vec::new());
        while open.len() + closed.len() < count.max(1) {
            let Some(Weighed { power, node }) = open.pop() else { break };
            match self.halves(node) {
                Some(halves) if power >= 2.0 * least => open.extend(halves.map(weigh)),
                _ => closed.push(node),
            }
        }
        closed.extend(open.into_iter().map(|w| w.node));
        closed.sort_unstable_by_key(Node::order);
        closed
    }

    /// Index of the light at a position of the curve, and the light.
    pub(crate) fn light(&self, position: u32) -> (u32, &'a Light) {
        let id = self.order[position as usize];
        (id, &self.lights[id as usize])
    }

    /// Number of lights.
    pub(crate) fn len(&self) -> u32 {
        self.order.len() as u32
    }

    /// Where the power of a group of two or more lights halves best, with at least one light on each side.
    fn middle(&self, first: u32, last: u32) -> u32 {
        let (low, high) = (first as usize, last as usize);
        let half = 0.5 * (self.cumulative[low] + self.cumulative[high]);
        let above = low + self.cumulative[low..high].partition_point(|&c| c < half);
        let nearer = half - self.cumulative[above.max(low + 1) - 1] < self.cumulative[above] - half;
        let middle = if nearer { above.max(1) - 1 } else { above };
        middle.clamp(low + 1, high - 1) as u32
    }

    fn cell(&self, position: u32, depth: u32, path: u32) -> Cell {
        let (id, light) = self.light(position);
        let mut sides = light.sides();
        let Cell { mut low, mut high, .. } = Cell::whole(id);
        for bit in (0..depth).rev() {
            let axis = usize::from(sides[1] > sides[0]);
            sides[axis] *= 0.5;
            let middle = 0.5 * (low[axis] + high[axis]);
            if path >> bit & 1 == 0 { high[axis] = middle } else { low[axis] = middle }
        }
        Cell { light: id, low, high }
    }
}

/// A node in the queue of those to be halved.
struct Weighed {
    power: f64,
    node: Node,
}

impl Ord for Weighed {
    /// By power, then along the curve.
    fn cmp(&self, other: &Self) -> Ordering {
        self.power.total_cmp(&other.power).then_with(|| other.node.order().cmp(&self.node.order()))
    }
}

impl PartialOrd for Weighed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Weighed {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Weighed {}
