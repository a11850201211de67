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

use super::event::{is_followed, microfacet, same_events};
use super::follow::{SUITABILITY, TURN, Towards, next_direction, ratio, turned};
use super::lens::first_diffuse;
use crate::engine::Mutation;
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::frame;
use crate::transport::methods::metropolis::stratum::LightStratum;
use crate::transport::paths::LightPath;
use crate::transport::paths::subpath::follow_from_light;
use crate::transport::scene::{Resolved, View};
use glam::Vec3A;
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
        let followed = |i: usize| is_followed(&self.view, current, i);
        if k >= 3 && !followed(k - 1) && followed(k - 2) { SUITABILITY } else { 0.0 }
    }

    fn propose(
        &self,
        current: &LightPath,
        proposal: &mut LightPath,
        _: &LightStratum<'a>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        perturb_from_light(&self.view, current, proposal, first_diffuse(&self.view, current, current.edges() - 1), rng)
    }
}

/// Replaces x_{l+1} … x_{k−1} by perturbed vertices, from the light's side: what leaves x_l is turned, or moved aside if x_l is distant. Then
/// connects x_{k−1} to the camera and returns T(y→x)/T(x→y).
pub(super) fn perturb_from_light(
    view: &View,
    current: &LightPath,
    proposal: &mut LightPath,
    l: usize,
    rng: &mut impl Rng,
) -> Option<f64> {
    let last = current.edges();
    proposal.clone_from(current);
    for i in l..last - 1 {
        let x = &current.vertices[i];
        let ray = if i > l {
            let direction = next_direction(view, [current, proposal], i, Towards::Eye, rng)?;
            proposal.vertices[i].vertex.ray(direction)
        } else if x.vertex.is_distant() {
            moved_aside(view, [&x.vertex, &current.vertices[i + 1].vertex], rng)
        } else {
            x.vertex.ray(turned(x.to_eye, rng))
        };
        follow_from_light(&mut proposal.vertices, i, ray, view, rng)?;
    }
    proposal.connect(view, last, l..=last)?;
    if !same_events(view, [current, proposal], l.max(1)..last) {
        return None;
    }
    Some(ratio([current, proposal], l + 1..last, |path, i| density_from_light(view, path, i, l)))
}

/// The ray of a distant vertex that meets `x_1`, moved aside as a turn would move it at a distance of the scene's radius. The density per
/// area of the disc that the ray starts on depends on the distance alone, so it is that of the way back.
fn moved_aside(view: &View, [x, x_1]: [&Vertex; 2], rng: &mut impl Rng) -> (Vec3A, Vec3A) {
    let (direction, sphere) = (-x.position, view.scene.sphere());
    let (distance, towards) = TURN.draw(rng);
    let (s, t) = frame(direction);
    let through = x_1.position + sphere.radius * distance * (towards.x * s + towards.y * t);
    (sphere.start_of_ray(direction, through), direction)
}

/// q_i of x_i traced from x_{i−1}, where the direction out of x_l is turned.
fn density_from_light(view: &View, path: &LightPath, i: usize, l: usize) -> f64 {
    let (x, before) = (&path.vertices[i], &path.vertices[i - 1]);
    if i - 1 == l {
        return before.per_area_there(1.0);
    }
    let given = -path.vertices[i - 2].to_eye;
    if !before.vertex.delta {
        let Some((lobe, _)) = microfacet(view, path, i - 1) else { return 0.0 };
        let per_slope = lobe.slopes_per_solid_angle(before.vertex.shading_normal, given, before.to_eye);
        return before.per_area_there(1.0) * per_slope;
    }
    x.forward
        / f64::from(
            view.scene.surface(&before.vertex, &mut Resolved::default()).event_probability(given, before.to_eye),
        )
}
