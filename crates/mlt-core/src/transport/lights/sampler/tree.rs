//! A tree over the pieces of lights that lie in the cells of a region.

use super::content::{Content, build, node_of};
use super::node::{Node, quarters};
use crate::transport::geometry::hilbert;
use crate::transport::lights::cell::Cell;
use crate::transport::scene::{LightPoint, Lights, Piece};
use glam::{DVec2, Vec4};

/// The tree over the pieces of some cells, with a walk that takes each part of a node in proportion to a weight of the caller's.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// Along a Hilbert curve through their centres.
    leaves: Vec<Leaf>,
    /// The root first; a single leaf has one, too.
    nodes: Vec<Node>,
    cells: Vec<Pieces>,
    /// Place of each piece among the leaves, cell by cell.
    place: Vec<u32>,
    /// Of the cells.
    pub(super) power: f64,
}

/// A cell and its pieces.
#[derive(Clone, Copy, Debug)]
struct Pieces {
    cell: Cell,
    /// Number of the first piece in its light.
    first: u32,
    /// Number of pieces of the cells before.
    before: u32,
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    light: u32,
    /// The piece's corner with the smallest coordinates in the light's unit square, and its size there.
    low: DVec2,
    size: DVec2,
    /// The largest coordinates that are still on it.
    last: DVec2,
    /// In the light's measure, if that were spread as its power is.
    measure: f64,
}

impl Leaf {
    /// Uniform over the piece.
    #[inline]
    fn point(&self, u: f64, v: f64) -> LightPoint {
        let place = (self.low + self.size * DVec2::new(u, v)).min(self.last);
        LightPoint { light: self.light, u: place.x, v: place.y }
    }
}

impl Tree {
    /// Over disjoint cells, those of a light in one run and the lights in the order of their numbers.
    pub(super) fn new<C: Content>(lights: &Lights, cells: impl Iterator<Item = Cell>) -> Self {
        let mut pieces: Vec<(u32, Piece)> = Vec::new();
        let mut add = |cell: Cell| {
            let (before, (first, found)) =
                (pieces.len() as u32, lights.lights[cell.light as usize].pieces(cell.low, cell.high));
            pieces.extend(found.into_iter().map(|piece| (cell.light, piece)));
            Pieces { cell, first, before }
        };
        let cells: Vec<_> = cells.map(&mut add).collect();
        let centres: Vec<_> = pieces.iter().map(|(_, piece)| 0.5 * (piece.low + piece.high)).collect();
        let order = hilbert::order(&centres);
        let mut place = vec![0; pieces.len()];
        (0..).zip(&order).for_each(|(at, &piece)| place[piece as usize] = at);
        let power: f64 = cells.iter().map(|pieces| pieces.cell.power(&lights.lights)).sum();
        let leaf = |&i: &u32| {
            let (id, piece) = pieces[i as usize];
            let ([low, high], light) = (piece.square, &lights.lights[id as usize]);
            let (size, last) = (high - low, DVec2::new(high.x.next_down(), high.y.next_down()));
            let share = size.x * size.y;
            let leaf = Leaf { light: id, low, size, last, measure: share * light.measure };
            (leaf, C::of(&piece, share * light.brightness() / power, light.both_sides))
        };
        let (leaves, contents): (Vec<_>, Vec<C>) = order.iter().map(leaf).unzip();
        let mut nodes = Vec::new();
        match &contents[..] {
            [] => {}
            [only] => nodes.push(node_of(only)),
            _ => _ = build(&contents, &mut nodes),
        }
        Self { leaves, nodes, cells, place, power }
    }

    /// Number of leaves.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Whether some of a light is on it.
    #[inline]
    pub(super) fn holds(&self, light: u32) -> bool {
        self.cells.binary_search_by_key(&light, |pieces| pieces.cell.light).is_ok()
    }

