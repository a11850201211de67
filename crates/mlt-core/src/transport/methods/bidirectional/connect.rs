//! Connections of two subpaths for the image alone: the contribution of a path without the path.
//!
//! The contribution of a path's parts, and the other ways to make them, are known when the subpaths are traced; a
//! connection adds what depends on its edge. [`Bidirectional::sample`] finds the same from whole paths.

use super::sampler::{Bidirectional, Carried, LightSubpath, Scratch, Subpath};
use crate::transport::bsdf::Evaluation;
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::methods::independent::ImageSampler;
use crate::transport::methods::sobol::OwenSobol;
use crate::transport::paths::mis::{self, Ends, square};
use crate::transport::paths::{Edge, Kind, LightEnd, PathEnd, PathVertex, emission, scattering, sensitivity};
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;

/// 1 if two neighbours may be connected, else 0.
#[inline]
fn allowed(x: &Vertex, y: &Vertex) -> f64 {
    f64::from(u8::from(!(x.delta | y.delta)))
}

/// Σ_{i > s} (p_i/p_s)², but for λ_s. `eye`: x_s and what follows; `forward`: density of x_s; `pdf`: of the direction from x_s
/// to x_{s+1}; `ahead`: that sum from two vertices further towards the camera; `preference`: λ_{s+1}. See [`mis`](crate::transport::paths::mis).
#[inline(always)]
fn later_techniques(eye: &[PathVertex], (forward, pdf): (f64, f32), ahead: f64, preference: f64) -> f64 {
    let [x, y, rest @ ..] = eye else { return 0.0 };
    let beyond = match rest.first() {
        None => 0.0,
        Some(z) => square(x.per_area_there(pdf) / y.reverse) * (allowed(&y.vertex, &z.vertex) + ahead),
    };
    square(forward / x.reverse) * (allowed(&x.vertex, &y.vertex) * square(preference) + beyond)
}

/// Σ_{i < s} (p_i/p_s)², but for λ_s. `light`: x_0 … x_{s−1}; `reverse`: density of x_{s−1}; `pdf`: of the direction from
/// x_{s−1} to x_{s−2}; `behind`: that sum from two vertices further towards the light.
#[inline(always)]
fn earlier_techniques(light: &[PathVertex], ends: Ends, (reverse, pdf): (f64, f32), behind: f64) -> f64 {
    let last = light.len() - 1;
    let before = match last.checked_sub(1) {
        None => 0.0,
        Some(j) => {
            let reverse = light[j].per_area_here(pdf);
            square(reverse / ends.forward(light, j)) * (mis::allowed(light, j, ends) + behind)
        }
    };
    square(reverse / ends.forward(light, last)) * (mis::allowed(light, last, ends) + before)
}

impl ImageSampler for Bidirectional<'_> {
    fn size(&self) -> [u32; 2] {
        self.view.camera.size()
    }

    fn sample(&self, film: Vec2, rng: &mut OwenSobol, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        self.sample_image(film, rng, visit);
    }
}

