//! Camera rays that come to a given point by given reflections and refractions.
//!
//! With these given, the place y where a camera ray meets the first surface that is not specular is a function of the film point x. Newton's
//! method solves y(x) = y*; its slopes are differences of rays that are traced. Where the surfaces around are smooth, x is found to
//! within rounding from anywhere near. The slopes also tell how large the surroundings of y* are on the film.
//!
//! Source: [JakobMarschner12] solve the same equation for the vertices of a path, by the derivatives of the surfaces.

use super::events::Events;
use crate::engine::{Purpose, generator};
use crate::transport::geometry::Vertex;
use crate::transport::scene::{Resolved, View};
use glam::{DVec2, DVec3, Vec3A};

/// Step of differences, in widths of the film.
const STEP: f64 = 1e-5;
/// Most steps of Newton's method, and most halvings of each.
const STEPS: [usize; 2] = [12, 6];
/// Distance from y* that is near enough, over the extent of its surroundings.
const NEAR: f64 = 0.25;

/// y*: a point, or a direction of light from infinitely far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    pub(super) at: DVec3,
    pub(super) is_distant: bool,
    /// Extent of its surroundings: a length, or an angle in radians.
    pub(super) extent: f64,
}

/// A camera ray that comes through specular surfaces to one that is not, or to a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub(super) events: Events,
    /// Probability that a camera subpath chooses these events.
    pub(super) probability: f64,
    /// x.
    pub(super) film: DVec2,
    /// Key of the random numbers by which surfaces that are not opaque let it pass.
    key: u64,
    /// Where it ends.
    pub(super) end: Vertex,
}

impl Goal {
    /// How far from it a ray ends; infinitely far if one is a direction and the other is not.
    pub(super) fn distance(&self, end: &Vertex) -> f64 {
        if end.is_distant() == self.is_distant { (end.position.as_dvec3() - self.at).length() } else { f64::INFINITY }
    }
}

impl Sight {
    /// The ray of a key through a film point, at whose specular surfaces `refracts` chooses, if it has so many; `None` if it leaves the scene, or goes
    /// on for ever.
    pub(super) fn new(
        view: &View,
        (film, key): (DVec2, u64),
        mut refracts: impl FnMut(usize, &Vertex, Vec3A) -> Option<bool>,
    ) -> Option<Self> {
        if !(film.cmpge(DVec2::ZERO).all() && film.cmplt(DVec2::ONE).all()) {
            return None;
        }
        let rng = &mut generator(key, Purpose::Sample, 0, 0, 0);
        let ray = view.camera.sample(film.as_vec2(), &view.camera.vertex());
        let mut direction = ray.direction();
        let (mut end, _) = view.scene.follow_camera_ray(ray.origin, direction, rng)?;
        let (mut events, mut probability) = (Events::default(), 1.0);
        while end.delta {
            let refracts = refracts(events.len(), &end, -direction)?;
            events = events.with(refracts)?;
            let mut room = Resolved::default();
            let surface = view.scene.surface(&end, &mut room);
            let next = surface.delta_direction(-direction, refracts)?;
            probability *= f64::from(surface.event_probability(-direction, next));
            (end, _) = view.scene.follow(&end, next, rng)?;
            direction = next;
        }
        Some(Self { events, probability, film, key, end })
    }

    /// The ray through another film point with the same events.
    fn through(&self, view: &View, film: DVec2) -> Option<Self> {
        let moved = Self::new(view, (film, self.key), |number, _, _| self.events.get(number))?;
        (moved.events == self.events).then_some(moved)
    }

    /// A ray that ends near a goal, found from this one, and ∂y/∂x there.
    pub(super) fn aimed(mut self, view: &View, goal: &Goal) -> Option<(Self, [DVec3; 2])> {
        for _ in 0..STEPS[0] {
            let slopes = self.slopes(view)?;
            if goal.distance(&self.end) <= NEAR * goal.extent {
                return Some((self, slopes));
            }
            self = self.nearer(view, goal, slopes)?;
        }
        None
    }

    /// A step of Newton's method, or a part of it, by which the ray comes nearer.
    fn nearer(&self, view: &View, goal: &Goal, [a, b]: [DVec3; 2]) -> Option<Self> {
        let rest = goal.at - self.end.position.as_dvec3();
        // The least squares of a s + b t = rest.
        let (of_a, of_b, mixed) = (a.length_squared(), b.length_squared(), a.dot(b));
        let determinant = of_a * of_b - mixed * mixed;
        let [to_a, to_b] = [a.dot(rest), b.dot(rest)];
        let mut step = DVec2::new(of_b * to_a - mixed * to_b, of_a * to_b - mixed * to_a) / determinant;
        let distance = goal.distance(&self.end);
        for _ in 0..STEPS[1] {
            let moved = self.through(view, self.film + step).filter(|moved| goal.distance(&moved.end) < distance);
            if moved.is_some() {
                return moved;
            }
            step *= 0.5;
        }
        None
    }

    /// ∂y/∂x, from differences to the right and below, or to the left and above where nothing is there.
    fn slopes(&self, view: &View) -> Option<[DVec3; 2]> {
        let slope = |step: DVec2| {
            let there = self.through(view, self.film + step)?;
            let same = there.end.is_distant() == self.end.is_distant();
            same.then(|| (there.end.position - self.end.position).as_dvec3() / step.element_sum())
        };
        let along = |axis: DVec2| slope(STEP * axis).or_else(|| slope(-STEP * axis));
        Some([along(DVec2::X)?, along(DVec2::Y)?])
    }
}
