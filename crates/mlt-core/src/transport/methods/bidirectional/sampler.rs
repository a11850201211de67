//! Bidirectional path tracing: all connections of two subpaths.
//!
//! Source: [Veach97], chapter 10. No light meets the lens by chance, so every path has at least one vertex from the camera.

use crate::engine::{uniform, uniform_f32};
use crate::transport::geometry::Vertex;
use crate::transport::lights::LightRegion;
use crate::transport::paths::mis::Ends;
use crate::transport::paths::subpath::{
    light_numbers, start_at_eye, start_at_light, start_near, step_from_eye, step_from_light,
};
use crate::transport::paths::{LightPath, PathVertex, mis, set_scattering};
use crate::transport::scene::{LightPoint, View};
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;
use std::cell::RefCell;

/// Vertices of a subpath that are traced without roulette.
const CERTAIN_VERTICES: usize = 4;
/// Largest probability of going on.
const MOST_SURVIVAL: f64 = 0.95;
/// Smallest, so that a dark subpath that meets a bright light gives no unbounded weight.
const LEAST_SURVIVAL: f64 = 0.05;

/// The sampler of connected paths that start in a region.
#[derive(Clone, Copy, Debug)]
pub struct Bidirectional<'a> {
    /// Scene and camera.
    pub view: View<'a>,
    /// Where x_0 is drawn.
    pub region: &'a LightRegion,
    /// Most edges of a path.
    pub max_edges: usize,
}

/// Subpaths and the path being connected; kept between samples for their memory.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) light: LightSubpath,
    /// The one of a single vertex, which is drawn for a vertex of the camera subpath, where that has a choice.
    pub(crate) near: LightSubpath,
    /// The numbers that both draw x_0 from.
    light_numbers: [f64; 2],
    /// Filled from the end.
    pub(crate) eye: Subpath,
    /// Where that crosses the image.
    film: Vec2,
    pub(super) path: LightPath,
}

/// A subpath from a light.
#[derive(Default)]
pub(crate) struct LightSubpath {
    pub(crate) subpath: Subpath,
    /// Where x_0 is on the lights.
    pub(crate) point: LightPoint,
    /// λ_1 of paths that begin with it: see [`mis`].
    pub(crate) preference: f64,
}

impl LightSubpath {
    /// Starts at x_0, which has a density of λ M/power, with room for `most` vertices.
    fn start(&mut self, most: usize, (x_0, point): (PathVertex, LightPoint), power: f64, preference: f64) {
        (self.point, self.preference) = (point, preference);
        self.subpath.reset(most, x_0, power / (preference * x_0.forward));
        self.subpath.vertices[0] = x_0;
    }
}

/// A subpath and what it carries to each of its vertices, in the order in which they were traced.
#[derive(Default)]
pub(crate) struct Subpath {
    pub(crate) vertices: Vec<PathVertex>,
    carried: Vec<Carried>,
}

/// Light or importance that a subpath carries to a vertex.
#[derive(Clone, Copy)]
pub(crate) struct Carried {
    /// Contribution over density so far, roulette included.
    pub(crate) throughput: DVec3,
    /// Probability that roulette let it come so far.
    pub(super) survival: f64,
    /// Σ of (p_i/p_s)² over the techniques that share this vertex's neighbour but one: see [`mis`].
    pub(crate) others: f64,
}

impl Subpath {
    /// Empties it, makes room for `most` vertices, and starts with the first one's throughput.
    pub(super) fn reset(&mut self, most: usize, any: PathVertex, throughput: f64) {
        if self.vertices.len() < most {
            self.vertices.resize(most, any);
        }
        self.carried.clear();
        self.carried.push(Carried { throughput: DVec3::splat(throughput), survival: 1.0, others: 0.0 });
    }

    /// Light or importance that comes to the last of the first `n` vertices.
    pub(crate) fn carried(&self, n: usize) -> Carried {
        self.carried[n - 1]
    }

    /// Number of vertices.
    pub(crate) fn len(&self) -> usize {
        self.carried.len()
    }

