//! The content of the nodes of a [`Tree`](super::tree::Tree), and how they are built from it.

use super::node::{Node, WIDTH, quarters};
use crate::transport::scene::Piece;

/// Knowledge of the pieces below a part of a node.
pub(super) trait Content: Copy {
    /// Of a piece with so much power, as a share, that emits from both sides or from one.
    fn of(piece: &Piece, power: f64, both_sides: bool) -> Self;

    /// Of the pieces of both.
    fn union(a: &Self, b: &Self) -> Self;

    /// Writes it into a node as part `i`.
    fn store(&self, i: usize, node: &mut Node);
}

/// A node with one part.
pub(super) fn node_of(content: &impl Content) -> Node {
    let mut node = Node::default();
    content.store(0, &mut node);
    node
}

/// Adds the tree over `leaves`, at least one; a single one is no node.
pub(super) fn build<C: Content>(leaves: &[C], nodes: &mut Vec<Node>) -> C {
    if let [leaf] = leaves {
        return *leaf;
    }
    let here = nodes.len();
    nodes.push(Node::default());
    let ends = quarters(0, leaves.len());
    let mut whole: Option<C> = None;
    for part in (0..WIDTH).filter(|&part| ends[part] < ends[part + 1]) {
        nodes[here].below[part] = nodes.len() as u32;
        let content = build(&leaves[ends[part]..ends[part + 1]], nodes);
        content.store(part, &mut nodes[here]);
        whole = Some(whole.map_or(content, |whole| C::union(&whole, &content)));
    }
    whole.unwrap_or(leaves[0])
}
