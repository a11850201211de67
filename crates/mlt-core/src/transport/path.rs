//! Light paths with the densities of every way of making them.

use super::Rgb;
use super::bsdf::Evaluation;
use super::camera::Camera;
use super::edge::Edge;
use super::light::LightPoint;
use super::mis;
use super::scene::Scene;
use super::vertex::Vertex;
use crate::engine::{self, Splat};
use glam::{DVec3, Vec2, Vec3A};
use std::f32::consts::FRAC_1_PI;
use std::ops::RangeInclusive;
use std::sync::atomic::{Ordering, compiler_fence};

/// A scene seen through a camera: what a path lives in.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Surfaces and lights.
    pub scene: &'a Scene,
    /// Pinhole and image.
    pub camera: &'a Camera,
}

/// A vertex x_i of a path with what depends on it and its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct PathVertex {
    /// Where it is.
    pub vertex: Vertex,
    /// Unit direction to x_{i+1}, the next vertex towards the camera.
    pub to_eye: Vec3A,
    /// τ/|x_{i+1} − x_i|², τ what surfaces that are not opaque let pass.
    pub inverse_square: f32,
    /// |cosθ| of the edge to x_{i+1}, at x_i and at x_{i+1}, to the geometric normals.
    pub cosines: [f32; 2],
    /// G(x_i, x_{i+1}) τ = |cosθ_i cosθ_{i+1}| τ / |x_i − x_{i+1}|², geometric normals.
    pub geometric_term: f64,
    /// x_0: emitted radiance; x_k: W_e; between them f_s(x_{i−1} → x_i → x_{i+1}) |ω·N_s|/|ω·N_g|, ω towards x_{i−1}.
    pub scatter: Rgb,
    /// Density per area of x_i, drawn from x_{i−1}; of x_0: M, to be divided by the power of the region it is drawn from.
    pub forward: f64,
    /// Density per area of x_i, drawn from x_{i+1}; of x_k: 1.
    pub reverse: f64,
}

impl PathVertex {
    /// A vertex whose neighbours are not known yet.
    pub fn new(vertex: Vertex) -> Self {
        Self {
            vertex,
            to_eye: Vec3A::ZERO,
            inverse_square: 0.0,
            cosines: [0.0; 2],
            geometric_term: 0.0,
            scatter: Rgb::ZERO,
            forward: 0.0,
            reverse: 0.0,
        }
    }

    /// A density per solid angle along the edge to x_{i+1} as a density per area at x_i.
    #[inline]
    pub(super) fn per_area_here(&self, pdf: f32) -> f64 {
        f64::from(pdf) * f64::from(self.cosines[0]) * f64::from(self.inverse_square)
    }

    /// The same as a density per area at x_{i+1}.
    #[inline]
    pub(super) fn per_area_there(&self, pdf: f32) -> f64 {
        f64::from(pdf) * f64::from(self.cosines[1]) * f64::from(self.inverse_square)
    }
}

/// A path x_0 … x_k from a light to the camera, with its contribution.
#[derive(Debug, Default)]
pub struct LightPath {
    pub(super) vertices: Vec<PathVertex>,
    /// Where x_0 lies on its light.
    pub(super) light: LightPoint,
    /// f(x)/g(x), g as in `mis`.
    pub(super) contribution: DVec3,
    /// Where it crosses the image, in [0, 1)².
    pub(super) image: Vec2,
    /// Index of that pixel.
    pub(super) pixel: u32,
    /// Number of pixels in the image.
    pub(super) pixels: u32,
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
        (self.image, self.pixel, self.pixels) = (source.image, source.pixel, source.pixels);
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
        let [r, g, b] = path.contribution.to_array();
        0.2126 * r + 0.7152 * g + 0.0722 * b
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
    pub(super) fn keep_light_end(&mut self, from: &Self, n: usize) {
        self.light = from.light;
        if self.vertices.len() == from.vertices.len() {
            copy_vertices(&mut self.vertices[..n], &from.vertices[..n]);
        } else {
            self.vertices.clone_from(&from.vertices);
        }
    }

