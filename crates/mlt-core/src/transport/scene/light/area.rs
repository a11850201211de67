//! Area lights, each with an area-preserving map from the unit square.

use crate::transport::colour::{Rgb, luminance};
use glam::{DVec2, DVec3, Vec3};
use std::f32::consts::PI;

/// A point of a light: the light, and coordinates in the unit square that its surface is mapped from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightPoint {
    /// Index of the light.
    pub light: u32,
    /// First coordinate, in [0, 1]; f64, since it also chooses the triangle of a mesh.
    pub u: f64,
    /// Second coordinate, in [0, 1].
    pub v: f64,
}

/// A surface that emits the same radiance everywhere and in every direction of its front, or of both sides.
#[derive(Clone, Debug)]
pub struct Light {
    /// Radiance.
    pub emission: Rgb,
    /// Emits from the back as well.
    pub both_sides: bool,
    /// Total area times opacity, scene units².
    pub area: f64,
    pub(crate) shape: Shape,
}

/// A flat part of a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Its place in the light's unit square: the corners with the smallest and with the largest coordinates.
    pub(crate) square: [DVec2; 2],
    /// Corner of its bounding box with the smallest coordinates.
    pub(crate) low: Vec3,
    /// Corner with the largest ones.
    pub(crate) high: Vec3,
    /// Unit normal of the front.
    pub(crate) normal: Vec3,
}

impl Piece {
    fn new(square: [DVec2; 2], corners: &[Vec3]) -> Self {
        let [a, b, c] = [0, 1, 2].map(|i| corners[i].as_dvec3());
        Self {
            square,
            low: corners.iter().copied().fold(Vec3::INFINITY, Vec3::min),
            high: corners.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max),
            normal: (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3(),
        }
    }
}

/// How the unit square lies on the surface.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// (u, v) ↦ origin + u·edges[0] + v·edges[1]; on the first of two triangles where u + v ≤ 1.
    Parallelogram { origin: Vec3, edges: [Vec3; 2], primitives: [u32; 2] },
    /// u runs through the triangles in proportion to their areas.
    Triangles { primitives: Vec<u32>, cumulative: Vec<f64>, vertices: Vec<[Vec3; 3]> },
}

impl Light {
    pub(crate) fn parallelogram(origin: Vec3, edges: [Vec3; 2], primitives: [u32; 2]) -> Self {
        let area = f64::from(edges[0].cross(edges[1]).length());
        let shape = Shape::Parallelogram { origin, edges, primitives };
        Self { emission: Rgb::ZERO, both_sides: false, area, shape }
    }

    /// A light of triangles; `None` if their area is zero.
    pub(crate) fn triangles(list: impl Iterator<Item = (u32, [Vec3; 3])>) -> Option<Self> {
        let (mut primitives, mut vertices, mut cumulative, mut area) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
        for (primitive, [a, b, c]) in list {
            let part = 0.5 * f64::from((b - a).cross(c - a).length());
            if part > 0.0 && part.is_finite() {
                area += part;
                primitives.push(primitive);
                vertices.push([a, b, c]);
                cumulative.push(area);
            }
        }
        cumulative.iter_mut().for_each(|c| *c /= area);
        let shape = Shape::Triangles { primitives, cumulative, vertices };
        (area > 0.0).then_some(Self { emission: Rgb::ZERO, both_sides: false, area, shape })
    }

    /// Emitted luminance per area, M = π L, twice that for both sides.
    pub fn exitance(&self) -> f64 {
        f64::from(luminance(self.emission) * PI) * if self.both_sides { 2.0 } else { 1.0 }
    }

    /// M × area.
    pub fn power(&self) -> f64 {
        self.exitance() * self.area
    }

