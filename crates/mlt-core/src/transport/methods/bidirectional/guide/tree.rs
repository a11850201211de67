//! Photons by places, and the directions that they tell of.
//!
//! A k-d tree over places and normals has leaves of a few photons each, and a [`Fit`] of the directions in each; parts of some hundred
//! photons have [`Clusters`] of them.
//!
//! docs/theory-strata.md, section 8.

use super::clusters::Clusters;
use super::fit::Fit;
use super::place::{Photon, Place};
use crate::engine::uniform_f32;
use crate::transport::geometry::Vertex;
use glam::Vec3A;
use rand_pcg::rand_core::Rng;
use std::ops::Range;

/// Most photons that a place takes its directions from.
const NEAR: usize = 16;
/// Most photons that it takes clusters of directions from.
const AROUND: usize = 256;

/// A k-d tree of photons.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// In the order of its leaves.
    photons: Vec<Photon>,
    /// Each before those of its halves.
    nodes: Vec<Node>,
    /// Length that a normal counts as: half of the photons' extent.
    size: f32,
}

#[derive(Clone, Debug)]
enum Node {
    /// Places with a coordinate below this one are in the next node, others in the one of this number. Axes from 3 on are the normal's.
    Halves { axis: usize, at: f32, other: usize },
    /// Clusters of the photons of the next node.
    Around(Clusters),
    /// The photons of these numbers, and their fit.
    Leaf(Range<usize>, Fit),
}

/// Knowledge of a place.
pub(super) struct Near<'a> {
    x: Vec3A,
    photons: &'a [Photon],
    fit: &'a Fit,
    around: &'a Clusters,
}

impl Tree {
    /// Of one photon or more.
    pub(super) fn new(photons: Vec<Photon>) -> Self {
        let (low, high) = bounds(&photons, |photon| photon.at.position);
        let mut it = Self { size: 0.5 * (high - low).max_element(), photons, nodes: Vec::new() };
        it.part(0..it.photons.len(), false);
        it
    }

    /// Number of photons.
    pub(super) fn len(&self) -> usize {
        self.photons.len()
    }

    /// Places of about so many photons, evenly among those that lie around one another, with the extent of those that each stands for:
    /// the root of the mean square of their distances from their middle.
    pub(super) fn places(&self, count: usize) -> impl Iterator<Item = (Vec3A, f32)> {
        let step = self.photons.len().div_ceil(count).max(1);
        let of_leaf = |node: &Node| match node {
            Node::Leaf(photons, fit) => Some((photons.clone(), fit.scale)),
            Node::Halves { .. } | Node::Around(_) => None,
        };
        self.nodes.iter().filter_map(of_leaf).flat_map(move |(photons, scale)| {
            let of_each = (step as f32 / photons.len() as f32).max(1.0).sqrt();
            let extent = if scale > 0.0 { of_each / scale } else { 0.0 };
            photons.filter(move |i| i.is_multiple_of(step)).map(move |i| (self.photons[i].at.position, extent))
        })
    }

    /// The knowledge of x.
    pub(super) fn near(&self, x: &Vertex) -> Near<'_> {
        let (x, mut node, mut around) = (Place::of(x), 0, None);
        loop {
            node = match &self.nodes[node] {
                &Node::Halves { axis, at, .. } if x.coordinate(axis, self.size) < at => node + 1,
                &Node::Halves { other, .. } => other,
                Node::Around(clusters) => {
                    around = Some(clusters);
                    node + 1
                }
                Node::Leaf(photons, fit) => {
                    let around = around.expect("a node of clusters before each leaf");
                    return Near { x: x.position, photons: &self.photons[photons.clone()], fit, around };
                }
            }
        }
    }

    /// Makes the nodes of these photons; `around`: clusters stand before them.
    fn part(&mut self, range: Range<usize>, around: bool) {
        let photons = &mut self.photons[range.clone()];
        let halves = if photons.len() > NEAR { halves(photons, self.size) } else { None };
        if !around && (photons.len() <= AROUND || halves.is_none()) {
            self.nodes.push(Node::Around(Clusters::new(photons)));
            return self.part(range, true);
        }
        let Some((middle, axis, at)) = halves else {
            // A few, or all at one place.
            let few = photons.len().min(NEAR);
            return self.nodes.push(Node::Leaf(range.start..range.start + few, Fit::new(&photons[..few])));
        };
        let node = self.nodes.len();
        self.nodes.push(Node::Halves { axis, at, other: 0 });
        self.part(range.start..range.start + middle, around);
        let next = self.nodes.len();
        self.nodes[node] = Node::Halves { axis, at, other: next };
        self.part(range.start + middle..range.end, around);
    }
}

