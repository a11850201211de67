//! The caustic perturbation: turn the light that leaves the surface before the last chain of specular ones.
//!
//! Paths of the form (L|D) S⁺ D E: the direction out of x_l, the end of the chain at the light's side, is turned by an
//! angle with density ∝ 1/θ² per solid angle, the chain is followed through the same events to x_{k−1}, and that is
//! connected to the camera. A distant x_0 keeps its direction, and its ray is moved aside. Turn and move are symmetric, so
//!
//! T(y→x) / T(x→y) = Π_{l < i < k} q_i(x) / q_i(y),  q_{l+1} = |cosθ_{l+1}| / |x_l − x_{l+1}|²,
//!                                                   q_i = forward_i / P(event at x_{i−1}).
//!
//! Source: [VeachGuibas97], section 5.3.3. Left out: their scaling of the angle with the distance to the camera.

use super::follow::{SUITABILITY, perturb_from_light};
use super::lens::first_diffuse;
use crate::engine::Mutation;
use crate::transport::methods::metropolis::stratum::LightStratum;
use crate::transport::paths::LightPath;
use crate::transport::scene::View;
use rand_pcg::rand_core::Rng;

/// Turns the direction that a caustic comes from.
#[derive(Clone, Copy, Debug)]
pub struct CausticPerturbation<'a> {
    /// Scene and camera.
    pub view: View<'a>,
}

impl<'a> Mutation<LightPath, LightStratum<'a>> for CausticPerturbation<'_> {
    fn name(&self) -> &'static str {
        "caustic"
    }

    /// Positive for paths of its form, else 0.
    fn suitability(&self, current: &LightPath) -> f64 {
        let k = current.edges();
        let specular = |i: usize| current.vertices[i].vertex.delta;
        if k >= 3 && !specular(k - 1) && specular(k - 2) { SUITABILITY } else { 0.0 }
    }

    fn propose(
        &self,
        current: &LightPath,
        proposal: &mut LightPath,
        _: &LightStratum<'a>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        perturb_from_light(&self.view, current, proposal, first_diffuse(current, current.edges() - 1), rng)
    }
}
