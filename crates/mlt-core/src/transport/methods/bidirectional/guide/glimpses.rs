//! Where light that only chance meets is seen: film points and events of camera subpaths that come to it.
//!
//! A curved mirror shows a lamp as a glint, and a caustic as a bright spot at its rim, which may be a thousandth of a pixel. A reflection in
//! glass may be one of ten thousand choices besides. Random camera subpaths meet either once in many renders, but surely meet the surfaces that show
//! it: from there it is aimed at ([`Sight`]). Glimpses are found: events e_k, from the eye on, and a lobe q_k of film points. A
//! quarter of the camera subpaths take theirs from one of K glimpses, which makes a path with film point x and events e, which a subpath chooses with
//! probability P,
//!
//! r(x) = ¾ + ¼ A/(K P) Σ_{k: e_k = e} q_k(x),   q(x) = 1/(2π |Σ|^½ (1 + (x − x̄)ᵀ Σ⁻¹ (x − x̄))^(3/2))                    (G2)
//!
//! times as likely as without glimpses, if A is the part of the film that other subpaths are drawn from. q is a Cauchy distribution of the plane,
//! with x̄ where the ray comes to its goal and Σ what the slopes make of the goal's extent.
//!
//! docs/theory-strata.md, section 8.

use super::aim::{Goal, Sight};
use super::events::Events;
use super::photons::Photons;
use crate::engine::{PILOT, Purpose, generator, uniform, uniform_f32};
use crate::transport::geometry::hilbert;
use crate::transport::geometry::math::turn;
use crate::transport::lights::LightRegion;
use crate::transport::methods::settings::Settings;
use crate::transport::paths::LightPath;
use crate::transport::scene::{Resolved, View, rays_traced};
use glam::{DVec2, DVec3, Vec2};
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Camera rays for a sample of a round, and fewest and most of them: they take a small part of its time.
const SIGHTS_PER_SAMPLE: f64 = 1.0;
const LIMITS: [f64; 2] = [1024.0, 65_536.0];
/// Goals of each kind for a sample of a round, and fewest and most of them.
const GOALS_PER_SAMPLE: f64 = 1.0 / 1024.0;
const GOAL_LIMITS: [f64; 2] = [80.0, 256.0];
/// Most groups of rays.
const MOST_GROUPS: usize = 32;
/// Least probability of events: no render has many more camera subpaths.
const LEAST_PROBABILITY: f64 = 1e-7;
/// Parts of the film that lights and every other photon are aimed at from by turns, so that each of several balls shows them: points of a small light
/// would all begin with the same ray.
const TURNS: usize = 48;
/// Least and largest width of a lobe, in widths of the film.
const WIDTHS: [f64; 2] = [4e-6, 0.05];
/// Number of a round that nothing else has.
const ROUND: u64 = PILOT + (1 << 42);

/// Glimpses of lights, and of surfaces that are lit through specular ones.
#[derive(Clone, Debug, Default)]
pub(in crate::transport::methods::bidirectional) struct Glimpses {
    /// Sorted by events.
    list: Vec<Glimpse>,
}

/// One of them.
#[derive(Clone, Copy, Debug)]
struct Glimpse {
    events: Events,
    /// x̄.
    middle: DVec2,
    /// L_00, L_10 and L_11 of Σ = L Lᵀ.
    root: [f64; 3],
}

impl Glimpse {
    /// Of the surroundings of a goal, as large as the slopes a and b of a ray that ends there make them.
    fn new(sight: &Sight, [a, b]: [DVec3; 2], goal: &Goal) -> Option<Self> {
        let square = sight.extent(goal) * sight.extent(goal);
        let least = square / (WIDTHS[1] * WIDTHS[1]);
        let [of_a, of_b, mixed] = [a.length_squared() + least, b.length_squared() + least, a.dot(b)];
        let scale = square / (of_a * of_b - mixed * mixed);
        let narrow = WIDTHS[0] * WIDTHS[0];
        let [xx, xy, yy] = [scale * of_b + narrow, -scale * mixed, scale * of_a + narrow];
        let first = xx.sqrt();
        let below = xy / first;
        let second = (yy - below * below).sqrt();
        let glimpse = Self { events: sight.events, middle: sight.film, root: [first, below, second] };
        (second > 0.0 && second.is_finite() && first.is_finite()).then_some(glimpse)
    }

    /// q.
    fn density(&self, film: DVec2) -> f64 {
        let ([first, below, second], step) = (self.root, film - self.middle);
        let x = step.x / first;
        let y = (step.y - below * x) / second;
        let square = 1.0 + x * x + y * y;
        (2.0 * PI * first * second * square * square.sqrt()).recip()
    }

    /// By inversion of the distribution of the distance, 1 − 1/√(1 + d²).
    fn sample(&self, u: f64, v: f32) -> DVec2 {
        let ([first, below, second], about) = (self.root, turn(v).as_dvec2());
        let rest = 1.0 - u;
        let DVec2 { x, y } = (1.0 / (rest * rest) - 1.0).sqrt() * about;
        self.middle + DVec2::new(first * x, below * x + second * y)
    }
}

