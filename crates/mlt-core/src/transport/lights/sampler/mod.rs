//! Which point of the lights is drawn for a vertex: next-event estimation with a tree over the pieces of the lights.
//!
//! A piece is a light's parallelogram or one triangle of a light, as far as it lies in a cell of the region that points are
//! drawn on. The tree's nodes bound position and direction of what their parts hold; a walk from the root takes each part in
//! proportion to a bound on the irradiance that it sends to the vertex. Distant lights have no place in the tree: their bound, the same for
//! all vertices, stands beside that of its root.
//!
//! Source: [ContyKulla18], "Importance Sampling of Many Lights with Adaptive Tree Splitting", section 5.

mod bound;
mod node;

use super::afar::Afar;
use super::cell::Cell;
use crate::transport::geometry::{Vertex, hilbert};
use crate::transport::scene::{LightPoint, Lights, Piece};
use bound::{Bound, build};
use glam::{DVec2, Vec4};
use node::{Node, quarters};

/// The tree over the pieces of a region.
#[derive(Clone, Debug)]
pub struct LightSampler {
    /// Along a Hilbert curve through their centres.
    leaves: Vec<Leaf>,
    /// The root first.
    nodes: Vec<Node>,
    /// The region's cells.
    cells: Vec<Pieces>,
    /// Place of each piece among the leaves, cell by cell.
    place: Vec<u32>,
    /// Lights without pieces.
    afar: Afar,
    /// Power of the pieces.
    near_power: f64,
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
    area: f64,
}

impl Leaf {
    /// Uniform over the piece.
    #[inline]
    fn point(&self, u: f64, v: f64) -> LightPoint {
        let place = (self.low + self.size * DVec2::new(u, v)).min(self.last);
        LightPoint { light: self.light, u: place.x, v: place.y }
    }
}

impl LightSampler {
    /// Builds the tree over disjoint cells, those of a light in one run and the lights in the order of their numbers.
    pub(crate) fn new(lights: &Lights, cells: &[Cell]) -> Self {
        let afar = Afar::of(cells, &lights.lights);
        let near = cells.iter().filter(|cell| lights.lights[cell.light as usize].radius_around().is_none());
        let mut pieces: Vec<(u32, Piece)> = Vec::new();
        let mut add = |&cell: &Cell| {
            let (before, (first, found)) =
                (pieces.len() as u32, lights.lights[cell.light as usize].pieces(cell.low, cell.high));
            pieces.extend(found.into_iter().map(|piece| (cell.light, piece)));
            Pieces { cell, first, before }
        };
        let cells: Vec<_> = near.map(&mut add).collect();
        let centres: Vec<_> = pieces.iter().map(|(_, piece)| 0.5 * (piece.low + piece.high)).collect();
        let order = hilbert::order(&centres);
        let mut place = vec![0; pieces.len()];
        (0..).zip(&order).for_each(|(at, &piece)| place[piece as usize] = at);
        let total: f64 = cells.iter().map(|pieces| pieces.cell.power(&lights.lights)).sum();
        let leaf = |&i: &u32| {
            let (id, piece) = pieces[i as usize];
            let ([low, high], light) = (piece.square, &lights.lights[id as usize]);
            let (size, last) = (high - low, DVec2::new(high.x.next_down(), high.y.next_down()));
            let share = size.x * size.y;
            let leaf = Leaf { light: id, low, size, last, area: share * light.measure };
            (leaf, Bound::of(&piece, share * light.brightness() / total, light.both_sides))
        };
        let (leaves, bounds): (Vec<_>, Vec<_>) = order.iter().map(leaf).unzip();
        let mut nodes = Vec::new();
        match &bounds[..] {
            [] => {}
            // For its bound beside that of distant lights.
            [only] if afar.len() > 0 => nodes.push(only.node()),
            [_] => {}
            _ => _ = build(&bounds, &mut nodes),
        }
        Self { leaves, nodes, cells, place, afar, near_power: total }
    }

    /// Whether there is more than one piece: else points are uniform over it, whatever the vertex.
    #[inline]
    pub fn has_choice(&self) -> bool {
        self.leaves.len() + self.afar.len() > 1
    }

    /// A point for `vertex` from two uniform numbers, and its density in its light's measure, in the mean over the piece: to be multiplied
    /// by the point's exitance over its light's mean.
    #[inline(always)]
    pub fn sample(&self, vertex: &Vertex, u: f64, v: f64) -> (LightPoint, f64) {
        if self.afar.len() > 0 { self.sample_all(*vertex, u, v) } else { self.sample_near(vertex, u, v) }
    }

    /// The same with distant lights among the others.
    #[inline(never)]
    fn sample_all(&self, vertex: Vertex, u: f64, v: f64) -> (LightPoint, f64) {
        let from_afar = self.share_from_afar(&vertex);
        let (share, (point, density)) = if u < from_afar {
            (from_afar, self.afar.sample(u / from_afar, v))
        } else {
            let rest = 1.0 - from_afar;
            (rest, self.sample_near(&vertex, ((u - from_afar) / rest).min(1f64.next_down()), v))
        };
        (point, share * density)
    }