impl Near<'_> {
    /// Photons by the area that they lie on, and fewer apart from it, by [`Fit::nearness`].
    pub(super) fn photons_per_area(&self) -> f64 {
        self.photons.len() as f64 * self.fit.nearness(self.x)
    }

    /// Draws a direction.
    pub(super) fn sample(&self, rng: &mut impl Rng) -> Vec3A {
        let (kind, chosen) = (3.0 * uniform_f32(rng), uniform_f32(rng));
        let lobe = match kind as u32 {
            0 => self.fit.lobe(self.x),
            1 => self.photons[(chosen * self.photons.len() as f32) as usize].lobe(self.x),
            _ => self.around.lobe(chosen, self.x),
        };
        lobe.sample(uniform_f32(rng), uniform_f32(rng))
    }

    /// The density of the directions that [`sample`](Self::sample) draws, sr⁻¹.
    pub(super) fn density(&self, direction: Vec3A) -> f32 {
        let of_photons: f32 = self.photons.iter().map(|photon| photon.lobe(self.x).density(direction)).sum();
        let of_fit = self.fit.lobe(self.x).density(direction);
        (of_fit + of_photons / self.photons.len() as f32 + self.around.density(self.x, direction)) / 3.0
    }
}

/// Sorts photons along the axis on which they lie farthest apart; returns how many are in the lower half, the axis, and the coordinate of the first
/// in the other one, unless all are at one place.
fn halves(photons: &mut [Photon], size: f32) -> Option<(usize, usize, f32)> {
    let extent = |(low, high): (Vec3A, Vec3A)| high - low;
    let of_positions = extent(bounds(photons, |photon| photon.at.position));
    let of_normals = size * extent(bounds(photons, |photon| photon.at.normal));
    let axis = match of_positions.max_element() >= of_normals.max_element() {
        true => of_positions.max_position(),
        false => 3 + of_normals.max_position(),
    };
    let coordinate = |photon: &Photon| photon.at.coordinate(axis, size);
    photons.sort_by(|a, b| coordinate(a).total_cmp(&coordinate(b)));
    // Photons with the same coordinate stay together.
    let median = coordinate(&photons[photons.len() / 2]);
    let middle = match photons.partition_point(|photon| coordinate(photon) < median) {
        0 => photons.partition_point(|photon| coordinate(photon) <= median),
        below => below,
    };
    photons.get(middle).filter(|_| middle > 0).map(|first| (middle, axis, coordinate(first)))
}

/// The box of some vectors.
fn bounds(photons: &[Photon], vector: impl Fn(&Photon) -> Vec3A) -> (Vec3A, Vec3A) {
    let with = |(low, high): (Vec3A, Vec3A), v: Vec3A| (low.min(v), high.max(v));
    photons.iter().map(vector).fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), with)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator};

    /// The floor's and the wall's are not mixed up in the corner.
    #[test]
    fn photons_of_two_walls_are_apart() {
        let photon = |i: usize| {
            let (along, up) = ((i % 8) as f32, (i / 8) as f32 * 1e-3);
            let (position, normal) = match i % 3 {
                0 => (Vec3A::new(along, up, 0.0), Vec3A::Z),
                _ => (Vec3A::new(along, 0.0, up), Vec3A::Y),
            };
            Photon { at: Place { position, normal }, from: position + Vec3A::ONE }
        };
        let tree = Tree::new((0..96).map(photon).collect());
        for normal in [Vec3A::Y, Vec3A::Z] {
            let Near { photons, .. } = tree.near(&Vertex::camera(Vec3A::new(3.0, 0.0, 0.0), normal));
            assert!(photons.iter().all(|photon| photon.at.normal == normal), "{normal} {photons:?}");
        }
    }

    /// Photons at one place, some of which came from there, and rooms of any size.
    #[test]
    fn directions_are_directions_wherever_photons_lie() {
        for size in [0.0, 1e-12, 1.0, 1e12] {
            let at = |i: usize| Vec3A::new((i % 3) as f32, 0.0, (i % 5) as f32) * size;
            let place =
                |i: usize| Place { position: at(i), normal: if i.is_multiple_of(4) { Vec3A::X } else { Vec3A::Y } };
            let photon = |i: usize| Photon { at: place(i), from: at(i) + Vec3A::Y * size * (i % 2) as f32 };
            for count in [1, 2, 5, 40] {
                let tree = Tree::new((0..count).map(photon).collect());
                for i in 0..20 {
                    let x = Vertex::camera(at(i), Vec3A::Y);
                    let near = tree.near(&x);
                    let direction = near.sample(&mut generator(3, Purpose::Sample, 0, 0, i as u64));
                    let density = near.density(direction);
                    assert!((direction.length() - 1.0).abs() < 1e-5, "{size} {count} {direction:?}");
                    assert!(density > 0.0 && density.is_finite(), "{size} {count} {density:?}");
                    assert!(near.photons_per_area().is_finite(), "{size} {count}");
                }
            }
        }
    }
}