    /// Sets the scattering at the vertices `scattering`, whose edges are set, and f(x); where the path crosses the image is known.
    /// `None`: f(x) = 0.
    pub(super) fn update(&mut self, view: &View, scattering: RangeInclusive<usize>) -> Option<()> {
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
    pub(super) fn connect(&mut self, view: &View, s: usize, scattering: RangeInclusive<usize>) -> Option<()> {
        if !mis::connectible(&self.vertices, s) {
            return None;
        }
        let edge = Edge::between(&self.vertices[s - 1].vertex, &self.vertices[s].vertex)?;
        set_edge(&mut self.vertices[s - 1], edge);
        if s == self.edges() {
            self.cross(view, view.camera.image_point(-self.vertices[s - 1].to_eye)?);
        }
        self.update(view, scattering)?;
        let passed = view.scene.transmittance(&self.vertices[s - 1].vertex, &self.vertices[s].vertex);
        if passed == 0.0 {
            return None;
        }
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
    pub(super) fn product(&self) -> DVec3 {
        let vertices = &self.vertices;
        (0..self.edges()).fold(vertices[0].scatter.as_dvec3(), |f, i| {
            f * vertices[i + 1].scatter.as_dvec3() * (vertices[i].geometric_term / mis::reference(vertices, i))
        })
    }

    /// Sets where it crosses the image.
    pub(super) fn cross(&mut self, view: &View, image: Vec2) {
        (self.image, self.pixel, self.pixels) = (image, view.camera.pixel(image), view.camera.pixels());
    }
}

/// Copies a few vertices. One after the other: what the branches of a general copy do, whose length varies, is hard to foresee.
#[inline(always)]
pub(super) fn copy_vertices(to: &mut [PathVertex], from: &[PathVertex]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
        // No instruction; it keeps the compiler from calling that copy.
        compiler_fence(Ordering::SeqCst);
    }
}

/// Sets the edge from x_i to x_{i+1}.
#[inline(always)]
pub(super) fn set_edge(x: &mut PathVertex, edge: Edge) {
    x.geometric_term = edge.geometric_term();
    Edge { direction: x.to_eye, inverse_square: x.inverse_square, cosines: x.cosines } = edge;
}

/// Sets the scattering at x_i, whose edges are set, and the densities of its two neighbours, drawn from it.
/// `None` if it scatters nothing.
#[inline(always)]
pub(super) fn set_scattering(vertices: &mut [PathVertex], i: usize, view: &View) -> Option<()> {
    if i == 0 {
        set_emission(vertices, view)
    } else if i + 1 == vertices.len() {
        set_sensitivity(vertices, view)
    } else {
        set_reflection(vertices, i, view)
    }
}

/// x_0, on a light: L_e, M, and the density of x_1.
#[inline(always)]
fn set_emission(vertices: &mut [PathVertex], view: &View) -> Option<()> {
    let [x, to_eye, ..] = vertices else { return None };
    let found = emission(view, &x.vertex, x.to_eye)?;
    x.scatter = found.value;
    x.forward = view.scene.lights().of(x.vertex.primitive)?.exitance();
    to_eye.forward = x.per_area_there(found.pdf_to_eye);
    Some(())
}

/// x_i, a surface between two others: f_s, and the densities of both neighbours.
#[inline(always)]
fn set_reflection(vertices: &mut [PathVertex], i: usize, view: &View) -> Option<()> {
    let [to_light, x, to_eye] = vertices.get_mut(i - 1..i + 2)? else { return None };
    let found = view.scene.evaluate(&x.vertex, -to_light.to_eye, x.to_eye)?;
    x.scatter = found.value;
    to_eye.forward = x.per_area_there(found.pdf_to_eye);
    to_light.reverse = to_light.per_area_here(found.pdf_to_light);
    Some(())
}

/// x_k, the camera: W_e, and the density of x_{k−1}.
#[inline(always)]
fn set_sensitivity(vertices: &mut [PathVertex], view: &View) -> Option<()> {
    let [.., to_light, x] = vertices else { return None };
    let found = sensitivity(view, x, -to_light.to_eye)?;
    x.scatter = found.value;
    x.reverse = 1.0;
    to_light.reverse = to_light.per_area_here(found.pdf_to_light);
    Some(())
}

/// Emitted radiance at x_0, and the density, per solid angle, of the direction that a light subpath starts into.
/// `None`: nothing.
#[inline(always)]
pub(super) fn emission(view: &View, x: &Vertex, to_eye: Vec3A) -> Option<Evaluation> {
    if !x.emits {
        return None;
    }
    let value = view.scene.emitted(x, to_eye);
    let cos = x.geometric_normal.dot(to_eye);
    let pdf = if view.scene.emits_both_sides(x) { 0.5 * cos.abs() } else { cos.max(0.0) } * FRAC_1_PI;
    (value != Rgb::ZERO).then_some(Evaluation { value, pdf_to_eye: pdf, pdf_to_light: 0.0 })
}

/// Scattering and densities at a surface or, as W_e, at the camera; `None`: nothing.
#[inline(always)]
pub(super) fn scattering(view: &View, x: &PathVertex, to_light: Vec3A, to_eye: Vec3A) -> Option<Evaluation> {
    if x.vertex.is_camera() { sensitivity(view, x, to_light) } else { view.scene.evaluate(&x.vertex, to_light, to_eye) }
}

/// W_e, and the density of a direction to the light through a uniform point of the image; `None` behind the image.
#[inline(always)]
fn sensitivity(view: &View, x: &PathVertex, to_light: Vec3A) -> Option<Evaluation> {
    let cos = x.vertex.geometric_normal.dot(to_light);
    let value = Rgb::splat(view.camera.w_e(cos));
    (cos > 0.0).then(|| Evaluation { value, pdf_to_eye: 0.0, pdf_to_light: view.camera.pdf(cos) })
}