    /// Probability of drawing a point on a distant light.
    fn share_from_afar(&self, vertex: &Vertex) -> f64 {
        let Some(root) = self.nodes.first() else { return 1.0 };
        let afar = self.afar.irradiance / self.near_power;
        let near = f64::from(root.importance(vertex.position, vertex.shading_normal).element_sum());
        if near.is_finite() { afar / (afar + near) } else { self.afar.power() / (self.afar.power() + self.near_power) }
    }

    #[inline(always)]
    fn sample_near(&self, vertex: &Vertex, u: f64, v: f64) -> (LightPoint, f64) {
        let (place, probability, u) = if self.leaves.len() > 1 { self.choose(vertex, u) } else { (0, 1.0, u) };
        let leaf = &self.leaves[place];
        (leaf.point(u, v), probability / leaf.area)
    }

    /// The place of a leaf for `vertex`, drawn by a uniform number, its probability, and another uniform number.
    fn choose(&self, vertex: &Vertex, mut u: f64) -> (usize, f64, f64) {
        let (place, probability) = self.descend(vertex, |_, probabilities| {
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

    /// The density that [`sample`](Self::sample) tells of a point that it draws, given also the point's light and the number of its
    /// triangle within that light; 0 for a point that is not in the region.
    #[inline]
    pub fn density(&self, vertex: &Vertex, number: (u32, u32), point: &LightPoint) -> f64 {
        if self.afar.len() > 0 {
            return self.density_of_all(*vertex, number, point);
        }
        self.density_near(vertex, number, point)
    }

    /// The same with distant lights among the others.
    #[inline(never)]
    fn density_of_all(&self, vertex: Vertex, number: (u32, u32), point: &LightPoint) -> f64 {
        let from_afar = self.share_from_afar(&vertex);
        match self.afar.density(point) {
            Some(density) => from_afar * density,
            None => (1.0 - from_afar) * self.density_near(&vertex, number, point),
        }
    }

    #[inline]
    fn density_near(&self, vertex: &Vertex, number: (u32, u32), point: &LightPoint) -> f64 {
        let Some(place) = self.place(number, point) else { return 0.0 };
        let (_, probability) = self.descend(vertex, |ends, _| ends.iter().filter(|&&end| place >= end).count());
        probability / self.leaves[place].area
    }

    /// The place among the leaves of the piece that a point lies on.
    #[inline]
    fn place(&self, (light, index): (u32, u32), point: &LightPoint) -> Option<usize> {
        // What is met by chance may lie on the square's upper bounds.
        let at = DVec2::new(point.u, point.v).min(DVec2::splat(1f64.next_down()));
        let run = self.cells.partition_point(|pieces| pieces.cell.light < light);
        let holds = |pieces: &Pieces| pieces.cell.holds(at);
        let cell = run + self.cells[run..].iter().take_while(|p| p.cell.light == light).position(holds)?;
        let Pieces { first, before, .. } = self.cells[cell];
        let end = self.cells.get(cell + 1).map_or(self.place.len(), |next| next.before as usize);
        // The two triangles of a parallelogram are one piece.
        let piece = ((before + index.saturating_sub(first)) as usize).min(end - 1);
        Some(self.place[piece] as usize)
    }

    /// Goes from the root to a leaf by the parts that `choose` takes, given the ends of the first three and the probabilities of
    /// all; returns the leaf's place and the product of the probabilities.
    #[inline]
    fn descend(&self, vertex: &Vertex, mut choose: impl FnMut([usize; 3], Vec4) -> usize) -> (usize, f64) {
        let (mut first, mut last, mut node, mut probability) = (0, self.leaves.len(), 0, 1.0);
        while last - first > 1 {
            let (ends, probabilities) = (quarters(first, last), self.nodes[node].probabilities(vertex));
            let part = choose([ends[1], ends[2], ends[3]], probabilities);
            probability *= f64::from(probabilities[part]);
            (first, last, node) = (ends[part], ends[part + 1], self.nodes[node].below[part] as usize);
        }
        (first, probability)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform};
    use crate::transport::colour::Rgb;
    use crate::transport::lights::region::LightRegion;
    use crate::transport::lights::strata::{LightStrata, Stratification};
    use crate::transport::scene::Scene;
    use crate::transport::tests::worlds::{World, lamps, lamps_and_sky, outdoors, rough_metal, suns};
    use glam::{DVec3, Vec3A};
    use rand_pcg::rand_core::Rng;

    fn vertices(world: &World) -> Vec<Vertex> {
        let mut rng = generator(1, Purpose::Sample, 0, 0, 0);
        let mut direction = || DVec3::from_array([0; 3].map(|_| uniform(&mut rng) - 0.5)).normalize().as_vec3a();
        (0..60).filter_map(|_| world.scene.trace(&world.camera.vertex(), direction())).collect()
    }

    fn points(rng: &mut impl Rng) -> [f64; 2] {
        [uniform(rng), uniform(rng)]
    }

    fn number(scene: &Scene, point: &LightPoint) -> (u32, u32) {
        scene.lights().number(scene.light_point(point).1.primitive).unwrap()
    }

    /// All lights, some in one part of which the ball of light is cut, and parts of one or few pieces.
    fn regions(world: &World) -> Vec<LightRegion> {
        let cuts = [1, 3, 9].map(Stratification::Count).into_iter().chain([Stratification::Grid(7, 1)]);
        cuts.flat_map(|cut| LightStrata::new(world.scene.lights(), cut).regions().to_vec()).collect()
    }

    #[test]
    fn a_points_density_is_that_which_it_was_drawn_with() {
        for (world, least) in
            [(lamps(), 1000), (lamps_and_sky(), 100), (outdoors(rough_metal()), 100), (suns(rough_metal()), 100)]
        {
            check_densities(&world, least);
        }
    }

    /// `least`: points of other regions that are to be met.
    fn check_densities(world: &World, least: u32) {
        let (mut rng, mut elsewhere) = (generator(2, Purpose::Sample, 0, 0, 0), 0);
        let whole = LightRegion::whole(world.scene.lights());
        for region in regions(world) {
            let tree = region.light_sampler();
            for vertex in vertices(world).into_iter().step_by(3) {
                for _ in 0..10 {
                    let [u, v] = points(&mut rng);
                    let (point, density) = tree.sample(&vertex, u, v);
                    let again = tree.density(&vertex, number(&world.scene, &point), &point);
                    assert!((density / again - 1.0).abs() < 1e-6, "{density} {again}");
                    let point = whole.sample(u, v);
                    let inside =
                        region.cells().iter().any(|c| c.light == point.light && c.holds([point.u, point.v].into()));
                    elsewhere += u32::from(!inside);
                    assert!(inside || tree.density(&vertex, number(&world.scene, &point), &point) == 0.0, "{point:?}");
                }
            }
        }
        assert!(elsewhere > least, "{elsewhere}");
    }

    /// Over points of density q, the mean of p/q is ∫ p dA = 1; and p is zero only where the light shows its back.
    #[test]
    fn densities_integrate_to_one_and_miss_no_light() {
        let unseen = [lamps(), lamps_and_sky(), outdoors(rough_metal())].map(|world| check_integral(&world));
        assert!(unseen[0] > 300, "{unseen:?}");
    }

    /// Returns how many points a vertex is not lit by.
    fn check_integral(world: &World) -> u32 {
        let mut rng = generator(3, Purpose::Sample, 0, 0, 0);
        let (n, mut unseen) = (1000, 0);
        for region in regions(world) {
            let tree = region.light_sampler();
            for vertex in vertices(world).into_iter().step_by(4) {
                let [mut sum, mut squares] = [0.0; 2];
                for _ in 0..n {
                    let [u, v] = points(&mut rng);
                    let point = region.sample(u, v);
                    let (light, source) = world.scene.light_point(&point);
                    let density = tree.density(&vertex, number(&world.scene, &point), &point);
                    let to_vertex = (vertex.position - source.position).normalize();
                    if density == 0.0 {
                        unseen += 1;
                        assert_eq!(world.scene.emitted(&source, to_vertex), Rgb::ZERO, "{vertex:?} {source:?}");
                    }
                    let ratio = density * region.power() / light.mean_exitance();
                    (sum, squares) = (sum + ratio, squares + ratio * ratio);
                }
                let (mean, n) = (sum / f64::from(n), f64::from(n));
                let error = ((squares / n - mean * mean).max(0.0) / n).sqrt();
                assert!(
                    (mean - 1.0).abs() < 4.5 * error + 1e-6,
                    "{mean} ± {error} at {vertex:?} of {:?}",
                    region.cells()
                );
            }
        }
        unseen
    }

    #[test]
    fn near_lights_are_preferred() {
        let world = lamps();
        let region = LightRegion::whole(world.scene.lights());
        let tree = region.light_sampler();
        // Beside the small ball of light.
        let near = Vertex { position: Vec3A::new(0.3, 0.3, -0.4), ..vertices(&world)[0] };
        let mut rng = generator(4, Purpose::Sample, 0, 0, 0);
        let drawn = |light: u32, rng: &mut _| {
            let hits = (0..2000).filter(|_| {
                let [u, v] = points(rng);
                tree.sample(&near, u, v).0.light == light
            });
            hits.count() as f64 / 2000.0
        };
        // The box's own lamp is the first light.
        let by_power = world.scene.lights().lights[1].power() / world.scene.lights().power();
        assert!(drawn(1, &mut rng) > 2.0 * by_power, "{near:?}");
    }
}
