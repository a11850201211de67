//! Weights of the ways of making one path.
//!
//! A path of n vertices can be made with s vertices from the light and n − s from the camera, s = 0 … n − 1, with density
//! p_s = Π_{i<s} forward_i · Π_{i≥s} reverse_i. Where s ≥ 1 the edge between x_{s−1} and x_s is a connection, which
//! must not end at a delta vertex: else p_s = 0. x_0 and x_{k−1} are drawn on what [`Ends`] says.

use super::path::PathVertex;

/// What subpaths start on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// Power of the region that x_0 is drawn on.
    pub(super) power: f64,
    /// Area of the part of the image, itself of area 1, that the ray to x_{k−1} is drawn through.
    pub(super) area: f64,
}

impl Ends {
    /// Camera rays through all of the image.
    pub(super) fn of_image(power: f64) -> Self {
        Self { power, area: 1.0 }
    }

    /// Density per area of x_i, drawn from the light's side.
    #[inline]
    pub(super) fn forward(&self, vertices: &[PathVertex], i: usize) -> f64 {
        if i == 0 { vertices[0].forward / self.power } else { vertices[i].forward }
    }

    /// Density per area of x_i, drawn from the camera's side.
    #[inline]
    pub(super) fn reverse(&self, vertices: &[PathVertex], i: usize) -> f64 {
        if i + 2 == vertices.len() { vertices[i].reverse / self.area } else { vertices[i].reverse }
    }
}

/// p_s.
pub(super) fn density(vertices: &[PathVertex], s: usize, ends: Ends) -> f64 {
    let forward: f64 = vertices[..s].iter().map(|x| x.forward).product();
    let reverse: f64 = vertices[s..].iter().map(|x| x.reverse).product();
    let light = if s > 0 { ends.power } else { 1.0 };
    let camera = if s + 1 < vertices.len() { ends.area } else { 1.0 };
    forward * reverse / (light * camera)
}

/// Whether x_{s−1} and x_s may be connected.
#[inline]
pub(super) fn connectible(vertices: &[PathVertex], s: usize) -> bool {
    s == 0 || !(vertices[s - 1].vertex.delta || vertices[s].vertex.delta)
}

/// The power heuristic's weight of technique s, which must have a positive density: p_s² / Σ_i p_i².
///
/// Source: [Veach97], sections 9.2.4 and 10.2.1.
pub(super) fn weight(vertices: &[PathVertex], s: usize, ends: Ends) -> f64 {
    // p_{i+1}/p_i = forward_i/reverse_i, outwards from s, so that what is divided by has been drawn and is not zero.
    let forward = |i: usize| ends.forward(vertices, i);
    let reverse = |i: usize| ends.reverse(vertices, i);
    let mut sum = 1.0;
    let mut ratio = 1.0;
    for i in s..vertices.len() - 1 {
        ratio *= forward(i) / reverse(i);
        if connectible(vertices, i + 1) {
            sum += ratio * ratio;
        }
    }
    ratio = 1.0;
    for i in (0..s).rev() {
        ratio *= reverse(i) / forward(i);
        if connectible(vertices, i) {
            sum += ratio * ratio;
        }
    }
    1.0 / sum
}

/// Σ_{i ≤ j} (p_i/p_{j+1})² for a light subpath, from the same sum up to j − 1, `before`:
/// S_j = (reverse_j/forward_j)² (c_j + S_{j−1}), with c_j = 1 if x_{j−1} and x_j may be connected, else 0.
///
/// Source: the recursion of [Georgiev12], "Implementing Vertex Connection and Merging", for the power heuristic.
#[inline]
pub(super) fn from_light(vertices: &[PathVertex], j: usize, power: f64, before: f64) -> f64 {
    let forward = Ends::of_image(power).forward(vertices, j);
    square(vertices[j].reverse / forward) * (allowed(vertices, j) + before)
}

/// Σ_{i > j} (p_i/p_j)² for a camera subpath, from the same sum from j + 1, `before`:
/// E_j = (forward_j/reverse_j)² (c_{j+1} + E_{j+1}).
#[inline]
pub(super) fn from_eye(vertices: &[PathVertex], j: usize, before: f64) -> f64 {
    let x = &vertices[j];
    square(x.forward / x.reverse) * (allowed(vertices, j + 1) + before)
}

#[inline]
fn allowed(vertices: &[PathVertex], s: usize) -> f64 {
    f64::from(u8::from(connectible(vertices, s)))
}

/// x²
#[inline]
pub(super) fn square(x: f64) -> f64 {
    x * x
}