    /// Σ of the root's weights; 0 without leaves.
    pub(super) fn weight(&self, weigh: impl Fn(&Node) -> Vec4) -> f64 {
        self.nodes.first().map_or(0.0, |root| f64::from(weigh(root).element_sum()))
    }

    /// A point from two uniform numbers, and its density in its light's measure, in the mean over the piece.
    #[inline(always)]
    pub(super) fn sample(&self, weigh: impl Fn(&Node) -> Vec4, u: f64, v: f64) -> (LightPoint, f64) {
        let (place, probability, u) = if self.leaves.len() > 1 { self.choose(weigh, u) } else { (0, 1.0, u) };
        let leaf = &self.leaves[place];
        (leaf.point(u, v), probability / leaf.measure)
    }

    /// A leaf's place, drawn by a uniform number, its probability, and another uniform number.
    fn choose(&self, weigh: impl Fn(&Node) -> Vec4, mut u: f64) -> (usize, f64, f64) {
        let (place, probability) = self.descend(weigh, |_, probabilities| {
            let mut below = 0.0;
            let probabilities = probabilities.to_array();
            let last = probabilities.iter().rposition(|&p| p > 0.0).unwrap_or(0);
            for (part, p) in probabilities.map(f64::from).into_iter().enumerate() {
                if (u < below + p && p > 0.0) || part == last {
                    u = ((u - below) / p).clamp(0.0, 1f64.next_down());
                    return part;
                }
                below += p;
            }
            last
        });
        (place, probability, u)
    }

    /// The density that [`sample`](Self::sample) tells of a point that it draws, given the point's light, the number of its triangle within
    /// that light and its place in the light's unit square; 0 for a point that is on none of the cells.
    #[inline]
    pub(super) fn density(
        &self,
        weigh: impl Fn(&Node) -> Vec4,
        number: (u32, u32),
        place: impl FnOnce() -> DVec2,
    ) -> f64 {
        let Some(place) = self.place(number, place) else { return 0.0 };
        let (_, probability) = self.descend(weigh, |ends, _| ends.iter().filter(|&&end| place >= end).count());
        probability / self.leaves[place].measure
    }

    /// The place among the leaves of the piece that a point lies on.
    #[inline]
    fn place(&self, (light, index): (u32, u32), place: impl FnOnce() -> DVec2) -> Option<usize> {
        let run = self.cells.partition_point(|pieces| pieces.cell.light < light);
        let cell = if self.cells.get(run)?.cell == Cell::whole(light) {
            run
        } else {
            // What is met by chance may lie on the square's upper bounds.
            let at = place().min(DVec2::splat(1f64.next_down()));
            let holds = |pieces: &Pieces| pieces.cell.holds(at);
            run + self.cells[run..].iter().take_while(|p| p.cell.light == light).position(holds)?
        };
        let Pieces { first, before, .. } = self.cells[cell];
        let end = self.cells.get(cell + 1).map_or(self.place.len(), |next| next.before as usize);
        // The two triangles of a parallelogram are one piece.
        let piece = ((before + index.saturating_sub(first)) as usize).min(end - 1);
        Some(self.place[piece] as usize)
    }

    /// Goes from the root to a leaf by the parts that `choose` takes, given the ends of the first three and the probabilities of
    /// all; returns the leaf's place and the product of the probabilities.
    #[inline]
    fn descend(
        &self,
        weigh: impl Fn(&Node) -> Vec4,
        mut choose: impl FnMut([usize; 3], Vec4) -> usize,
    ) -> (usize, f64) {
        let (mut first, mut last, mut node, mut probability) = (0, self.leaves.len(), 0, 1.0);
        while last - first > 1 {
            let here = &self.nodes[node];
            let (ends, probabilities) = (quarters(first, last), here.probabilities(weigh(here)));
            let part = choose([ends[1], ends[2], ends[3]], probabilities);
            probability *= f64::from(probabilities[part]);
            (first, last, node) = (ends[part], ends[part + 1], here.below[part] as usize);
        }
        (first, probability)
    }
}
