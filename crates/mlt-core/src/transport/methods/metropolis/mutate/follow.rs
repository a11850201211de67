//! Shared by perturbations: small turns of a direction, and the same specular events followed again.
//!
//! A perturbation replaces neighbouring vertices one by one: the first direction out of a vertex that is not specular is
//! turned, and at specular vertices the old event (reflection, transmission) is repeated. With the vertices in the order in
//! which they are traced, its density is Π q_i, per area of each vertex, and the turns' own densities cancel:
//!
//! q_i = |cosθ_i| / d²              after a turn,             d: distance to the vertex before
//! q_1 = |cosθ_1|                   after a ray of a distant light that is moved aside, per area of the disc it starts on
//! q_i = forward_i / P(event)       after a specular vertex   (reverse_i where the tracing goes towards the light)
//! q_i = reverse_i                  after the camera.
//!
//! The pivot perturbation turns an edge about a point on it instead: another [`Turn`], with another density.
//!
//! All of them are taken relative to the density g of [`mis`], which changes at the vertices that are kept, too.

use super::event::{microfacet, moved};
use super::log_uniform::LogUniform;
use crate::transport::geometry::math::{self, eighth_turn, frame};
use crate::transport::paths::mis::kept_reference;
use crate::transport::paths::subpath::follow_from_eye;
use crate::transport::paths::{LightPath, reference};
use crate::transport::scene::{Resolved, View};
use glam::{Vec2, Vec3A};
use rand_pcg::rand_core::Rng;
use std::ops::Range;

/// How often a perturbation is chosen where it applies, relative to the bidirectional mutation: it costs less and is accepted
/// three times as often.
pub(super) const SUITABILITY: f64 = 4.0;
/// Least angle of a turn, radians.
const LEAST_TURN: f32 = 1e-3;
/// Largest angle of a turn, radians.
const LARGEST_TURN: f32 = 0.3;
/// The law of turns.
pub(super) const TURN: LogUniform = LogUniform::new(LEAST_TURN, LARGEST_TURN);

/// `unit` turned by an angle of density ∝ 1/θ, uniformly about it. The density per solid angle depends on θ alone, so it is
/// that of the way back.
pub(super) fn turned(unit: Vec3A, rng: &mut impl Rng) -> Vec3A {
    let (angle, about) = TURN.draw(rng);
    let Vec2 { x: cos, y: sin } = eighth_turn(angle);
    let (s, t) = frame(unit);
    // Turned again and again, a vector that is not of length 1 would drift away from it.
    math::unit(cos * unit + sin * (about.x * s + about.y * t))
}

/// A way of going on from a replaced vertex towards the light.
pub(super) trait Turn {
    /// Replaces x_{i−1} by y_{i−1}, which is met from y_i, and sets the edge between them. Returns the quotient of the densities of x_{i−1}
    /// and y_{i−1}, over that of a turn by an angle.
    fn follow(view: &View, current: &LightPath, proposal: &mut LightPath, i: usize, rng: &mut impl Rng) -> Option<f64>;
}

/// Turns a direction by an angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByAngle;

impl Turn for ByAngle {
    #[inline(always)]
    fn follow(view: &View, current: &LightPath, proposal: &mut LightPath, i: usize, rng: &mut impl Rng) -> Option<f64> {
        let direction = next_direction(view, [current, proposal], i, Towards::Light, rng)?;
        follow_from_eye(&mut proposal.vertices, i, direction, view, rng)?;
        Some(1.0)
    }
}

/// T(y→x)/T(x→y), relative to g, of vertices that are replaced with these densities q_i.
#[inline(always)]
pub(super) fn ratio([x, y]: [&LightPath; 2], replaced: Range<usize>, q: impl Fn(&LightPath, usize) -> f64) -> f64 {
    let relative = |path: &LightPath, i: usize| q(path, i) / reference(&path.vertices, i);
    let kept = kept_reference(&x.vertices, &y.vertices, replaced.start);
    replaced.map(|i| relative(x, i) / relative(y, i)).product::<f64>() * kept
}

/// Which end of the path the tracing goes to.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Towards {
    Light,
    Eye,
}

/// The direction in which `proposal` goes on from x_i: the event that `current` has there if both are specular, its direction
/// turned if neither is; `None` if they differ.
pub(super) fn next_direction(
    view: &View,
    [current, proposal]: [&LightPath; 2],
    i: usize,
    towards: Towards,
    rng: &mut impl Rng,
) -> Option<Vec3A> {
    let (old, new) = (&current.vertices[i], &proposal.vertices[i]);
    if old.vertex.delta != new.vertex.delta {
        return None;
    }
    let to_light = -current.vertices[i - 1].to_eye;
    let given = if towards == Towards::Light { new.to_eye } else { -proposal.vertices[i - 1].to_eye };
    if old.vertex.delta {
        let n = old.vertex.shading_normal;
        let transmits = n.dot(old.to_eye) * n.dot(to_light) < 0.0;
        return view.scene.surface(&new.vertex, &mut Resolved::default()).delta_direction(given, transmits);
    }
    if view.scene.needs().narrow
        && let Some((_, facet)) = microfacet(view, current, i)
    {
        let lobe = view.scene.surface(&new.vertex, &mut Resolved::default()).narrow_lobe()?;
        return lobe.direction(new.vertex.shading_normal, given, moved(facet, rng)?);
    }
    Some(turned(if towards == Towards::Light { to_light } else { old.to_eye }, rng))
}
