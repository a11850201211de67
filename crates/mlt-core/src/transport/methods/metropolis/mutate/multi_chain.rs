//! The multi-chain perturbation: the lens perturbation, one diffuse vertex or more further.
//!
//! Paths of the form … D S* D S* E with two diffuse vertices or more behind the light's: the camera ray is moved as by the
//! lens perturbation, the direction that leaves its first diffuse vertex towards the light is turned by an angle with density
//! ∝ 1/θ² per solid angle, and specular chains are followed through the same events; where another one begins, another direction is
//! turned, until the path can be connected or has come to its light. From there it goes on with probability ½ each time. All moves are
//! symmetric, so with x_m the last vertex that changes
//!
//! T(y→x) / T(x→y) = Π_{m ≤ i < k} q_i(x) / q_i(y),  q_{k−1} = reverse_{k−1},
//!   q_i = reverse_i / P(event at x_{i+1}) after a specular x_{i+1},  q_i = |cosθ_i| / |x_i − x_{i+1}|² after a diffuse one.
//!
//! Without a specular vertex it changes two, which frees what the lens perturbation cannot leave: a short edge in a corner between
//! walls, whose 1/|x_i − x_{i+1}|² is in f and here in q_i as well. Where it goes further, it frees short edges deeper in the path.
//!
//! Source: [VeachGuibas97], section 5.3.3. Left out: their scaling of the angle with the image. Added: chains without a
//! specular vertex, and chains that go on where they could end.

use super::event::is_followed;
use super::follow::ByAngle;
use super::from_eye::{EyePerturbation, FromEye};
use super::lens::first_diffuse;
use crate::engine::uniform;
use crate::transport::paths::LightPath;
use crate::transport::scene::View;
use rand_pcg::rand_core::Rng;

/// Probability of moving another diffuse vertex, where there is one besides the light's.
const FURTHER: f64 = 0.5;

/// Moves the camera ray and turns the directions behind it.
pub type MultiChainPerturbation<'a> = EyePerturbation<'a, MultiChain>;

/// Turns directions by angles.
#[derive(Clone, Copy, Debug)]
pub struct MultiChain;

impl FromEye for MultiChain {
    const NAME: &'static str = "multi-chain";
    type Turn = ByAngle;

    fn applies(view: &View, current: &LightPath) -> bool {
        goes_on(view, current)
    }

    fn draw_end(view: &View, current: &LightPath, rng: &mut impl Rng) -> usize {
        choose_end(view, current, rng)
    }
}

/// Whether a path has another vertex to move behind the first diffuse one.
pub(super) fn goes_on(view: &View, path: &LightPath) -> bool {
    first_diffuse(view, path, path.edges()) >= 2
}

/// Draws the last vertex to change: behind the first diffuse one, and further one time in two as long as there is one.
pub(super) fn choose_end(view: &View, path: &LightPath, rng: &mut impl Rng) -> usize {
    let mut m = next_end(view, path, first_diffuse(view, path, path.edges()));
    while m >= 2 && uniform(rng) < FURTHER {
        m = next_end(view, path, m);
    }
    m
}

/// Below `i`, the first diffuse vertex that can be connected to the one before it; 0 if there is none.
fn next_end(view: &View, path: &LightPath, i: usize) -> usize {
    let mut m = first_diffuse(view, path, i);
    while m > 0 && is_followed(view, path, m - 1) {
        m = first_diffuse(view, path, m);
    }
    m
}
