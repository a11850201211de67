//! Light paths with the densities of every way of making them.

use super::edge::Edge;
use super::path_vertex::{
    PathVertex, connectible, copy_vertices, reference, set_edge, set_emission, set_reflection, set_sensitivity,
};
use crate::engine::{self, Splat};
use crate::transport::colour::LUMINANCE;
use crate::transport::scene::{LightPoint, View};
use glam::{DVec3, Vec2};
use std::ops::RangeInclusive;

/// A path x_0 … x_k from a light to the camera, with its contribution.
#[derive(Debug, Default)]
pub struct LightPath {
    pub(crate) vertices: Vec<PathVertex>,
    /// Where x_0 lies on its light.
    pub(crate) light: LightPoint,
    /// f(x)/g(x), g as in `mis`.
    pub(crate) contribution: DVec3,
    /// Where it crosses the image, in [0, 1)².
    pub(crate) film: Vec2,
    /// Index of that pixel.
    pub(crate) pixel: u32,
    /// Number of pixels in the image.
    pub(crate) pixels: u32,
}

impl Clone for LightPath {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Copies without giving up the memory of `self`.
    fn clone_from(&mut self, source: &Self) {
        self.vertices.clone_from(&source.vertices);
        (self.light, self.contribution) = (source.light, source.contribution);
        (self.film, self.pixel, self.pixels) = (source.film, source.pixel, source.pixels);
    }
}

impl engine::Path for LightPath {
    type Splat = Splat<3>;

    fn splats(&self) -> impl Iterator<Item = Splat<3>> {
        let value = self.contribution * f64::from(self.pixels);
        std::iter::once(Splat { site: self.pixel, value: value.to_array() })
    }
}

/// I(x) = luminance of f(x)/g(x), relative to the density g(x) as all densities of whole paths are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Luminance;

impl engine::Importance<LightPath> for Luminance {
    #[inline]
    fn eval(&self, path: &LightPath) -> f64 {
        path.contribution.dot(DVec3::from_array(LUMINANCE))
    }
}

impl LightPath {
    /// x_0 … x_k.
    pub fn vertices(&self) -> &[PathVertex] {
        &self.vertices
    }

    /// Number of edges, k.
    pub fn edges(&self) -> usize {
        self.vertices.len().saturating_sub(1)
    }

    /// f(x)/g(x), radiance per area of the lights: f with W_e normalised over the image, in the area-product measure, over the density
    /// with which a random camera subpath has the vertices x_1 … x_{k−1}.
    pub fn contribution(&self) -> DVec3 {
        self.contribution
    }

    /// Where x_0 lies.
    pub fn light(&self) -> &LightPoint {
        &self.light
    }

    /// Takes the first `n` vertices of a path, with room for the rest of it.
    pub(crate) fn keep_light_end(&mut self, from: &Self, n: usize) {
        self.light = from.light;
        if self.vertices.len() == from.vertices.len() {
            copy_vertices(&mut self.vertices[..n], &from.vertices[..n]);
        } else {
            self.vertices.clone_from(&from.vertices);
        }
    }

    /// Sets the scattering at the vertices `scattering`, whose edges are set, and f(x); where the path crosses the image is known.
    /// `None`: f(x) = 0.
    pub(crate) fn update(&mut self, view: &View, scattering: RangeInclusive<usize>) -> Option<()> {
        let (first, last, end) = (*scattering.start(), *scattering.end(), self.edges());
        if first == 0 {
            set_emission(&mut self.vertices, view)?;
        }
        for i in first.max(1)..=last.min(end - 1) {
            set_reflection(&mut self.vertices, i, view)?;
        }
        if last == end {
            set_sensitivity(&mut self.vertices, view)?;
        }
        self.contribution = self.product();
        (self.contribution.max_element() > 0.0).then_some(())
    }

    /// Connects x_{s−1} to x_s, with all other edges set, and sets the scattering at the vertices `scattering`, which
    /// must include both. `None`: f(x) = 0.
    ///
    /// The ray between them, which costs most, comes last.
    pub(crate) fn connect(&mut self, view: &View, s: usize, scattering: RangeInclusive<usize>) -> Option<()> {
        if !connectible(&self.vertices, s) {
            return None;
        }
        let edge = Edge::between(&self.vertices[s - 1].vertex, &self.vertices[s].vertex)?;
        set_edge(&mut self.vertices[s - 1], edge);
        if s == self.edges() {
            self.cross(
                view,
                view.camera.project(
                    &self.vertices[s].vertex,
                    &self.vertices[s - 1].vertex,
                    -self.vertices[s - 1].to_eye,
                )?,
            );
        }
        self.update(view, scattering)?;
        let passed = view.scene.transmittance(&self.vertices[s - 1].vertex, &self.vertices[s].vertex)?;
        if passed < 1.0 {
            self.veil(s, passed);
        }
        Some(())
    }

    /// Multiplies what depends on the edge from x_{s−1} to x_s by what passes along it.
    #[cold]
    fn veil(&mut self, s: usize, passed: f32) {
        let factor = f64::from(passed);
        let [x, y] = &mut self.vertices[s - 1..=s] else { return };
        x.inverse_square *= passed;
        x.geometric_term *= factor;
        x.reverse *= factor;
        y.forward *= factor;
        self.contribution = self.product();
    }

    /// f(x)/g(x) = scatter_0 Π_{i<k} scatter_{i+1} G(x_i, x_{i+1}) / g_i.
    pub(crate) fn product(&self) -> DVec3 {
        let vertices = &self.vertices;
        (0..self.edges()).fold(vertices[0].scatter.as_dvec3(), |f, i| {
            f * vertices[i + 1].scatter.as_dvec3() * (vertices[i].geometric_term / reference(vertices, i))
        })
    }

    /// Sets where it crosses the image.
    pub(crate) fn cross(&mut self, view: &View, film: Vec2) {
        (self.film, self.pixel, self.pixels) = (film, view.camera.pixel(film), view.camera.pixels());
    }
}
