//! Which point of the lights is drawn for a vertex: next-event estimation with trees over the pieces of the lights.
//!
//! A piece is a light's parallelogram, one triangle of a light, or all directions that a distant light is seen in, as far as it
//! lies in a cell of the region that points are drawn on. The nodes of a tree know where their parts lie; a walk from the root takes each
//! part in proportion to the irradiance that it might send to the vertex. Near lights and distant ones have a tree each.
//!
//! Source: [ContyKulla18], "Importance Sampling of Many Lights with Adaptive Tree Splitting", section 5.

mod bound;
mod content;
mod directions;
mod node;
mod receiver;
mod tree;

use super::cell::Cell;
use crate::transport::scene::{LightPoint, Lights};
use bound::Bound;
use directions::Directions;
use glam::{DVec2, Vec4};
use node::Node;
use tree::Tree;

pub use receiver::Receiver;

/// The trees over the pieces of a region.
#[derive(Clone, Debug)]
pub struct LightSampler {
    near: Tree,
    afar: Tree,
    /// Σ Φ/R² of distant lights: the irradiance that they send, in units in which a near light's is Φ cosθ cosθ'/d².
    irradiance: f64,
}

impl LightSampler {
    /// Builds the trees over disjoint cells, those of a light in one run and the lights in the order of their numbers.
    pub(crate) fn new(lights: &Lights, cells: &[Cell]) -> Self {
        let radius = |cell: &Cell| lights.lights[cell.light as usize].radius_around();
        let near = Tree::new::<Bound>(lights, cells.iter().filter(|cell| radius(cell).is_none()).copied());
        let afar = Tree::new::<Directions>(lights, cells.iter().filter(|cell| radius(cell).is_some()).copied());
        let irradiance = |cell| Some(Cell::power(cell, &lights.lights) / f64::from(radius(cell)?).powi(2));
        Self { near, afar, irradiance: cells.iter().filter_map(irradiance).sum() }
    }

    /// Whether there is more than one piece: else points are uniform over it, whatever the vertex.
    #[inline]
    pub fn has_choice(&self) -> bool {
        self.near.len() + self.afar.len() > 1
    }

    /// A point for a vertex from two uniform numbers, and its density in its light's measure, in the mean over the piece: to be multiplied
    /// by the point's exitance over its light's mean.
    #[inline(always)]
    pub fn sample(&self, receiver: &Receiver, [u, v]: [f64; 2]) -> (LightPoint, f64) {
        if self.afar.len() > 0 {
            self.sample_all(*receiver, [u, v])
        } else {
            self.near.sample(from_near(receiver), u, v)
        }
    }

    /// The same with distant lights among the others.
    #[inline(never)]
    fn sample_all(&self, receiver: Receiver, [u, v]: [f64; 2]) -> (LightPoint, f64) {
        let weigh = from_afar(&receiver);
        let share = self.share_from_afar(&receiver, &weigh);
        if u < share {
            let (point, density) = self.afar.sample(weigh, u / share, v);
            return (point, share * density);
        }
        let rest = 1.0 - share;
        let (point, density) = self.near.sample(from_near(&receiver), ((u - share) / rest).min(1f64.next_down()), v);
        (point, rest * density)
    }

    /// The density that [`sample`](Self::sample) tells of a point that it draws, given the point's light and the number of its triangle
    /// within that light; 0 for a point that is not in the region. Its place in the light's unit square is asked for only where the light is
    /// not one cell.
    #[inline]
    pub fn density(&self, receiver: &Receiver, number: (u32, u32), place: impl FnOnce() -> DVec2) -> f64 {
        if self.afar.len() > 0 {
            return self.density_of_all(*receiver, number, place);
        }
        self.near.density(from_near(receiver), number, place)
    }

    /// The same with distant lights among the others.
    #[inline(never)]
    fn density_of_all(&self, receiver: Receiver, number: (u32, u32), place: impl FnOnce() -> DVec2) -> f64 {
        let weigh = from_afar(&receiver);
        let share = self.share_from_afar(&receiver, &weigh);
        if self.afar.holds(number.0) {
            share * self.afar.density(weigh, number, place)
        } else {
            (1.0 - share) * self.near.density(from_near(&receiver), number, place)
        }
    }

    /// Probability of drawing a point on a distant light.
    fn share_from_afar(&self, receiver: &Receiver, weigh: impl Fn(&Node) -> Vec4) -> f64 {
        if self.near.len() == 0 {
            return 1.0;
        }
        let afar = self.afar.weight(weigh) * self.irradiance;
        let near = self.near.weight(from_near(receiver)) * self.near.power;
        let all = afar + near;
        if all > 0.0 && all.is_finite() { afar / all } else { self.afar.power / (self.afar.power + self.near.power) }
    }
}

/// Weights of the parts of a node for a vertex.
#[inline(always)]
fn from_near(receiver: &Receiver) -> impl Fn(&Node) -> Vec4 {
    let (position, normal) = (receiver.vertex.position, receiver.vertex.shading_normal);
    move |node| node.irradiance(position, normal)
}