impl Glimpses {
    /// For a render, and the rays that it took.
    pub(super) fn new(view: &View, settings: &Settings, lights: &LightRegion, photons: &Photons) -> (Self, u64) {
        let samples = settings.per_pixel * f64::from(view.camera.pixels());
        let sights = (SIGHTS_PER_SAMPLE * samples).clamp(LIMITS[0], LIMITS[1]) as u64;
        let goals = (GOALS_PER_SAMPLE * samples).clamp(GOAL_LIMITS[0], GOAL_LIMITS[1]) as usize;
        let (sights, of_sights) = sights_at_random(view, (sights, settings.most_edges()), settings.seed);
        let goals = goals_of(view, lights, photons, goals, settings.seed);
        let (glimpses, of_glimpses) = aimed(view, &groups_of(sights), &goals);
        (Self { list: glimpses }, of_sights + of_glimpses)
    }

    pub(in crate::transport::methods::bidirectional) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Draws a glimpse, and a film point from it; `None` outside the film.
    pub(in crate::transport::methods::bidirectional) fn sample(&self, rng: &mut impl Rng) -> Option<(Vec2, Events)> {
        let (chosen, u, v) = (uniform(rng), uniform(rng), uniform_f32(rng));
        let glimpse = &self.list[(chosen * self.list.len() as f64) as usize];
        let film = glimpse.sample(u, v).as_vec2();
        (film.cmpge(Vec2::ZERO).all() && film.cmplt(Vec2::ONE).all()).then_some((film, glimpse.events))
    }

    /// 1/(K P) Σ_k q_k(x).
    pub(in crate::transport::methods::bidirectional) fn relative_density(&self, path: &LightPath, view: &View) -> f64 {
        let Some((events, probability)) = Events::of(path.vertices(), view) else { return 0.0 };
        let first = self.list.partition_point(|glimpse| glimpse.events < events);
        let of_events = self.list[first..].iter().take_while(|glimpse| glimpse.events == events);
        let sum: f64 = of_events.map(|glimpse| glimpse.density(path.film.as_dvec2())).sum();
        sum / (self.list.len() as f64 * probability)
    }
}

/// Camera rays through random film points with random events, if they have any that paths of at most `max_edges` edges may have.
fn sights_at_random(view: &View, (count, max_edges): (u64, usize), seed: u64) -> (Vec<Sight>, u64) {
    let sight = |i| {
        let before = rays_traced();
        let rng = &mut generator(seed, Purpose::Sample, ROUND, 0, i);
        let film = Vec2::new(uniform_f32(rng), uniform_f32(rng)).as_dvec2();
        let sight = Sight::new(view, (film, i), |_, x, to_eye| {
            let refracts = uniform_f32(rng) < 0.5;
            let mut room = Resolved::default();
            let possible = view.scene.surface(x, &mut room).delta_direction(to_eye, refracts).is_some();
            Some(if possible { refracts } else { !refracts })
        });
        let counts =
            |sight: &Sight| (1..max_edges).contains(&sight.events.len()) && sight.probability > LEAST_PROBABILITY;
        (sight.filter(counts), rays_traced() - before)
    };
    let found: Vec<_> = (0..count).into_par_iter().map(sight).collect();
    (found.iter().filter_map(|(sight, _)| *sight).collect(), found.iter().map(|(_, rays)| rays).sum())
}

/// Rays that meet the same material first and have the same events together, the most frequent of all, along a curve that fills the film.
fn groups_of(mut sights: Vec<Sight>) -> Vec<Vec<Sight>> {
    sights.sort_by_key(|sight| (sight.events, sight.first));
    let mut groups: Vec<_> = sights.chunk_by(|a, b| (a.events, a.first) == (b.events, b.first)).collect();
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    groups.truncate(MOST_GROUPS);
    groups.sort_by_key(|group| (group[0].events, group[0].first));
    let along = |group: &[Sight]| {
        let points: Vec<_> = group.iter().map(|sight| sight.film.as_vec2().extend(0.0)).collect();
        hilbert::order(&points).into_iter().map(|i| group[i as usize]).collect()
    };
    groups.into_iter().map(along).collect()
}

/// So many points of lights, each for an equal part of the power, and photons, with the extent of those that they stand for.
fn goals_of(view: &View, lights: &LightRegion, photons: &Photons, count: usize, seed: u64) -> Vec<Goal> {
    let rng = &mut generator(seed, Purpose::Sample, ROUND + 1, 0, 0);
    let of_lights = (0..count).filter_map(|i| {
        let (light, x) = view.scene.light_point(&lights.sample((i as f64 + uniform(rng)) / count as f64, uniform(rng)));
        let part = lights.power() / (count as f64 * view.scene.exitance(light, &x));
        let goal =
            Goal { at: x.position.as_dvec3(), is_distant: x.is_distant(), extent: part.sqrt(), is_photon: false };
        x.can_be_met().then_some(goal)
    });
    let of_photons = photons.places(count).map(|(at, extent)| Goal {
        at: at.as_dvec3(),
        is_distant: false,
        extent: f64::from(extent),
        is_photon: true,
    });
    of_lights.chain(of_photons).collect()
}

