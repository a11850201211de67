//! Connections of two subpaths for the image alone: the contribution of a path without the path.
//!
//! What a path's parts contribute and how else they could have been made is known when the subpaths are traced; a
//! connection adds what depends on its edge. [`Bidirectional::sample`] finds the same from whole paths.

use super::bdpt::{Bidirectional, Carried, Scratch, Subpath};
use super::kind::{Kind, LightEnd, PathEnd};
use super::path::{PathVertex, geometric_term, set_edge, set_scattering};
use super::{Rgb, mis};
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;

/// The vertices around a connection, as far as its densities depend on them: x_{s−3} … x_{s+2}, or fewer.
struct Window {
    vertices: [PathVertex; 6],
    len: usize,
    /// Where x_s is.
    joint: usize,
}

impl Window {
    /// The last light vertices among the first s, and the last camera vertices among the first t.
    fn new(light: &[PathVertex], eye: &[PathVertex]) -> Self {
        let (light, eye) = (&light[light.len().saturating_sub(3)..], &eye[..eye.len().min(3)]);
        let mut vertices = [eye[0]; 6];
        vertices[..light.len()].copy_from_slice(light);
        vertices[light.len()..light.len() + eye.len()].copy_from_slice(eye);
        Self { vertices, len: light.len() + eye.len(), joint: light.len() }
    }

    /// Σ_{i > s} (p_i/p_s)². `ahead`: that sum from two vertices further towards the camera.
    fn later_techniques(&self, ahead: f64) -> f64 {
        let vertices = &self.vertices[..self.len];
        match self.len - self.joint {
            1 => 0.0,
            2 => mis::from_eye(vertices, self.joint, 0.0),
            _ => mis::from_eye(vertices, self.joint, mis::from_eye(vertices, self.joint + 1, ahead)),
        }
    }

    /// Σ_{i < s} (p_i/p_s)². `behind`: that sum from two vertices further towards the light.
    fn earlier_techniques(&self, power: f64, behind: f64) -> f64 {
        let before = match self.joint {
            0 => return 0.0,
            1 => 0.0,
            _ => mis::from_light(&self.vertices, self.joint - 2, power, behind),
        };
        mis::from_light(&self.vertices, self.joint - 1, power, before)
    }
}

impl Bidirectional<'_> {
    /// Takes one sample through a point of the image and shows `visit` its parts, weighted contributions over densities.
    /// Those with a pixel cross the image there, all others at the point. Over uniform points of the image, their expected
    /// sum in a pixel is the integral of f over the paths through it.
    pub fn sample_image(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        self.with_subpaths(image, rng, |scratch, _| {
            let end = scratch.eye.vertices.len();
            for t in 1..=scratch.eye.len() {
                if let Some(value) = self.hit(&scratch.eye, t) {
                    let [x_0, x_1] = [&scratch.eye.vertices[end - t].vertex, &scratch.eye.vertices[end - t + 1].vertex];
                    let kind = Kind::new(t - 1, x_1.delta);
                    visit(None, value, PathEnd { kind, light: LightEnd::Met(x_0) });
                }
                for s in 1..=(self.max_edges + 1 - t).min(scratch.light.len()) {
                    if let Some((pixel, value)) = self.connection(scratch, s, t) {
                        let kind = Kind::new(s + t - 1, s > 1 && scratch.light.vertices[1].vertex.delta);
                        visit(pixel, value, PathEnd { kind, light: LightEnd::Drawn(&scratch.light_point) });
                    }
                }
            }
        });
    }

    /// s = 0: the camera subpath meets a light with its last vertex.
    fn hit(&self, eye: &Subpath, t: usize) -> Option<DVec3> {
        let vertices = &eye.vertices[eye.vertices.len() - t..];
        if t < 2 || self.view.scene.lights().of(vertices[0].vertex.primitive).is_none() {
            return None;
        }
        let mut window = Window::new(&[], vertices);
        set_scattering(&mut window.vertices[..window.len], 0, &self.view)?;
        window.vertices[0].forward /= self.region.power();
        let Carried { throughput, others, .. } = eye.carried(t);
        let weight = 1.0 / (1.0 + window.later_techniques(others));
        Some(throughput * window.vertices[0].scatter.as_dvec3() * weight)
    }

    /// s ≥ 1 and t ≥ 1: an edge between the subpaths. With t = 1 it crosses the image at a pixel of its own.
    fn connection(&self, scratch: &Scratch, s: usize, t: usize) -> Option<(Option<u32>, DVec3)> {
        let (light, eye) = (&scratch.light.vertices[..s], &scratch.eye.vertices[scratch.eye.vertices.len() - t..]);
        if light[s - 1].vertex.delta || eye[0].vertex.delta {
            return None;
        }
        let mut window = Window::new(light, eye);
        let (len, joint) = (window.len, window.joint);
        let vertices = &mut window.vertices[..len];
        set_edge(vertices, joint - 1)?;
        let pixel = match t {
            1 => Some(self.view.camera.pixel(self.view.camera.image_point(-vertices[joint - 1].to_eye)?)),
            _ => None,
        };
        set_scattering(vertices, joint - 1, &self.view)?;
        set_scattering(vertices, joint, &self.view)?;
        let (x, y) = (window.vertices[joint - 1], window.vertices[joint]);
        let (from_light, from_eye) = (scratch.light.carried(s), scratch.eye.carried(t));
        let others = window.earlier_techniques(self.region.power(), from_light.others)
            + window.later_techniques(from_eye.others);
        let scatter: Rgb = x.scatter * y.scatter;
        let value = from_light.throughput
            * from_eye.throughput
            * scatter.as_dvec3()
            * (geometric_term(&x, &y.vertex) / (1.0 + others));
        self.view.scene.visible(&x.vertex, &y.vertex).then_some((pixel, value))
    }
}