impl Bidirectional<'_> {
    /// Takes one sample through a film point and shows `visit` its parts, weighted contributions over densities.
    /// Those with a pixel cross the image there, all others at the point. Over uniform film points, their expected
    /// sum in a pixel is the integral of f over the paths through it.
    pub fn sample_image(&self, film: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        self.with_subpaths(film, rng, |scratch, _| {
            let end = scratch.eye.vertices.len();
            for t in 1..=scratch.eye.len() {
                self.start_near(scratch, t);
                if let Some((value, scale)) = self.hit(&scratch.eye, t) {
                    let (x_0, between) =
                        (&scratch.eye.vertices[end - t].vertex, &scratch.eye.vertices[end - t + 1..end - 1]);
                    visit(None, value, PathEnd { kind: Kind::between(between), light: LightEnd::Met(x_0), scale });
                }
                for s in 1..=(self.max_edges + 1 - t).min(scratch.light.subpath.len()) {
                    if let Some((pixel, value, scale)) = self.connection(scratch, s, t) {
                        let from_light = self.beginning(s, &scratch.light, &scratch.near);
                        let kind = Kind::new(s + t - 1, s > 1 && from_light.subpath.vertices[1].vertex.delta);
                        visit(pixel, value, PathEnd { kind, light: LightEnd::Drawn(&from_light.point), scale });
                    }
                }
            }
        });
    }

    /// s = 0: the camera subpath meets a light with its last vertex.
    fn hit(&self, eye: &Subpath, t: usize) -> Option<(DVec3, f64)> {
        let vertices = &eye.vertices[eye.vertices.len() - t..];
        let x = &vertices[0];
        if t < 2 || !x.vertex.emits {
            return None;
        }
        let Evaluation { value, pdf_to_eye, .. } = emission(&self.view, &x.vertex, x.to_eye)?;
        let lights = self.view.scene.lights();
        let point = lights.point(x.vertex.primitive, x.vertex.position)?;
        let light = &lights.lights[point.light as usize];
        let relative = self.view.scene.relative_exitance(light, &x.vertex, value);
        let forward = light.mean_exitance() * relative / self.region.power();
        let preference = self.region.preference(self.view.scene, [&x.vertex, &vertices[1].vertex], &point);
        let Carried { throughput, others, .. } = eye.carried(t);
        let weight = 1.0 / (1.0 + later_techniques(vertices, (forward, pdf_to_eye), others, preference));
        Some((throughput * value.as_dvec3() * weight, 1.0 / weight.sqrt()))
    }

    /// s ≥ 1 and t ≥ 1: an edge between the subpaths. With t = 1 it crosses the image at a pixel of its own.
    fn connection(&self, scratch: &Scratch, s: usize, t: usize) -> Option<(Option<u32>, DVec3, f64)> {
        let (eye, from_eye) = (&scratch.eye.vertices[scratch.eye.vertices.len() - t..], scratch.eye.carried(t));
        let y = &eye[0];
        if y.vertex.delta {
            return None;
        }
        let LightSubpath { subpath, preference, .. } = self.beginning(s, &scratch.light, &scratch.near);
        let (light, from_light) = (&subpath.vertices[..s], subpath.carried(s));
        let ends = Ends { power: self.region.power(), preference: *preference, area: 1.0 };
        let (x, scene) = (&light[s - 1], self.view.scene);
        if x.vertex.delta {
            return None;
        }
        let edge = Edge::between(&x.vertex, &y.vertex)?;
        let pixel = match t {
            1 => Some(self.view.camera.pixel(self.view.camera.project(&y.vertex, &x.vertex, -edge.direction)?)),
            _ => None,
        };
        let at_x = match s {
            1 => emission(&self.view, &x.vertex, edge.direction)?,
            _ => scattering(&self.view, &x.vertex, -light[s - 2].to_eye, edge.direction)?,
        };
        let at_y = match t {
            1 => sensitivity(&self.view, &y.vertex, -edge.direction)?,
            _ => scattering(&self.view, &y.vertex, -edge.direction, y.to_eye)?,
        };
        let edge = edge.veiled(scene.transmittance(&x.vertex, &y.vertex)?);
        let per_area =
            |pdf: f32, end: usize| f64::from(pdf) * f64::from(edge.cosines[end]) * f64::from(edge.inverse_square);
        let forward = per_area(at_x.pdf_to_eye, 1);
        let back = (per_area(at_y.pdf_to_light, 0), at_x.pdf_to_light);
        let others = earlier_techniques(light, ends, back, from_light.others)
            + later_techniques(eye, (forward, at_y.pdf_to_eye), from_eye.others, 1.0);
        // One over the technique's weight.
        let all = 1.0 + others / square(ends.preference(s));
        let value = from_light.throughput
            * from_eye.throughput
            * self.attenuated(at_x.value * at_y.value, light, y).as_dvec3()
            * (edge.geometric_term() / all);
        Some((pixel, value, all.sqrt()))
    }

    /// A product of scattering at both ends of an edge, weakened on it and on the light subpath's last edge.
    #[inline(always)]
    fn attenuated(&self, scattered: Rgb, light: &[PathVertex], y: &PathVertex) -> Rgb {
        let (scene, x) = (self.view.scene, &light[light.len() - 1].vertex);
        let on_edge = scene.attenuated(scattered, x, &y.vertex);
        match light {
            [.., before, _] => scene.attenuated(on_edge, &before.vertex, x),
            _ => on_edge,
        }
    }
}
