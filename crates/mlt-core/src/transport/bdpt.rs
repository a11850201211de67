//! Bidirectional path tracing: all connections of two subpaths.
//!
//! Source: [Veach97], chapter 10. The pinhole cannot be hit, so every path has at least one vertex from the camera.

use super::light::LightPoint;
use super::mis;
use super::path::{LightPath, PathVertex, View, geometric_term, set_scattering};
use super::region::LightRegion;
use super::subpath::{start_at_eye, start_at_light, step_from_eye, step_from_light};
use crate::engine::{uniform, uniform_f32};
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;
use std::cell::RefCell;

/// Most edges of a path where no limit is asked for: roulette, which ends at least one in twenty at each step, reaches it
/// with probability below 10⁻²⁰.
pub const MOST_EDGES: usize = 1000;

/// Vertices of a subpath that are traced without roulette.
const CERTAIN_VERTICES: usize = 4;
/// Largest probability of going on.
const MOST_SURVIVAL: f64 = 0.95;
/// Smallest, so that a dark subpath that meets a bright light gives no unbounded weight.
const LEAST_SURVIVAL: f64 = 0.05;

/// The sampler of connected paths that start in a region.
#[derive(Clone, Copy)]
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
struct Scratch {
    light: Subpath,
    light_point: LightPoint,
    /// Filled from the end.
    eye: Subpath,
    path: LightPath,
}

/// Vertices and the probability that roulette let the subpath come so far.
#[derive(Default)]
struct Subpath {
    vertices: Vec<PathVertex>,
    survival: Vec<f64>,
}

impl Subpath {
    /// Empties it and makes room for `most` vertices.
    fn reset(&mut self, most: usize, any: PathVertex) {
        if self.vertices.len() < most {
            self.vertices.resize(most, any);
        }
        self.survival.clear();
        self.survival.push(1.0);
    }

    /// Decides by roulette whether to go on with a subpath that carries `throughput`; returns whether.
    fn survives(&mut self, throughput: &mut DVec3, rng: &mut impl Rng) -> bool {
        let survival = self.survival[self.survival.len() - 1];
        let go_on = if self.survival.len() < CERTAIN_VERTICES {
            1.0
        } else {
            throughput.max_element().clamp(LEAST_SURVIVAL, MOST_SURVIVAL)
        };
        if go_on < 1.0 && uniform(rng) >= go_on {
            return false;
        }
        *throughput /= go_on;
        self.survival.push(survival * go_on);
        true
    }
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Bidirectional<'_> {
    /// Draws two subpaths, the camera's through a uniform point of the image, and shows `visit` every connected path with
    /// its weight w_s/p_s, in which E[Σ w_s/p_s · g(x)] = ∫ g over the paths that start in the region, as far as s ≥ 1;
    /// for s = 0 over those that start anywhere.
    pub fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        let image = Vec2::new(uniform_f32(rng), uniform_f32(rng));
        self.sample_at(image, rng, visit);
    }

    /// As [`sample`](Self::sample), with the camera subpath through a given point of the image. Weights are those of a
    /// uniform point, so a mean over stratified points stays right.
    pub fn sample_at(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        self.sample_techniques(image, rng, &mut |path, weight, _| visit(path, weight));
    }

    /// As [`sample_at`](Self::sample_at), and shows t, the number of the path's vertices that the camera subpath made.
    pub fn sample_techniques(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64, usize)) {
        SCRATCH.with_borrow_mut(|scratch| {
            self.trace_eye(image, &mut scratch.eye, rng);
            self.trace_light(scratch, rng);
            let (lights, eyes) = (scratch.light.survival.len(), scratch.eye.survival.len());
            for t in 1..=eyes {
                for s in 2usize.saturating_sub(t)..=(self.max_edges + 1 - t).min(lights) {
                    let light_survival = if s == 0 { 1.0 } else { scratch.light.survival[s - 1] };
                    if let Some(weight) = self.connect(scratch, s, t) {
                        visit(&scratch.path, weight / (light_survival * scratch.eye.survival[t - 1]), t);
                    }
                }
            }
        });
    }

    /// Traces the light subpath; its survival has one entry a vertex.
    fn trace_light(&self, scratch: &mut Scratch, rng: &mut impl Rng) {
        let (first, point) = start_at_light(&self.view, self.region, rng);
        let Scratch { light, light_point, .. } = scratch;
        *light_point = point;
        light.reset(self.max_edges, first);
        light.vertices[0] = first;
        let mut throughput = DVec3::ONE;
        for i in 0..self.max_edges - 1 {
            let traced = step_from_light(&mut light.vertices, i, &self.view, rng)
                .and_then(|()| set_scattering(&mut light.vertices, i, &self.view));
            let [x, y] = [light.vertices[i], light.vertices[i + 1]];
            if i > 0 {
                throughput *= x.scatter.as_dvec3() * (geometric_term(&x, &y.vertex) / y.forward);
            }
            if traced.is_none() || !light.survives(&mut throughput, rng) {
                return;
            }
        }
    }

    /// Traces the camera subpath.
    fn trace_eye(&self, image: Vec2, eye: &mut Subpath, rng: &mut impl Rng) {
        let camera = PathVertex::new(self.view.camera.vertex());
        eye.reset(self.max_edges + 1, camera);
        let last = eye.vertices.len() - 1;
        eye.vertices[last] = camera;
        let mut throughput = DVec3::ONE;
        for i in (last - self.max_edges + 1..=last).rev() {
            let step = if i == last {
                start_at_eye(&mut eye.vertices, i, image, &self.view)
            } else {
                step_from_eye(&mut eye.vertices, i, &self.view, rng)
            };
            let traced = step.and_then(|()| set_scattering(&mut eye.vertices, i, &self.view));
            let [x, y] = [eye.vertices[i], eye.vertices[i - 1]];
            throughput *= x.scatter.as_dvec3() * (geometric_term(&y, &x.vertex) / y.reverse);
            if traced.is_none() || !eye.survives(&mut throughput, rng) {
                return;
            }
        }
    }

    /// Assembles the path with s light and t camera vertices; returns w_s/p_s, `None` where the contribution is zero.
    fn connect(&self, scratch: &mut Scratch, s: usize, t: usize) -> Option<f64> {
        let Scratch { light, light_point, eye, path } = scratch;
        let eye = &eye.vertices[eye.vertices.len() - t..];
        if s > 0 && (light.vertices[s - 1].vertex.delta || eye[0].vertex.delta) {
            return None;
        }
        path.vertices.clear();
        path.vertices.extend_from_slice(&light.vertices[..s]);
        path.vertices.extend_from_slice(eye);
        path.light = *light_point;
        if s == 0 {
            path.light = self.view.scene.lights().point(eye[0].vertex.primitive, eye[0].vertex.position)?;
            path.update(&self.view, 0..=0)?;
        } else {
            path.connect(&self.view, s, s - 1..=s)?;
        }
        let power = self.region.power();
        Some(mis::weight(&path.vertices, s, power) / mis::density(&path.vertices, s, power))
    }
}
