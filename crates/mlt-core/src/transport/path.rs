//! Light paths with the densities of every way of making them.

use super::Rgb;
use super::camera::Camera;
use super::light::LightPoint;
use super::scene::Scene;
use super::vertex::Vertex;
use crate::engine::{self, Splat};
use glam::{DVec3, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use std::ops::RangeInclusive;

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
    pub to_eye: Vec3,
    /// 1/|x_{i+1} − x_i|².
    pub inverse_square: f32,
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
        Self { vertex, to_eye: Vec3::ZERO, inverse_square: 0.0, scatter: Rgb::ZERO, forward: 0.0, reverse: 0.0 }
    }
}

/// A path x_0 … x_k from a light to the camera, with its contribution.
#[derive(Debug, Default)]
pub struct LightPath {
    pub(super) vertices: Vec<PathVertex>,
    /// Where x_0 lies on its light.
    pub(super) light: LightPoint,
    /// f(x), area-product measure, relative to the image's mean.
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

/// I(x) = luminance of f(x).
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

    /// f(x): radiance, area-product measure, W_e normalised over the image.
    pub fn contribution(&self) -> DVec3 {
        self.contribution
    }

    /// Where x_0 lies.
    pub fn light(&self) -> &LightPoint {
        &self.light
    }

    /// Sets the scattering at the vertices `scattering`, whose edges are set, and f(x). `None`: f(x) = 0.
    pub(super) fn update(&mut self, view: &View, scattering: RangeInclusive<usize>) -> Option<()> {
        for i in scattering {
            set_scattering(&mut self.vertices, i, view)?;
        }
        self.set_image(view)?;
        self.contribution = self.product();
        (self.contribution.max_element() > 0.0).then_some(())
    }

    /// Connects x_{s−1} to x_s, with all other edges set, and sets the scattering at the vertices `scattering`, which
    /// must include both. `None`: f(x) = 0.
    ///
    /// The ray between them, which costs most, comes last.
    pub(super) fn connect(&mut self, view: &View, s: usize, scattering: RangeInclusive<usize>) -> Option<()> {
        if !super::mis::connectible(&self.vertices, s) {
            return None;
        }
        set_edge(&mut self.vertices, s - 1)?;
        self.update(view, scattering)?;
        view.scene.visible(&self.vertices[s - 1].vertex, &self.vertices[s].vertex).then_some(())
    }

    /// f(x) = Π_i scatter_i Π_i G(x_i, x_{i+1}).
    fn product(&self) -> DVec3 {
        self.vertices.iter().fold(DVec3::ONE, |f, v| f * v.scatter.as_dvec3())
            * self.vertices.windows(2).map(|e| geometric_term(&e[0], &e[1].vertex)).product::<f64>()
    }

    fn set_image(&mut self, view: &View) -> Option<()> {
        let previous = &self.vertices[self.vertices.len() - 2];
        self.image = view.camera.image_point(-previous.to_eye)?;
        self.pixel = view.camera.pixel(self.image);
        self.pixels = view.camera.pixels();
        Some(())
    }
}

/// Sets the edge from x_i to x_{i+1}; `None` if they coincide.
#[inline]
pub(super) fn set_edge(vertices: &mut [PathVertex], i: usize) -> Option<()> {
    let d = vertices[i + 1].vertex.position - vertices[i].vertex.position;
    let square = d.length_squared();
    let inverse_square = 1.0 / square;
    vertices[i].inverse_square = inverse_square;
    vertices[i].to_eye = d * inverse_square.sqrt();
    (square > 0.0 && inverse_square.is_finite()).then_some(())
}

/// Sets the scattering at x_i, whose edges are set, and the densities of its two neighbours, drawn from it.
/// `None` if it scatters nothing.
#[inline]
pub(super) fn set_scattering(vertices: &mut [PathVertex], i: usize, view: &View) -> Option<()> {
    if i == 0 {
        return set_emission(vertices, view);
    }
    let (x, previous) = (vertices[i], vertices[i - 1]);
    if x.vertex.is_camera() {
        let cos = x.vertex.geometric_normal.dot(-previous.to_eye);
        vertices[i - 1].reverse = per_area(view.camera.pdf(cos), &previous, &previous.vertex);
        vertices[i].scatter = Rgb::splat(view.camera.w_e(cos));
        vertices[i].reverse = 1.0;
        return (cos > 0.0).then_some(());
    }
    let (to_light, to_eye) = (-previous.to_eye, x.to_eye);
    vertices[i].scatter = view.scene.scatter(&x.vertex, to_light, to_eye)?;
    let forward = view.scene.pdf(&x.vertex, to_light, to_eye);
    let reverse = view.scene.pdf(&x.vertex, to_eye, to_light);
    vertices[i + 1].forward = per_area(forward, &x, &vertices[i + 1].vertex);
    vertices[i - 1].reverse = per_area(reverse, &previous, &previous.vertex);
    Some(())
}

fn set_emission(vertices: &mut [PathVertex], view: &View) -> Option<()> {
    let x = vertices[0];
    let light = view.scene.lights().of(x.vertex.primitive)?;
    let emitted = view.scene.emitted(&x.vertex, x.to_eye);
    let cos = x.vertex.geometric_normal.dot(x.to_eye);
    let pdf = if light.both_sides { 0.5 * cos.abs() } else { cos.max(0.0) } * FRAC_1_PI;
    vertices[0].scatter = emitted;
    vertices[0].forward = light.exitance();
    vertices[1].forward = per_area(pdf, &x, &vertices[1].vertex);
    (emitted != Rgb::ZERO).then_some(())
}

/// G(x, y) = |cosθ_x cosθ_y| / |x − y|², geometric normals; `from` holds the edge to `to`.
#[inline]
pub(super) fn geometric_term(from: &PathVertex, to: &Vertex) -> f64 {
    let cosines = from.vertex.geometric_normal.dot(from.to_eye) * to.geometric_normal.dot(from.to_eye);
    f64::from(cosines.abs()) * f64::from(from.inverse_square)
}

/// A density per solid angle along `edge` as a density per area at `target`, one of its two ends.
#[inline]
pub(super) fn per_area(pdf: f32, edge: &PathVertex, target: &Vertex) -> f64 {
    f64::from(pdf) * f64::from(target.geometric_normal.dot(edge.to_eye).abs()) * f64::from(edge.inverse_square)
}