/// The glimpses of all goals by all events, where they make paths more likely.
fn aimed(view: &View, groups: &[Vec<Sight>], goals: &[Goal]) -> (Vec<Glimpse>, u64) {
    let aim = |(sights, number): (&Vec<Sight>, usize)| {
        let (before, goal) = (rays_traced(), &goals[number]);
        let parts: Vec<_> = sights.chunks(sights.len().div_ceil(TURNS)).collect();
        let starts = match goal.is_photon {
            true if number.is_multiple_of(2) => parts[number / 2 % parts.len()],
            true => sights.as_slice(),
            false => parts[number % parts.len()],
        };
        let nearest = starts.iter().min_by(|a, b| goal.distance(a).total_cmp(&goal.distance(b)));
        let glimpse = nearest.and_then(|sight| {
            let (sight, slopes) = sight.aimed(view, goal)?;
            let glimpse = Glimpse::new(&sight, slopes, goal)?;
            let likely = 2.0 * goals.len() as f64 * sight.probability;
            (sight.probability > LEAST_PROBABILITY && glimpse.density(glimpse.middle) > likely).then_some(glimpse)
        });
        (glimpse, rays_traced() - before)
    };
    let pairs: Vec<_> = groups.iter().flat_map(|group| (0..goals.len()).map(move |number| (group, number))).collect();
    let found: Vec<_> = pairs.into_par_iter().map(aim).collect();
    (found.iter().filter_map(|(glimpse, _)| *glimpse).collect(), found.iter().map(|(_, rays)| rays).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::tests::worlds::{mirror, room};

    /// A share of 1 − 1/√(1 + d²) lies within d widths, where the density says so, too.
    #[test]
    fn a_lobe_is_drawn_as_its_density_says() {
        let glimpse = Glimpse { events: Events::default(), middle: DVec2::new(0.4, 0.7), root: [0.01, -0.03, 0.002] };
        let n = 20_000;
        let mut inside = [0.0; 2];
        for i in 0..n {
            let rng = &mut generator(1, Purpose::Sample, 0, 0, i);
            let drawn = glimpse.sample(uniform(rng), uniform_f32(rng));
            let square = (glimpse.density(glimpse.middle) / glimpse.density(drawn)).cbrt().powi(2);
            inside[0] += f64::from(u8::from(square < 1.0 + 4.0));
            // The integral of the density over that ellipse, by uniform points of the square around its circle.
            let about = 4.0 * DVec2::new(uniform(rng), uniform(rng)) - 2.0;
            let [first, below, second] = glimpse.root;
            let step = DVec2::new(first * about.x, below * about.x + second * about.y);
            inside[1] +=
                if about.length() < 2.0 { glimpse.density(glimpse.middle + step) * 16.0 * first * second } else { 0.0 };
        }
        let expected = 1.0 - 5.0_f64.sqrt().recip();
        for share in inside.map(|sum| sum / n as f64) {
            assert!((share - expected).abs() < 0.015, "{share} {expected}");
        }
    }

    /// Rays through a glimpse's ellipse end about as far from its goal as the goal is large.
    #[test]
    fn glimpses_are_as_large_as_what_they_show() {
        let world = room(mirror(), true);
        let view = &world.view();
        let sights = sights_at_random(view, (4000, 9), 3).0;
        let of_mirror: Vec<_> = sights.iter().filter(|sight| sight.events.len() == 1).collect();
        assert!(of_mirror.len() > 100);
        let (mut found, mut near) = (0, 0);
        for pair in of_mirror.chunks_exact(2) {
            let Some(end) = pair[0].end else { continue };
            let goal = Goal { at: end.position.as_dvec3(), is_distant: false, extent: 1e-3, is_photon: true };
            let Some((sight, slopes)) = pair[1].aimed(view, &goal) else { continue };
            assert!(goal.distance(&sight) < 1.0 && sight.events == pair[0].events);
            let glimpse = Glimpse::new(&sight, slopes, &goal).expect("a glimpse");
            let [first, below, second] = glimpse.root;
            found += 4;
            for v in [0.0_f32, 0.25, 0.5, 0.75] {
                let about = turn(v).as_dvec2();
                let edge = glimpse.middle + DVec2::new(first * about.x, below * about.x + second * about.y);
                let there = Sight::new(view, (edge, 0), |number, _, _| sight.events.get(number));
                let distance = there.map_or(f64::INFINITY, |there| goal.distance(&there));
                near += i32::from((0.5..2.0).contains(&distance));
            }
        }
        assert!(found > 200 && f64::from(near) > 0.8 * f64::from(found), "{near} of {found}");
    }
}