    /// Takes in a vertex to which the throughput changes by `factor`, unless roulette ends the subpath before it;
    /// returns whether it goes on. `certain`: the throughput that counts as 1 in roulette.
    pub(super) fn extend(&mut self, factor: DVec3, others: f64, certain: f64, rng: &mut impl Rng) -> bool {
        let Carried { throughput, survival, .. } = self.carried[self.carried.len() - 1];
        let throughput = throughput * factor;
        let go_on = if self.carried.len() < CERTAIN_VERTICES {
            1.0
        } else {
            (throughput.max_element() / certain).clamp(LEAST_SURVIVAL, MOST_SURVIVAL)
        };
        if go_on < 1.0 && uniform(rng) >= go_on {
            return false;
        }
        self.carried.push(Carried { throughput: throughput / go_on, survival: survival * go_on, others });
        true
    }
}

thread_local! {
    pub(super) static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Bidirectional<'_> {
    /// Draws two subpaths, the camera's through a uniform film point, and shows `visit` every connected path with
    /// its weight w_s/p_s, in which E[Σ w_s/p_s · g(x)] = ∫ g over the paths that start in the region, as far as s ≥ 1;
    /// for s = 0 over those that start anywhere.
    pub fn sample_paths(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        let film = Vec2::new(uniform_f32(rng), uniform_f32(rng));
        self.sample_through(film, 1.0, rng, visit);
    }

    /// As [`sample_paths`](Self::sample_paths), with the camera subpath through a given point. Over uniform points of a part of the
    /// image, of which it has the share `area`, weights are those of the paths that cross the image there; stratified
    /// points do as well.
    pub fn sample_through(&self, film: Vec2, area: f64, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        self.with_subpaths(film, rng, |scratch, _| self.connect_all(scratch, area, visit));
    }

    /// As [`sample_paths`](Self::sample_paths), with random numbers for each subpath from a generator of its own.
    pub(crate) fn sample_apart(
        &self,
        light: &mut impl Rng,
        eye: &mut impl Rng,
        visit: &mut impl FnMut(&LightPath, f64),
    ) {
        SCRATCH.with_borrow_mut(|scratch| {
            let film = Vec2::new(uniform_f32(eye), uniform_f32(eye));
            let lens = self.view.camera.sample_lens(eye);
            self.trace_eye(film, &lens, scratch, eye);
            self.trace_light(scratch, light);
            self.connect_all(scratch, 1.0, visit);
        });
    }

    fn connect_all(&self, scratch: &mut Scratch, area: f64, visit: &mut impl FnMut(&LightPath, f64)) {
        let (lights, eyes) = (scratch.light.subpath.len(), scratch.eye.len());
        for t in 1..=eyes {
            self.start_near(scratch, t);
            // Without further vertices, the path crosses the image where it is connected to the camera.
            scratch.path.cross(&self.view, scratch.film);
            for s in 2usize.saturating_sub(t)..=(self.max_edges + 1 - t).min(lights) {
                let light_survival = if s == 0 { 1.0 } else { scratch.light.subpath.carried(s).survival };
                if let Some(weight) = self.connect(scratch, [s, t], area) {
                    visit(&scratch.path, weight / (light_survival * scratch.eye.carried(t).survival));
                }
            }
        }
    }

    /// Traces two subpaths, the camera's through a given film point, and hands them over.
    pub(crate) fn with_subpaths<R: Rng>(&self, film: Vec2, rng: &mut R, use_them: impl FnOnce(&mut Scratch, &mut R)) {
        SCRATCH.with_borrow_mut(|scratch| {
            // The first numbers of both subpaths come first, so that they are the same coordinates in every sample.
            let lens = self.view.camera.sample_lens(rng);
            self.trace_light(scratch, rng);
            self.trace_eye(film, &lens, scratch, rng);
            use_them(scratch, rng);
        });
    }

    fn trace_light(&self, scratch: &mut Scratch, rng: &mut impl Rng) {
        let power = self.region.power();
        scratch.light_numbers = light_numbers(rng);
        let first = start_at_light(&self.view, self.region, scratch.light_numbers);
        scratch.light.start(self.max_edges, first, power, 1.0);
        let LightSubpath { subpath: light, point, preference } = &mut scratch.light;
        let mut certain = 1.0;
        for i in 0..self.max_edges - 1 {
            let traced = step_from_light(&mut light.vertices, i, &self.view, rng)
                .and_then(|()| set_scattering(&mut light.vertices, i, &self.view));
            if traced.is_none() {
                return;
            }
            let [x, y] = [&light.vertices[i], &light.vertices[i + 1]];
            let factor = x.scatter.as_dvec3() * (x.geometric_term / y.forward);
            if i == 0 {
                certain = light.carried[0].throughput.x * factor.max_element();
                *preference = self.region.preference(self.view.scene, [&x.vertex, &y.vertex], point);
            }
            let ends = Ends { power, preference: *preference, area: 1.0 };
            let others =
                i.checked_sub(1).map_or(0.0, |j| mis::from_light(&light.vertices, j, ends, light.carried[i].others));
            if !light.extend(factor, others, certain, rng) {
                return;
            }
        }
    }

    fn trace_eye(&self, film: Vec2, lens: &Vertex, scratch: &mut Scratch, rng: &mut impl Rng) {
        scratch.film = film;
        let eye = &mut scratch.eye;
        let camera = PathVertex::new(*lens);
        eye.reset(self.max_edges + 1, camera, 1.0);
        let last = eye.vertices.len() - 1;
        eye.vertices[last] = camera;
        for i in (last - self.max_edges + 1..=last).rev() {
            let step = if i == last {
                start_at_eye(&mut eye.vertices, i, film, &self.view, rng)
            } else {
                step_from_eye(&mut eye.vertices, i, &self.view, rng)
            };
            if step.and_then(|()| set_scattering(&mut eye.vertices, i, &self.view)).is_none() {
                return;
            }
            let [x, y] = [&eye.vertices[i], &eye.vertices[i - 1]];
            let factor = x.scatter.as_dvec3() * (y.geometric_term / y.reverse);
            let others =
                if i + 1 < last { mis::from_eye(&eye.vertices, i + 1, eye.carried[last - i].others) } else { 0.0 };
            if !eye.extend(factor, others, 1.0, rng) {
                return;
            }
        }
    }

    /// Draws x_0 for the last of the camera's first t vertices, where that has a choice and may be connected.
    #[inline(always)]
    pub(crate) fn start_near(&self, scratch: &mut Scratch, t: usize) {
        if !self.region.light_sampler().has_choice() {
            return;
        }
        let x_1 = &scratch.eye.vertices[scratch.eye.vertices.len() - t];
        if !x_1.vertex.delta {
            let (x_0, point, preference) = start_near(&self.view, self.region, x_1, scratch.light_numbers);
            scratch.near.start(1, (x_0, point), self.region.power(), preference);
        }
    }

    /// Beginning of a path with s vertices from the light: the subpath of many vertices or that of one.
    #[inline]
    pub(crate) fn beginning<'s>(&self, s: usize, many: &'s LightSubpath, one: &'s LightSubpath) -> &'s LightSubpath {
        if s == 1 && self.region.light_sampler().has_choice() { one } else { many }
    }

    /// Assembles the path with s light and t camera vertices, which is known to cross the image at the film point of the latter unless
    /// t = 1; returns w_s/p_s, `None` where the contribution is zero.
    pub(super) fn connect(&self, scratch: &mut Scratch, [s, t]: [usize; 2], area: f64) -> Option<f64> {
        let Scratch { light, near, eye, path, .. } = scratch;
        let LightSubpath { subpath: light, point, preference } = self.beginning(s, light, near);
        let eye = &eye.vertices[eye.vertices.len() - t..];
        if s > 0 && (eye[0].vertex.delta || light.vertices[s - 1].vertex.delta) {
            return None;
        }
        path.vertices.clear();
        path.vertices.extend_from_slice(&light.vertices[..s]);
        path.vertices.extend_from_slice(eye);
        path.light = *point;
        let mut ends = Ends { power: self.region.power(), preference: *preference, area };
        if s == 0 {
            path.light = self.view.scene.lights().point(eye[0].vertex.primitive, eye[0].vertex.position)?;
            path.update(&self.view, 0..=0)?;
            ends = Ends::new(path, &self.view, self.region, area);
        } else {
            path.connect(&self.view, s, s - 1..=s)?;
        }
        Some(mis::weight(&path.vertices, s, ends) / mis::density(&path.vertices, s, ends))
    }
}
