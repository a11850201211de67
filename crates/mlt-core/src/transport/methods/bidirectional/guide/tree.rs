//! Photons by places, and the directions that they tell of.
//!
//! A k-d tree over places and normals has leaves of a few photons each, and a linear [`Fit`] of the directions in each: light of one small lamp
//! by one sequence of events comes from nearly one point, its image, so that its direction is a smooth function of the place.
//!
//! docs/theory-strata.md, section 8.

use super::lobe::Lobe;
use crate::engine::uniform_f32;
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::cross;
use glam::{Mat3A, Vec3, Vec3A};
use rand_pcg::rand_core::Rng;
use std::ops::Range;

/// Most photons that a place takes its directions from.
const NEAR: usize = 16;
/// Share of their mean square that is added to that of photons' places in a fit: they often lie in a plane.
const RIDGE: f32 = 1e-3;
/// Numbers that a fit of one coordinate in a plane has.
const PARAMETERS: f32 = 3.0;

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

/// Light that came to a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photon {
    pub(super) at: Place,
    /// The specular vertex that it came from.
    pub(super) from: Vec3A,
}

/// A point of a surface. Those of two walls are far apart in the tree, even in the corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    position: Vec3A,
    normal: Vec3A,
}

#[derive(Clone, Debug)]
enum Node {
    /// Places with a coordinate below this one are in the next node, others in the one of this number. Axes from 3 on are the normal's.
    Halves { axis: usize, at: f32, other: usize },
    /// The photons of these numbers, and their fit.
    Leaf(Range<usize>, Fit),
}

/// Directions as a linear function of the place.
#[derive(Clone, Copy, Debug)]
struct Fit {
    /// x̄.
    place: Vec3A,
    /// One over the root of the mean square of |x_j − x̄|: places are scaled by it, as scenes are of all sizes.
    scale: f32,
    /// d̄.
    direction: Vec3A,
    /// G, over scaled places.
    gradient: Mat3A,
    /// ε.
    width: f32,
}

impl Tree {
    /// Of one photon or more.
    pub(super) fn new(photons: Vec<Photon>) -> Self {
        let (low, high) = bounds(&photons, |photon| photon.at.position);
        let mut it = Self { size: 0.5 * (high - low).max_element(), photons, nodes: Vec::new() };
        it.part(0..it.photons.len());
        it
    }

    /// Number of photons.
    pub(super) fn len(&self) -> usize {
        self.photons.len()
    }

    /// Draws a direction at x.
    pub(super) fn sample(&self, x: &Vertex, rng: &mut impl Rng) -> Vec3A {
        let (photons, fit) = self.near(x);
        let (fitted, chosen) = (uniform_f32(rng) < 0.5, uniform_f32(rng));
        let of_photon = || photons[(chosen * photons.len() as f32) as usize].lobe(x.position);
        let lobe = if fitted { fit.lobe(x.position) } else { of_photon() };
        lobe.sample(uniform_f32(rng), uniform_f32(rng))
    }

    /// The density of the directions that [`sample`](Self::sample) draws, sr⁻¹.
    pub(super) fn density(&self, x: &Vertex, direction: Vec3A) -> f32 {
        let (photons, fit) = self.near(x);
        let of_photons: f32 = photons.iter().map(|photon| photon.lobe(x.position).density(direction)).sum();
        0.5 * (fit.lobe(x.position).density(direction) + of_photons / photons.len() as f32)
    }

    /// Places of about so many photons, evenly among those that lie around one another, with the root of the mean square of their distance
    /// from the middle of the photons around.
    pub(super) fn places(&self, count: usize) -> impl Iterator<Item = (Vec3A, f32)> {
        let step = self.photons.len().div_ceil(count).max(1);
        let of_leaf = |node: &Node| match node {
            Node::Leaf(photons, fit) => Some((photons.clone(), fit.scale)),
            Node::Halves { .. } => None,
        };
        self.nodes.iter().filter_map(of_leaf).flat_map(move |(photons, scale)| {
            let extent = if scale > 0.0 { scale.recip() } else { 0.0 };
            photons.filter(move |i| i.is_multiple_of(step)).map(move |i| (self.photons[i].at.position, extent))
        })
    }

    /// The photons of the leaf that x is in.
    fn near(&self, x: &Vertex) -> (&[Photon], &Fit) {
        let (x, mut node) = (Place::of(x), 0);
        loop {
            match &self.nodes[node] {
                &Node::Halves { axis, at, other } => {
                    node = if x.coordinate(axis, self.size) < at { node + 1 } else { other }
                }
                Node::Leaf(photons, fit) => return (&self.photons[photons.clone()], fit),
            }
        }
    }

    /// Makes the nodes of these photons: halves along the axis on which they lie farthest apart.
    fn part(&mut self, range: Range<usize>) {
        let photons = &mut self.photons[range.clone()];
        if photons.len() <= NEAR {
            return self.nodes.push(Node::Leaf(range, Fit::new(photons)));
        }
        let extent = |(low, high): (Vec3A, Vec3A)| high - low;
        let of_positions = extent(bounds(photons, |photon| photon.at.position));
        let of_normals = self.size * extent(bounds(photons, |photon| photon.at.normal));
        let axis = match of_positions.max_element() >= of_normals.max_element() {
            true => of_positions.max_position(),
            false => 3 + of_normals.max_position(),
        };
        let coordinate = |photon: &Photon| photon.at.coordinate(axis, self.size);
        photons.sort_by(|a, b| coordinate(a).total_cmp(&coordinate(b)));
        // Photons with the same coordinate stay together.
        let median = coordinate(&photons[photons.len() / 2]);
        let middle = match photons.partition_point(|photon| coordinate(photon) < median) {
            0 => photons.partition_point(|photon| coordinate(photon) <= median),
            below => below,
        };
        let Some(first) = photons.get(middle) else {
            // All are at one place.
            return self.nodes.push(Node::Leaf(range.start..range.start + NEAR, Fit::new(&photons[..NEAR])));
        };
        let (at, node) = (coordinate(first), self.nodes.len());
        self.nodes.push(Node::Halves { axis, at, other: 0 });
        self.part(range.start..range.start + middle);
        let next = self.nodes.len();
        self.nodes[node] = Node::Halves { axis, at, other: next };
        self.part(range.start + middle..range.end);
    }
}

