//! The lens perturbation: move the path on the image, keep what lies behind its first diffuse surface.
//!
//! Paths of the form (L|D) D S* E or L S* E: the camera ray is moved by a distance with density ∝ 1/r² per area of the
//! image, the chain of specular surfaces is followed through the same events, and its end x_m is connected to
//! x_{m−1}. The move on the image is symmetric, so
//!
//! T(y→x) / T(x→y) = Π_{m ≤ i < k} q_i(x) / q_i(y),  q_{k−1} = reverse_{k−1},  q_i = reverse_i / P(event at x_{i+1}),
//!
//! q_i being the density of x_i when the image point is uniform and the events are given.
//!
//! Source: [VeachGuibas97], section 5.3.3.

use super::super::path::{LightPath, View};
use super::follow::{SUITABILITY, perturb_from_eye};
use rand_pcg::rand_core::Rng;

/// Moves the camera ray.
#[derive(Clone, Copy)]
pub struct LensPerturbation<'a> {
    /// Scene and camera.
    pub view: View<'a>,
}

impl LensPerturbation<'_> {
    /// Positive for paths of its form, else 0.
    pub fn suitability(&self, current: &LightPath) -> f64 {
        let m = first_diffuse(current, current.edges());
        let connects = m == 0 || !current.vertices[m - 1].vertex.delta;
        if connects { SUITABILITY } else { 0.0 }
    }

    /// Writes a path over `proposal` and returns T(y→x)/T(x→y).
    pub fn propose(&self, current: &LightPath, proposal: &mut LightPath, rng: &mut impl Rng) -> Option<f64> {
        perturb_from_eye(&self.view, current, proposal, first_diffuse(current, current.edges()), rng)
    }
}

/// Index of the first vertex below `i` that is not a delta one; 0 at the latest.
pub(super) fn first_diffuse(path: &LightPath, i: usize) -> usize {
    let mut m = i - 1;
    while m > 0 && path.vertices[m].vertex.delta {
        m -= 1;
    }
    m
}
