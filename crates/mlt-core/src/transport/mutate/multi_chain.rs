//! The multi-chain perturbation: the lens perturbation through several chains of specular surfaces.
//!
//! Paths of the form (L|D) D S⁺ … D S⁺ D S* E or L S⁺ … D S* E: the camera ray is moved as by the lens perturbation; at
//! each diffuse vertex with a specular one behind it, the direction towards the light is turned by an angle with density
//! ∝ 1/θ² per solid angle, and the chain is followed through the same events, until the path can be connected or has come
//! to its light. All moves are symmetric, so with x_m the last vertex that changes
//!
//! T(y→x) / T(x→y) = Π_{m ≤ i < k} q_i(x) / q_i(y),  q_{k−1} = reverse_{k−1},
//!   q_i = reverse_i / P(event at x_{i+1}) after a specular x_{i+1},  q_i = |cosθ_i| / |x_i − x_{i+1}|² after a diffuse one.
//!
//! Source: [VeachGuibas97], section 5.3.3. Left out: their scaling of the angle with the image.

use super::super::path::{LightPath, View};
use super::follow::perturb_from_eye;
use super::lens::first_diffuse;
use rand_pcg::rand_core::Rng;

/// Moves the camera ray and turns the directions behind it.
#[derive(Clone, Copy)]
pub struct MultiChainPerturbation<'a> {
    /// Scene and camera.
    pub view: View<'a>,
}

impl MultiChainPerturbation<'_> {
    /// 1 for paths with a specular chain that the lens perturbation cannot reach, else 0.
    pub fn suitability(&self, current: &LightPath) -> f64 {
        let m = first_diffuse(current, current.edges());
        let goes_on = m > 0 && current.vertices[m - 1].vertex.delta;
        if goes_on { 1.0 } else { 0.0 }
    }

    /// Writes a path over `proposal` and returns T(y→x)/T(x→y).
    pub fn propose(&self, current: &LightPath, proposal: &mut LightPath, rng: &mut impl Rng) -> Option<f64> {
        let mut m = first_diffuse(current, current.edges());
        while m > 0 && current.vertices[m - 1].vertex.delta {
            m = first_diffuse(current, m);
        }
        perturb_from_eye(&self.view, current, proposal, m, rng)
    }
}
