//! Camera rays that come to a given point by given reflections and refractions.
//!
//! With these given, the ray after the last of them, from o into the direction ω, is a function of the film point x. Newton's method solves
//! m(x) = ω − (y* − o)/|y* − o| = 0 for a point y*, whatever the rays on the way meet; its slopes are differences of rays that are traced. Where
//! the surfaces around are smooth, x is found to within rounding. The slopes also tell how large the surroundings of y* are on the film.
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
const STEPS: [usize; 2] = [8, 4];
/// |m| that is small enough, over the extent of the surroundings of y* as seen from o; and the distance of what the ray meets from y*, over
/// their extent.
const NEAR: [f64; 2] = [0.25, 4.0];

/// y*: a point, or a direction of light from infinitely far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    pub(super) at: DVec3,
    pub(super) is_distant: bool,
    /// Extent of its surroundings: a length, or an angle in radians.
    pub(super) extent: f64,
    /// Whether it is the place of a photon.
    pub(super) is_photon: bool,
}

/// A camera ray by way of specular surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Material of the surface that it meets first.
    pub(super) first: u32,
    pub(super) events: Events,
    /// Probability that a camera subpath chooses these events.
    pub(super) probability: f64,
    /// x.
    pub(super) film: DVec2,
    /// Key of the random numbers by which surfaces that are not opaque let it pass.
    key: u64,
    /// Where its last part begins, and where to.
    last: [Vec3A; 2],
    /// The vertex that it meets then; `None` if it leaves the scene.
    pub(super) end: Option<Vertex>,
}

impl Goal {
    /// |m| over the extent of the surroundings.
    pub(super) fn distance(&self, sight: &Sight) -> f64 {
        sight.miss(self).length() / sight.extent(self)
    }

    /// Whether a ray towards it is not stopped before, and does not go on.
    fn is_met(&self, sight: &Sight) -> bool {
        let near = |end: &Vertex| (end.position.as_dvec3() - self.at).length() <= NEAR[1] * self.extent;
        sight.end.is_some_and(|end| !end.delta && end.is_distant() == self.is_distant && near(&end))
    }
}

impl Sight {
    /// The ray of a key through a film point, by the events that `refracts` chooses at specular surfaces until it says nothing; `None` if there
    /// are too many.
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
        let mut last = [ray.origin, ray.direction()];
        let (start, _) = view.scene.follow_camera_ray(last[0], last[1], rng)?;
        let (mut end, mut events, mut probability) = (Some(start), Events::default(), 1.0);
        while let Some(x) = end.filter(|x| x.delta) {
            let to_eye = -last[1];
            let Some(refracts) = refracts(events.len(), &x, to_eye) else { break };
            events = events.with(refracts)?;
            let mut room = Resolved::default();
            let surface = view.scene.surface(&x, &mut room);
            let next = surface.delta_direction(to_eye, refracts)?;
            probability *= f64::from(surface.event_probability(to_eye, next));
            last = [x.position, next];
            end = view.scene.follow(&x, next, rng).map(|(end, _)| end);
        }
        Some(Self { first: start.material, events, probability, film, key, last, end })
    }

    /// The ray through another film point with the same events, wherever it ends.
    fn through(&self, view: &View, film: DVec2) -> Option<Self> {
        let moved = Self::new(view, (film, self.key), |number, _, _| self.events.get(number))?;
        ((moved.events, moved.first) == (self.events, self.first)).then_some(moved)
    }

    /// y* − o, or its direction if that is all it is.
    fn way(&self, goal: &Goal) -> DVec3 {
        if goal.is_distant { goal.at } else { goal.at - self.last[0].as_dvec3() }
    }

    /// m.
    fn miss(&self, goal: &Goal) -> DVec3 {
        let way = self.way(goal);
        self.last[1].as_dvec3() - way / way.length()
    }

    /// The extent of a goal's surroundings as seen from o, radians.
    pub(super) fn extent(&self, goal: &Goal) -> f64 {
        goal.extent / self.way(goal).length()
    }

    /// A ray that ends near a goal, found from this one, and ∂m/∂x there.
    pub(super) fn aimed(mut self, view: &View, goal: &Goal) -> Option<(Self, [DVec3; 2])> {
        for _ in 0..STEPS[0] {
            let slopes = self.slopes(view, goal)?;
            if goal.distance(&self) <= NEAR[0] {
                return goal.is_met(&self).then_some((self, slopes));
            }
            self = self.nearer(view, goal, slopes)?;
        }
        None
    }

    /// A step of Newton's method, or a part of it, by which the ray comes nearer.
    fn nearer(&self, view: &View, goal: &Goal, [a, b]: [DVec3; 2]) -> Option<Self> {
        let rest = -self.miss(goal);
        // The least squares of a s + b t = rest.
        let (of_a, of_b, mixed) = (a.length_squared(), b.length_squared(), a.dot(b));
        let determinant = of_a * of_b - mixed * mixed;
        let [to_a, to_b] = [a.dot(rest), b.dot(rest)];
        let mut step = DVec2::new(of_b * to_a - mixed * to_b, of_a * to_b - mixed * to_a) / determinant;
        for _ in 0..STEPS[1] {
            let moved = self.through(view, self.film + step);
            if let Some(moved) = moved.filter(|moved| moved.miss(goal).length() < rest.length()) {
                return Some(moved);
            }
            step *= 0.5;
        }
        None
    }

    /// ∂m/∂x, from differences to the right and below, or to the left and above where nothing is there.
    fn slopes(&self, view: &View, goal: &Goal) -> Option<[DVec3; 2]> {
        let slope = |step: DVec2| {
            let there = self.through(view, self.film + step)?;
            Some((there.miss(goal) - self.miss(goal)) / step.element_sum())
        };
        let along = |axis: DVec2| slope(STEP * axis).or_else(|| slope(-STEP * axis));
        Some([along(DVec2::X)?, along(DVec2::Y)?])
    }
}
