//! The search for triangles that lie one upon the other.
//!
//! A binary tree over runs of triangles along a Hilbert curve bounds them; a node whose triangles are all of one material that
//! emits nothing is passed over by triangles of the same. Each search visits a bounded number of nodes and finds a bounded
//! number of partners, the first ones where many lie in one place: n log n time for any input.

use crate::transport::accel::size;
use crate::transport::geometry::{ERROR_FACTOR, hilbert};
use crate::transport::scene::primitive::Primitive;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Triangles in a leaf.
const LEAF: usize = 8;
/// Most partners that are found for a triangle.
const MOST_PARTNERS: usize = 32;
/// Most nodes that a search visits.
const MOST_VISITS: usize = 1024;

/// A node's `material` where triangles of several, or of one that emits, lie in it.
const MIXED: u32 = u32::MAX;

/// The triangles that lie upon others, in ascending order, each with those others and its largest distance from each.
pub(super) fn ties(primitives: &[Primitive]) -> Vec<(u32, Vec<(u32, f32)>)> {
    let tree = Tree::new(primitives);
    let partners = (0..primitives.len() as u32).into_par_iter().map(|i| (i, tree.partners(i)));
    partners.filter(|(_, partners)| !partners.is_empty()).collect()
}

/// Content of a node.
#[derive(Clone, Copy)]
struct Bound {
    low: Vec3,
    high: Vec3,
    material: u32,
}

impl Bound {
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, material: MIXED };

    /// A triangle with the errors of its points.
    fn of(p: &Primitive) -> Self {
        let [a, b, c] = p.vertices;
        let material = if p.emits { MIXED } else { p.material };
        Self { low: a.min(b).min(c) - p.error, high: a.max(b).max(c) + p.error, material }
    }

    fn union(self, other: Self) -> Self {
        let material = if self.material == other.material { self.material } else { MIXED };
        Self { low: self.low.min(other.low), high: self.high.max(other.high), material }
    }

    /// Whether something in it may be tied to something in `other`.
    fn concerns(&self, other: &Self) -> bool {
        let apart = self.material != MIXED && self.material == other.material;
        !apart && self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// A complete binary tree: the root is node 1, the children of node i are 2i and 2i + 1.
struct Tree<'a> {
    primitives: &'a [Primitive],
    /// Of the triangles, along the curve.
    order: Vec<u32>,
    nodes: Vec<Bound>,
}

impl<'a> Tree<'a> {
    fn new(primitives: &'a [Primitive]) -> Self {
        let centres: Vec<_> = primitives.par_iter().map(|p| p.vertices.iter().sum::<Vec3>() / 3.0).collect();
        let order = hilbert::order(&centres);
        let leaves = order.len().div_ceil(LEAF).next_power_of_two();
        let mut nodes = vec![Bound::EMPTY; 2 * leaves];
        let bound = |run: &[u32]| run.iter().map(|&i| Bound::of(&primitives[i as usize])).reduce(Bound::union);
        for (node, run) in nodes[leaves..].iter_mut().zip(order.chunks(LEAF)) {
            *node = bound(run).unwrap_or(Bound::EMPTY);
        }
        for i in (1..leaves).rev() {
            nodes[i] = nodes[2 * i].union(nodes[2 * i + 1]);
        }
        Self { primitives, order, nodes }
    }

    /// The triangles that lie upon triangle `i`, those first that come first along the curve.
    fn partners(&self, i: u32) -> Vec<(u32, f32)> {
        let p = &self.primitives[i as usize];
        let (own, leaves) = (Bound::of(p), self.nodes.len() / 2);
        let (mut found, mut pending) = (Vec::new(), vec![1]);
        for _ in 0..MOST_VISITS {
            let Some(node) = pending.pop() else { break };
            if !self.nodes[node].concerns(&own) {
                continue;
            }
            if node < leaves {
                pending.extend([2 * node + 1, 2 * node]);
                continue;
            }
            let run = self.order.iter().skip((node - leaves) * LEAF).take(LEAF).copied();
            let others = run.filter(|&j| j != i && Bound::of(&self.primitives[j as usize]).concerns(&own));
            found.extend(others.filter_map(|j| Some((j, gap(p, &self.primitives[j as usize])?))));
            if found.len() >= MOST_PARTNERS {
                break;
            }
        }
        found
    }
}

/// The largest distance of two triangles that overlap in one plane, but for the error of their points; else `None`.
///
/// They overlap if no edge of either parts them by less than that error: what merely touches does not count.
fn gap(a: &Primitive, b: &Primitive) -> Option<f32> {
    let (small, large) = if size(&a.vertices) <= size(&b.vertices) { (a, b) } else { (b, a) };
    let tolerance = f64::from(a.error.max(b.error).max(ERROR_FACTOR * small.reach()));
    let [p, q] = [small, large].map(|t| t.vertices.map(Vec3::as_dvec3));
    let normal = (q[1] - q[0]).cross(q[2] - q[0]).try_normalize()?;
    let gap = p.iter().map(|v| (*v - q[0]).dot(normal).abs()).fold(0.0, f64::max);
    if gap > tolerance || small.normal.dot(large.normal).abs() < 0.99 {
        return None;
    }
    let edges = [&p, &q].into_iter().flat_map(|t| [t[1] - t[0], t[2] - t[1], t[0] - t[2]]);
    let mut axes = edges.map(|edge| normal.cross(edge).normalize_or_zero());
    axes.all(|axis| overlap(&p, &q, axis) > 2.0 * tolerance).then_some(gap as f32)
}

/// Length that the shadows of two triangles on an axis have in common; negative: the distance between them.
fn overlap(p: &[DVec3; 3], q: &[DVec3; 3], axis: DVec3) -> f64 {
    let shadow = |t: &[DVec3; 3]| {
        let [a, b, c] = t.map(|v| v.dot(axis));
        (a.min(b).min(c), a.max(b).max(c))
    };
    let ((low, high), (other_low, other_high)) = (shadow(p), shadow(q));
    high.min(other_high) - low.max(other_low)
}