/// The same from infinitely far away.
#[inline(always)]
fn from_afar(receiver: &Receiver) -> impl Fn(&Node) -> Vec4 {
    let (normal, both_sides) = receiver.lit_side();
    move |node| node.irradiance_from_afar(normal, both_sides)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform};
    use crate::transport::colour::Rgb;
    use crate::transport::geometry::Vertex;
    use crate::transport::lights::region::LightRegion;
    use crate::transport::lights::strata::{LightStrata, Stratification};
    use crate::transport::tests::worlds::{World, glass, lamps, lamps_and_sky, outdoors, rough_metal, suns};
    use glam::{DVec3, Vec2, Vec3A};
    use rand_pcg::rand_core::Rng;

    fn vertices(world: &World) -> Vec<Vertex> {
        let mut rng = generator(1, Purpose::Sample, 0, 0, 0);
        let mut direction = || DVec3::from_array([0; 3].map(|_| uniform(&mut rng) - 0.5)).normalize().as_vec3a();
        (0..60).filter_map(|_| world.scene.trace(&world.camera.vertex(), direction())).collect()
    }

    fn points(rng: &mut impl Rng) -> [f64; 2] {
        [uniform(rng), uniform(rng)]
    }

    /// The side of a vertex that a point of the lights is on.
    fn towards<'a>(world: &'a World, vertex: &Vertex, point: &LightPoint) -> Receiver<'a> {
        Receiver::of_light(&world.scene, &world.scene.light_point(point).1, vertex)
    }

    /// Whether a point is on the side that is asked about, or of a vertex that has two.
    fn lit(receiver: &Receiver, point: &LightPoint) -> bool {
        let other = Receiver::of_light(receiver.scene, &receiver.scene.light_point(point).1, &receiver.vertex);
        receiver.lit_side().1 || receiver.lit_side() == other.lit_side()
    }

    fn density_at(sampler: &LightSampler, receiver: &Receiver, point: &LightPoint) -> f64 {
        let scene = receiver.scene;
        let number = scene.lights().number(scene.light_point(point).1.primitive).unwrap();
        sampler.density(receiver, number, || point.place())
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
                    let to_eye = world.camera.vertex().position - vertex.position;
                    let receiver = Receiver { scene: &world.scene, vertex, towards: to_eye };
                    let (point, density) = tree.sample(&receiver, [u, v]);
                    let again = density_at(tree, &towards(world, &vertex, &point), &point);
                    let same = (density / again - 1.0).abs() < 1e-6;
                    assert!(same || !lit(&receiver, &point), "{density} {again}");
                    let point = whole.sample(u, v);
                    let inside =
                        region.cells().iter().any(|c| c.light == point.light && c.holds([point.u, point.v].into()));
                    elsewhere += u32::from(!inside);
                    assert!(inside || density_at(tree, &towards(world, &vertex, &point), &point) == 0.0, "{point:?}");
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
                let receiver = Receiver { scene: &world.scene, vertex, towards: vertex.shading_normal };
                let [mut sum, mut squares] = [0.0; 2];
                for _ in 0..n {
                    let [u, v] = points(&mut rng);
                    let point = region.sample(u, v);
                    let (light, source) = world.scene.light_point(&point);
                    let density = density_at(tree, &receiver, &point);
                    let to_vertex = match source.is_distant() {
                        true => -source.position,
                        false => (vertex.position - source.position).normalize(),
                    };
                    if density == 0.0 {
                        unseen += 1;
                        if !lit(&receiver, &point) {
                            continue;
                        }
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

    /// Share of points on suns among those that are drawn for the ball of a world, seen from before or from behind its surface.
    fn share_of_suns(world: &World, from_behind: bool) -> f64 {
        let seen = |i: u32| {
            let film = (Vec2::new((i % 16) as f32, (i / 16) as f32) + 0.5) / 16.0;
            let ray = world.camera.sample(film, &world.camera.vertex());
            world.scene.trace_ray(ray.origin, ray.direction())
        };
        let on_ball = |vertex: &Vertex| vertex.shading_normal != vertex.geometric_normal;
        let vertex = (0..256).filter_map(seen).find(on_ball).unwrap();
        let region = LightRegion::whole(world.scene.lights());
        let towards = if from_behind { -vertex.shading_normal } else { vertex.shading_normal };
        let receiver = Receiver { scene: &world.scene, vertex, towards };
        let sun = |light: u32| world.scene.lights().lights[light as usize].measure < 1.0;
        let mut rng = generator(5, Purpose::Sample, 0, 0, 0);
        let drawn =
            (0..2000).filter(|_| sun(region.light_sampler().sample(&receiver, points(&mut rng)).0.light)).count();
        drawn as f64 / 2000.0
    }

    /// All suns are before the ball; that glass has no side is the control.
    #[test]
    fn suns_behind_a_surface_are_not_drawn_unless_light_passes_it() {
        let shares = |bsdf| [false, true].map(|from_behind| share_of_suns(&suns(bsdf), from_behind));
        let ([before, behind], [outside, inside]) = (shares(rough_metal()), shares(glass(0.5)));
        assert!(before > 0.5 && behind < 0.2 * before, "{before}, {behind}");
        assert!(outside == inside && outside > 0.5, "{outside}, {inside}");
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
                let receiver = Receiver { scene: &world.scene, vertex: near, towards: near.shading_normal };
                tree.sample(&receiver, [u, v]).0.light == light
            });
            hits.count() as f64 / 2000.0
        };
        // The box's own lamp is the first light.
        let by_power = world.scene.lights().lights[1].power() / world.scene.lights().power();
        assert!(drawn(1, &mut rng) > 2.0 * by_power, "{near:?}");
    }
}
