//! Light subpaths by way of specular surfaces to the first that is not.

use super::events::{Events, is_refraction};
use super::lobe::Lobe;
use super::place::{Photon, Place};
use crate::engine::{uniform, uniform_f32};
use crate::transport::lights::LightRegion;
use crate::transport::paths::PathVertex;
use crate::transport::paths::subpath::{follow_from_light, light_numbers, start_at_light, step_from_light};
use crate::transport::scene::{Resolved, View};
use glam::Vec3A;
use rand_pcg::rand_core::Rng;

/// Angle between the first edges of two walks, radians: few are as wide.
const ANGLE: f32 = 0.1;

/// A light subpath that ends as a photon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    x_0: PathVertex,
    /// Its first edge: origin, direction, length.
    edge: (Vec3A, Vec3A, f32),
    events: Events,
    /// Material of the last specular vertex.
    material: u32,
    pub(super) photon: Photon,
}

/// Events and the material of the last specular vertex, which photons of one tree share.
pub(super) type Way = (Events, u32);

impl Walk {
    /// See [`Way`].
    pub(super) fn way(&self) -> Way {
        (self.events, self.material)
    }
}

/// How a walk goes on at a specular surface.
#[derive(Clone, Copy, Debug)]
enum Choice {
    /// As light does.
    Scattered,
    /// By one of both events, evenly if both are possible.
    Even,
    /// By these events.
    Given(Events),
}

/// Draws walks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walker<'a> {
    pub(super) view: &'a View<'a>,
    pub(super) lights: &'a LightRegion,
    pub(super) max_edges: usize,
}

impl Walker<'_> {
    /// A walk that begins anywhere. `even`: reflection and refraction are chosen evenly, so that rare ones have photons, too.
    pub(super) fn any(&self, even: bool, rng: &mut impl Rng) -> Option<Walk> {
        let (x_0, _) = start_at_light(self.view, self.lights, light_numbers(rng));
        let ray = self.view.scene.sample_emission(&x_0.vertex, rng);
        self.follow(x_0, ray, if even { Choice::Even } else { Choice::Scattered }, rng)
    }

    /// A walk by the events of another one, or the first of them, from the same point in nearly the same direction; from nearly the same point of the disc for a
    /// distant light.
    pub(super) fn near(&self, other: &Walk, rng: &mut impl Rng) -> Option<Walk> {
        let (origin, direction, length) = other.edge;
        let angle = ANGLE * uniform_f32(rng).powi(3);
        let turned = Lobe::towards(direction, 0.5 * angle * angle).sample(uniform_f32(rng), uniform_f32(rng));
        let x = &other.x_0.vertex;
        let ray = match x.is_distant() {
            true => (origin + length * (turned - direction), direction),
            false => x.ray(turned),
        };
        self.follow(other.x_0, ray, Choice::Given(other.events), rng)
    }

    /// A walk that begins with a ray.
    fn follow(&self, x_0: PathVertex, ray: (Vec3A, Vec3A), choice: Choice, rng: &mut impl Rng) -> Option<Walk> {
        let (mut vertices, mut events) = (vec![x_0], Events::default());
        for i in 0..self.max_edges.saturating_sub(1).min(Events::MOST + 1) {
            vertices.push(PathVertex::new(x_0.vertex));
            if i == 0 {
                follow_from_light(&mut vertices, 0, ray, self.view, rng)?;
            } else {
                self.step(&mut vertices, i, choice, rng)?;
                events = events.with(is_refraction(&vertices[i], -vertices[i - 1].to_eye))?;
            }
            let [from, x] = [vertices[i].vertex, vertices[i + 1].vertex];
            if !x.delta {
                let photon = Photon { at: Place::of(&x), from: from.position };
                let edge = (ray.0, ray.1, vertices[1].vertex.position.distance(ray.0));
                let material = from.material;
                return (i > 0).then_some(Walk { x_0, edge, events, material, photon });
            }
        }
        None
    }

    /// Draws x_{i+1} from x_i, which is specular.
    fn step(&self, vertices: &mut [PathVertex], i: usize, choice: Choice, rng: &mut impl Rng) -> Option<()> {
        let (x, to_light) = (&vertices[i].vertex, -vertices[i - 1].to_eye);
        let mut room = Resolved::default();
        let surface = self.view.scene.surface(x, &mut room);
        let direction = match choice {
            Choice::Scattered => return step_from_light(vertices, i, self.view, rng),
            Choice::Even => {
                let refracts = uniform(rng) < 0.5;
                surface.delta_direction(to_light, refracts).or_else(|| surface.delta_direction(to_light, !refracts))?
            }
            Choice::Given(events) => surface.delta_direction(to_light, events.get(i - 1)?)?,
        };
        let ray = x.ray(direction);
        follow_from_light(vertices, i, ray, self.view, rng)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator};
    use crate::transport::tests::worlds::{glass, room};

    /// Walks near others end as photons far more often than others, by the same events, and not far away.
    #[test]
    fn walks_near_others_end_like_them() {
        let world = room(glass(0.0), true);
        let lights = LightRegion::whole(world.scene.lights());
        let walker = Walker { view: &world.view(), lights: &lights, max_edges: 9 };
        let found: Vec<_> =
            (0..2000).filter_map(|i| walker.any(true, &mut generator(1, Purpose::Sample, 0, 0, i))).collect();
        let near = found.iter().zip(0..).map(|(walk, i)| {
            let near = walker.near(walk, &mut generator(2, Purpose::Sample, 0, 0, i))?;
            assert_eq!(near.events, walk.events);
            Some(near.photon.at.position.distance(walk.photon.at.position))
        });
        let near: Vec<_> = near.flatten().collect();
        let close = near.iter().filter(|distance| **distance < 0.1).count();
        assert!(found.len() > 50 && near.len() > found.len() / 2, "{} of {} of 2000", near.len(), found.len());
        assert!(found.len() < 1000 && close > near.len() / 2, "{close} of {}", near.len());
    }
}