    /// Its parallelogram, or those of its triangles, as far as they lie between two corners of the unit square, in the order
    /// of their numbers; and the first one's number.
    pub(crate) fn pieces(&self, low: DVec2, high: DVec2) -> (u32, Vec<Piece>) {
        match &self.shape {
            &Shape::Parallelogram { origin, edges: [e, f], .. } => {
                let at = |u: f64, v: f64| origin + u as f32 * e + v as f32 * f;
                let corners = [at(low.x, low.y), at(high.x, low.y), at(low.x, high.y), at(high.x, high.y)];
                (0, vec![Piece::new([low, high], &corners)])
            }
            Shape::Triangles { cumulative, vertices, .. } => {
                let first = cumulative.partition_point(|&end| end <= low.x).min(vertices.len() - 1);
                let last = cumulative.partition_point(|&end| end < high.x).min(vertices.len() - 1);
                let piece = |i: usize| {
                    let (begin, end) = interval(cumulative, i);
                    let square = [DVec2::new(begin.max(low.x), low.y), DVec2::new(end.min(high.x), high.y)];
                    Piece::new(square, &vertices[i])
                };
                (first as u32, (first..=last).map(piece).collect())
            }
        }
    }

    /// Lengths of the sides of the unit square; a mesh has one.
    pub(crate) fn sides(&self) -> DVec2 {
        match &self.shape {
            Shape::Parallelogram { edges, .. } => DVec2::from_array(edges.map(|e| f64::from(e.length()))),
            Shape::Triangles { .. } => DVec2::X,
        }
    }

    /// Columns and rows of as many cells as a rectangle is to have; a mesh is cut along u alone, which runs through its
    /// triangles.
    pub(crate) fn grid(&self, size: [u32; 2]) -> [u32; 2] {
        match self.shape {
            Shape::Parallelogram { .. } => size,
            Shape::Triangles { .. } => [size[0] * size[1], 1],
        }
    }

    /// Its centre of mass.
    pub fn centre(&self) -> Vec3 {
        match &self.shape {
            Shape::Parallelogram { origin, edges: [e, f], .. } => *origin + 0.5 * (*e + *f),
            Shape::Triangles { cumulative, vertices, .. } => {
                let weighted = |(i, [a, b, c]): (usize, &[Vec3; 3])| {
                    let (low, high) = interval(cumulative, i);
                    ((high - low) as f32 / 3.0) * (*a + *b + *c)
                };
                vertices.iter().enumerate().map(weighted).sum()
            }
        }
    }

    /// Triangle and position at coordinates (u, v).
    #[inline(always)]
    pub(crate) fn at(&self, u: f64, v: f64) -> (u32, Vec3) {
        match &self.shape {
            Shape::Parallelogram { origin, edges, primitives } => {
                (primitives[usize::from(u + v > 1.0)], *origin + u as f32 * edges[0] + v as f32 * edges[1])
            }
            Shape::Triangles { primitives, cumulative, vertices } => {
                let i = cumulative.partition_point(|&c| c <= u).min(primitives.len() - 1);
                let (low, high) = interval(cumulative, i);
                let root = ((u - low) / (high - low)).clamp(0.0, 1.0).sqrt() as f32;
                let [a, b, c] = vertices[i];
                let (wb, wc) = (root * (1.0 - v as f32), root * v as f32);
                (primitives[i], (1.0 - wb - wc) * a + wb * b + wc * c)
            }
        }
    }

    /// Coordinates of the point nearest to `position` on the light's triangle number `index` (in the order given).
    pub(crate) fn coordinates(&self, index: u32, position: Vec3) -> (f64, f64) {
        match &self.shape {
            Shape::Parallelogram { origin, edges: [e, f], .. } => weights(position - *origin, *e, *f),
            Shape::Triangles { cumulative, vertices, .. } => {
                let [a, b, c] = vertices[index as usize];
                let (wb, wc) = weights(position - a, b - a, c - a);
                let root = (wb + wc).min(1.0);
                let (low, high) = interval(cumulative, index as usize);
                let v = if root > 0.0 { (wc / root).min(1.0) } else { 0.0 };
                (low + root * root * (high - low), v)
            }
        }
    }
}

fn interval(cumulative: &[f64], i: usize) -> (f64, f64) {
    (if i == 0 { 0.0 } else { cumulative[i - 1] }, cumulative[i])
}

/// (s, t), each clamped to [0, 1], of the point s·e + t·f nearest to p.
fn weights(p: Vec3, e: Vec3, f: Vec3) -> (f64, f64) {
    let (p, e, f) = (p.as_dvec3(), e.as_dvec3(), f.as_dvec3());
    let n = e.cross(f);
    let d = n.length_squared();
    (p.cross(f).dot(n).clamp(0.0, d) / d, e.cross(p).dot(n).clamp(0.0, d) / d)
}
