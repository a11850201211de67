//! The tree of a [`LightSampler`](super::LightSampler), built from what bounds its leaves.

use super::node::{Node, WIDTH, quarters};
use crate::transport::scene::Piece;
use glam::Vec3;

/// Content of a node, while the tree is built.
#[derive(Clone, Copy)]
pub(super) struct Bound {
    low: Vec3,
    high: Vec3,
    axis: Vec3,
    /// Half of the cone's opening, radians.
    spread: f64,
    power: f64,
    both_sides: bool,
}

impl Bound {
    pub(super) fn of(piece: &Piece, power: f64, both_sides: bool) -> Self {
        let &Piece { low, high, normal, spread, .. } = piece;
        Self { low, high, axis: normal, spread, power, both_sides }
    }

    fn union(a: &Self, b: &Self) -> Self {
        let axis = (a.axis + b.axis).normalize_or(Vec3::Z);
        // The rounding of the axes is far below the addend.
        let reach = |x: &Self| x.spread + libm::acos(f64::from(axis.dot(x.axis).clamp(-1.0, 1.0))) + 1e-3;
        Self {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
            axis,
            spread: reach(a).max(reach(b)).min(std::f64::consts::PI),
            power: a.power + b.power,
            both_sides: a.both_sides || b.both_sides,
        }
    }

    /// A node with this as its only part.
    pub(super) fn node(&self) -> Node {
        let mut node = Node::default();
        self.store(0, &mut node);
        node
    }

    /// Writes it into a node as part `i`.
    fn store(&self, i: usize, node: &mut Node) {
        let centre = 0.5 * (self.low + self.high);
        for axis in 0..3 {
            (node.centre[axis][i], node.axis[axis][i]) = (centre[axis], self.axis[axis]);
        }
        // A little more than half of the diagonal, for what rounding takes away.
        node.radius[i] = 0.5001 * (self.high - self.low).length();
        (node.spread[0][i], node.spread[1][i]) = (libm::cos(self.spread) as f32, libm::sin(self.spread) as f32);
        (node.power[i], node.both_sides[i]) = (self.power as f32, f32::from(u8::from(self.both_sides)));
    }
}

/// Adds the tree over `leaves`, at least one; a single one is no node.
pub(super) fn build(leaves: &[Bound], nodes: &mut Vec<Node>) -> Bound {
    if let [leaf] = leaves {
        return *leaf;
    }
    let here = nodes.len();
    nodes.push(Node::default());
    let ends = quarters(0, leaves.len());
    let mut whole: Option<Bound> = None;
    for part in (0..WIDTH).filter(|&part| ends[part] < ends[part + 1]) {
        nodes[here].below[part] = nodes.len() as u32;
        let bound = build(&leaves[ends[part]..ends[part + 1]], nodes);
        bound.store(part, &mut nodes[here]);
        whole = Some(whole.map_or(bound, |whole| Bound::union(&whole, &bound)));
    }
    whole.unwrap_or(leaves[0])
}
