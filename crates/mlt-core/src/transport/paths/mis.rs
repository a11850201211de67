//! Weights of the ways of making one path.
//!
//! A path of n vertices can be made with s vertices from the light and n − s from the camera, s = 0 … n − 1, with density
//! p_s = λ_s Π_{i<s} forward_i · Π_{i≥s} reverse_i. Where s ≥ 1 the edge between x_{s−1} and x_s is a connection, which
//! must not end at a delta vertex: else p_s = 0. x_0 and x_{k−1} are drawn on what [`Ends`] says. Technique 1 draws x_0 for
//! x_1 instead of by power, which makes it λ_1 times as likely; all other λ_s are 1.
//!
//! All densities of whole paths, and f, are stated relative to that of a random camera subpath,
//!
//! g(x) = Π_{1≤i<k} reverse_i,
//!
//! so that every product has one bounded quotient a vertex: f/g = L_e G(x_0, x_1) f_s(x_1) · (throughput of the subpath), and
//! p_s/g = λ_s forward_0 Π_{1≤i<s} forward_i/reverse_i. Fifty geometric terms of 10⁷ overflow f64, their quotients do not.

use super::path::LightPath;
use super::path_vertex::PathVertex;
pub(crate) use super::path_vertex::{connectible, reference};
use crate::transport::lights::LightRegion;
use crate::transport::scene::View;

/// Ends that subpaths start on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    /// Power of the region that x_0 is drawn on.
    pub(crate) power: f64,
    /// λ_1, the [`preference`](LightRegion::preference) of x_1 for x_0.
    pub(crate) preference: f64,
    /// Area of the part of the image, itself of area 1, that the ray to x_{k−1} is drawn through.
    pub(crate) area: f64,
}

impl Ends {
    /// Of subpaths that start in a region and in a part of the image, for one path.
    pub(crate) fn new(path: &LightPath, view: &View, region: &LightRegion, area: f64) -> Self {
        let ends = [&path.vertices[0].vertex, &path.vertices[1].vertex];
        let preference = region.preference(view.scene, ends, &path.light);
        Self { power: region.power(), preference, area }
    }

    /// λ_s.
    #[inline]
    pub(crate) fn preference(&self, s: usize) -> f64 {
        if s == 1 { self.preference } else { 1.0 }
    }

    /// Density per area of x_i, drawn from the light's side; of a distant x_0 per solid angle.
    #[inline]
    pub(crate) fn forward(&self, vertices: &[PathVertex], i: usize) -> f64 {
        if i == 0 { vertices[0].forward / self.power } else { vertices[i].forward }
    }

    /// Density per area of x_i, drawn from the camera's side; of a distant x_0 per solid angle.
    #[inline]
    pub(crate) fn reverse(&self, vertices: &[PathVertex], i: usize) -> f64 {
        if i + 2 == vertices.len() { vertices[i].reverse / self.area } else { vertices[i].reverse }
    }
}

/// g(y)/g(x) over the first n vertices, which x and y have in common: those of the last two depend on what follows.
#[inline]
pub(crate) fn kept_reference(x: &[PathVertex], y: &[PathVertex], n: usize) -> f64 {
    (n.saturating_sub(2)..n).map(|i| reference(y, i) / reference(x, i)).product()
}

/// p_s/g.
pub(crate) fn density(vertices: &[PathVertex], s: usize, ends: Ends) -> f64 {
    let last = vertices.len() - 1;
    let from_light: f64 = (0..s).map(|i| ends.forward(vertices, i) / reference(vertices, i)).product();
    let from_eye: f64 = (s..last).map(|i| ends.reverse(vertices, i) / reference(vertices, i)).product();
    ends.preference(s) * from_light * from_eye
}

/// Whether nothing but a camera subpath that meets the light by chance makes a path: no two neighbours may be connected.
#[inline]
pub(crate) fn met_by_chance(vertices: &[PathVertex]) -> bool {
    (1..vertices.len()).all(|s| !connectible(vertices, s))
}

/// p_s/g of all techniques; 0 where the path cannot be connected.
pub(crate) fn densities(vertices: &[PathVertex], ends: Ends) -> impl Iterator<Item = f64> + Clone {
    let of = move |s| if connectible(vertices, s) { density(vertices, s, ends) } else { 0.0 };
    (0..vertices.len()).map(of)
}

/// The power heuristic's weight of technique s, which must have a positive density: p_s² / Σ_i p_i².
///
/// Source: [Veach97], sections 9.2.4 and 10.2.1.
pub(crate) fn weight(vertices: &[PathVertex], s: usize, ends: Ends) -> f64 {
    // p_{i+1}/p_i = forward_i/reverse_i, but for λ, outwards from s, so that what is divided by has been drawn and is not zero.
    let forward = |i: usize| ends.forward(vertices, i);
    let reverse = |i: usize| ends.reverse(vertices, i);
    let preferred = |i: usize| square(ends.preference(i));
    let mut sum = preferred(s);
    let mut ratio = 1.0;
    for i in s..vertices.len() - 1 {
        ratio *= forward(i) / reverse(i);
        if connectible(vertices, i + 1) {
            sum += ratio * ratio * preferred(i + 1);
        }
    }
    ratio = 1.0;
    for i in (0..s).rev() {
        ratio *= reverse(i) / forward(i);
        if connectible(vertices, i) {
            sum += ratio * ratio * preferred(i);
        }
    }
    preferred(s) / sum
}

/// c_s = λ_s² if x_{s−1} and x_s may be connected, else 0.
#[inline(always)]
pub(crate) fn allowed(vertices: &[PathVertex], s: usize, ends: Ends) -> f64 {
    if connectible(vertices, s) { square(ends.preference(s)) } else { 0.0 }
}

/// Σ_{i ≤ j} (p_i/p_{j+1})² for a light subpath, from the same sum up to j − 1, `before`, but for λ_{j+1}:
/// S_j = (reverse_j/forward_j)² (c_j + S_{j−1}).
///
/// Source: the recursion of [Georgiev12], "Implementing Vertex Connection and Merging", for the power heuristic.
#[inline]
pub(crate) fn from_light(vertices: &[PathVertex], j: usize, ends: Ends, before: f64) -> f64 {
    square(vertices[j].reverse / ends.forward(vertices, j)) * (allowed(vertices, j, ends) + before)
}

/// Σ_{i > j} (p_i/p_j)² for a camera subpath with j ≥ 1, from the same sum from j + 1, `before`:
/// E_j = (forward_j/reverse_j)² (c_{j+1} + E_{j+1}).
#[inline]
pub(crate) fn from_eye(vertices: &[PathVertex], j: usize, before: f64) -> f64 {
    let x = &vertices[j];
    square(x.forward / x.reverse) * (f64::from(u8::from(connectible(vertices, j + 1))) + before)
}

/// x²
#[inline]
pub(crate) fn square(x: f64) -> f64 {
    x * x
}