/// The box of some vectors.
fn bounds(photons: &[Photon], vector: impl Fn(&Photon) -> Vec3A) -> (Vec3A, Vec3A) {
    let with = |(low, high): (Vec3A, Vec3A), v: Vec3A| (low.min(v), high.max(v));
    photons.iter().map(vector).fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), with)
}

impl Place {
    pub(super) fn of(vertex: &Vertex) -> Self {
        Self { position: vertex.position, normal: vertex.geometric_normal }
    }

    fn coordinate(&self, axis: usize, size: f32) -> f32 {
        if axis < 3 { self.position[axis] } else { size * self.normal[axis - 3] }
    }
}

impl Fit {
    /// The least squares of d_j − d̄ = G (x_j − x̄).
    fn new(photons: &[Photon]) -> Self {
        let n = photons.len() as f32;
        let direction = |p: &Photon| Lobe::towards(p.from - p.at.position, 1.0).axis;
        let place = photons.iter().map(|p| p.at.position).sum::<Vec3A>() / n;
        let mean = photons.iter().map(direction).sum::<Vec3A>() / n;
        let square = photons.iter().map(|p| (p.at.position - place).length_squared()).sum::<f32>() / n;
        let scale = if square > 0.0 { square.sqrt().recip() } else { 0.0 };
        let step = |p: &Photon| scale * (p.at.position - place);
        let outer = |a: Vec3A, b: Vec3A| Mat3A::from_cols(a * b.x, a * b.y, a * b.z);
        let of_places = photons.iter().map(|p| outer(step(p), step(p))).sum::<Mat3A>();
        let of_both = photons.iter().map(|p| outer(direction(p) - mean, step(p))).sum::<Mat3A>();
        let gradient = of_both * inverse(of_places + Mat3A::from_diagonal(Vec3::splat(n * RIDGE)));
        let left = |p: &Photon| (direction(p) - mean - gradient * step(p)).length_squared();
        let scatter = photons.iter().map(left).sum::<f32>() / (n - PARAMETERS).max(1.0);
        let width = if n > PARAMETERS { 0.5 * scatter } else { 1.0 };
        Self { place, scale, direction: mean, gradient, width }
    }

    /// The directions that it foretells at x.
    fn lobe(&self, x: Vec3A) -> Lobe {
        Lobe::towards(self.direction + self.gradient * (self.scale * (x - self.place)), self.width)
    }
}

/// The inverse of a symmetric matrix, to the same bits on every machine: glam's takes its own [`cross`].
fn inverse(m: Mat3A) -> Mat3A {
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
    let adjugate = Mat3A::from_cols(cross(b, c), cross(c, a), cross(a, b));
    adjugate * a.dot(adjugate.x_axis).recip()
}

impl Photon {
    /// Its directions at x.
    fn lobe(&self, x: Vec3A) -> Lobe {
        let to_specular = self.from - x;
        let square = to_specular.length_squared().max(f32::MIN_POSITIVE);
        Lobe::towards(to_specular, 0.5 * (self.at.position - x).length_squared() / square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator};
    use crate::transport::geometry::math::unit;

    /// All rays of a point behind a mirror come from the point's image, wherever they arrive: the fit knows it, single photons do not.
    #[test]
    fn a_fit_foretells_what_lies_between_its_photons() {
        let image = Vec3A::new(0.2, 3.0, -0.1);
        let photon = |i: u64| {
            let rng = &mut generator(2, Purpose::Sample, 0, 0, i);
            let position = Vec3A::new(uniform_f32(rng), 0.0, uniform_f32(rng)) * 0.2;
            let from = position + (image - position) / (image.y - position.y);
            Photon { at: Place { position, normal: Vec3A::Y }, from }
        };
        let tree = Tree::new((0..NEAR as u64).map(photon).collect());
        let vertex = Vertex::camera(Vec3A::new(0.07, 0.0, 0.13), Vec3A::Y);
        let ((photons, fit), x) = (tree.near(&vertex), vertex.position);
        let right = unit(image - x);
        assert!(fit.lobe(x).axis.distance(right) < 2e-3, "{fit:?}");
        let of_photons = photons.iter().map(|photon| photon.lobe(x).density(right)).sum::<f32>() / NEAR as f32;
        assert!(fit.lobe(x).density(right) > 100.0 * of_photons, "{of_photons}");
    }

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
            let (photons, _) = tree.near(&Vertex::camera(Vec3A::new(3.0, 0.0, 0.0), normal));
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
                    let direction = tree.sample(&x, &mut generator(3, Purpose::Sample, 0, 0, i as u64));
                    let density = tree.density(&x, direction);
                    assert!((direction.length() - 1.0).abs() < 1e-5, "{size} {count} {direction:?}");
                    assert!(density > 0.0 && density.is_finite(), "{size} {count} {density:?}");
                }
            }
        }
    }
}
