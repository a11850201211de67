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

use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::{self, eighth_turn, frame, on_circle};
use crate::transport::methods::metropolis::stratum::LightStratum;
use crate::transport::paths::mis::kept_reference;
use crate::transport::paths::subpath::{follow_from_eye, follow_from_light, start_at_eye};
use crate::transport::paths::{LightPath, reference};
use crate::transport::scene::{Camera, Resolved, View};
use glam::{Vec2, Vec3A};
use rand_pcg::rand_core::Rng;
use std::f32::consts::PI;
use std::ops::Range;

/// How often a perturbation is chosen where it applies, relative to the bidirectional mutation: it costs less and is accepted
/// three times as often.
pub(super) const SUITABILITY: f64 = 4.0;
/// Least angle of a turn, radians.
const LEAST_TURN: f32 = 1e-3;
/// Largest angle of a turn, radians.
const LARGEST_TURN: f32 = 0.3;
/// The law of turns.
const TURN: LogUniform = LogUniform::new(LEAST_TURN, LARGEST_TURN);
/// Shortest move on the image, pixels: shorter ones are accepted, but leave the pixel's colour as it was.
const LEAST_PIXELS: f32 = 1.0;
/// Area of the largest move on the image, as a share of the image.
const LARGEST_SHARE: f32 = 0.02;
/// Shortest and longest move on a lens, in its radius.
const LEAST_ON_LENS: f32 = 1e-2;
const LARGEST_ON_LENS: f32 = 1.0;

/// `unit` turned by an angle of density ∝ 1/θ, uniformly about it. The density per solid angle depends on θ alone, so it is
/// that of the way back.
pub(super) fn turned(unit: Vec3A, rng: &mut impl Rng) -> Vec3A {
    let (angle, about) = TURN.draw(rng);
    let Vec2 { x: cos, y: sin } = eighth_turn(angle);
    let (s, t) = frame(unit);
    // Turned again and again, a vector that is not of length 1 would drift away from it.
    math::unit(cos * unit + sin * (about.x * s + about.y * t))
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

/// The law of moves on an image: by a distance with density ∝ 1/r in steps, in pixels, in any direction.
#[derive(Clone, Copy, Debug)]
struct ImageMove {
    /// In pixels.
    distance: LogUniform,
    /// Size of a pixel, in [0, 1)².
    pixel: Vec2,
}

impl ImageMove {
    fn new(camera: &Camera) -> Self {
        let [w, h] = camera.size().map(|n| n as f32);
        let largest = (LARGEST_SHARE * w * h / PI).sqrt().max(2.0 * LEAST_PIXELS);
        Self { distance: LogUniform::new(LEAST_PIXELS, largest), pixel: Vec2::new(w, h).recip() }
    }

    /// A point some way from `image` in the rectangle between two corners, whose sides mirror what would leave it; `None` if one
    /// reflection at a side does not bring it back.
    ///
    /// Mirrored at a side, y is reached from x as the mirror image y* is, and |y* − x| = |y − x*|: the way back has the same density.
    #[inline]
    fn apply(&self, film: Vec2, [low, high]: [Vec2; 2], rng: &mut impl Rng) -> Option<Vec2> {
        let (distance, towards) = self.distance.draw(rng);
        let moved = film + distance * towards * self.pixel;
        let inside = |p: Vec2| p.cmpge(low).all() && p.cmplt(high).all();
        if inside(moved) {
            return Some(moved);
        }
        let mirrored = Vec2::select(moved.cmplt(low), 2.0 * low - moved, moved);
        let mirrored = Vec2::select(moved.cmpge(high), 2.0 * high - moved, mirrored);
        inside(mirrored).then_some(mirrored)
    }
}

/// Lengths between two: each octave is as likely as any other, and within one all lengths are. That is 1/r in steps of an octave. The
/// law does not depend on the state, so it cancels in T(y→x)/T(x→y).
#[derive(Clone, Copy, Debug)]
struct LogUniform {
    /// Bits of the largest.
    largest: u32,
    /// Bits of the largest less those of the least: 2²³ an octave.
    range: u32,
}

impl LogUniform {
    const fn new(least: f32, largest: f32) -> Self {
        Self { largest: largest.to_bits(), range: largest.to_bits() - least.to_bits() }
    }

    /// A length, and a direction of the plane, uniformly.
    #[inline(always)]
    fn draw(&self, rng: &mut impl Rng) -> (f32, Vec2) {
        let random = rng.next_u64();
        let below = (u64::from(random as u32) * u64::from(self.range)) >> 32;
        (f32::from_bits(self.largest - below as u32), on_circle((random >> 32) as u32))
    }
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

/// Perturbations that begin at the camera: the camera ray is moved, and the edge behind a diffuse vertex is turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct FromEye<'a> {
    view: View<'a>,
    moves: ImageMove,
}

impl<'a> FromEye<'a> {
    pub(super) fn new(view: View<'a>) -> Self {
        Self { view, moves: ImageMove::new(view.camera) }
    }

    /// A vertex on the lens moved some way; `None` beyond its rim. The density of the way back is the same.
    fn moved_on_lens(&self, lens: &Vertex, rng: &mut impl Rng) -> Option<Vertex> {
        const DISTANCE: LogUniform = LogUniform::new(LEAST_ON_LENS, LARGEST_ON_LENS);
        let (distance, towards) = DISTANCE.draw(rng);
        self.view.camera.move_on_lens(lens, distance * towards)
    }

    /// Replaces x_{k−1} … x_m by perturbed vertices; on the image the path stays in the stratum's part. Then connects x_m to x_{m−1},
    /// unless it is a light itself, and returns T(y→x)/T(x→y).
    pub(super) fn perturb<T: Turn>(
        &self,
        current: &LightPath,
        proposal: &mut LightPath,
        m: usize,
        within: &LightStratum,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let view = &self.view;
        let film = self.moves.apply(current.film, within.image_corners(), rng)?;
        let last = current.edges();
        proposal.keep_light_end(current, m);
        proposal.cross(view, film);
        if view.camera.has_aperture() {
            proposal.vertices[last].vertex = self.moved_on_lens(&current.vertices[last].vertex, rng)?;
        }
        start_at_eye(&mut proposal.vertices, last, film, view, rng)?;
        let mut turns = 1.0;
        for i in (m + 1..last).rev() {
            turns *= T::follow(view, current, proposal, i, rng)?;
        }
        if proposal.vertices[m].vertex.delta {
            return None;
        }
        let changed = m.saturating_sub(1)..=last;
        if m == 0 {
            let x = &proposal.vertices[0].vertex;
            proposal.light = view.scene.lights().point(x.primitive, x.position)?;
            proposal.update(view, changed)?;
        } else {
            proposal.connect(view, m, changed)?;
        }
        Some(turns * ratio([current, proposal], m..last, |path, i| density_from_eye(view, path, i)))
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
    Some(ratio([current, proposal], l + 1..last, |path, i| density_from_light(view, path, i, l)))
}

/// T(y→x)/T(x→y), relative to g, of vertices that are replaced with these densities q_i.
#[inline(always)]
fn ratio([x, y]: [&LightPath; 2], replaced: Range<usize>, q: impl Fn(&LightPath, usize) -> f64) -> f64 {
    let relative = |path: &LightPath, i: usize| q(path, i) / reference(&path.vertices, i);
    let kept = kept_reference(&x.vertices, &y.vertices, replaced.start);
    replaced.map(|i| relative(x, i) / relative(y, i)).product::<f64>() * kept
}

/// Which end of the path the tracing goes to.
#[derive(Clone, Copy, PartialEq)]
enum Towards {
    Light,
    Eye,
}

/// The direction in which `proposal` goes on from x_i: the event that `current` has there if both are specular, its direction
/// turned if neither is; `None` if they differ.
fn next_direction(
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
    if !old.vertex.delta {
        return Some(turned(if towards == Towards::Light { to_light } else { old.to_eye }, rng));
    }
    let n = old.vertex.shading_normal;
    let transmits = n.dot(old.to_eye) * n.dot(to_light) < 0.0;
    let given = if towards == Towards::Light { new.to_eye } else { -proposal.vertices[i - 1].to_eye };
    view.scene.surface(&new.vertex, &mut Resolved::default()).delta_direction(given, transmits)
}

/// q_i of x_i traced from x_{i+1}.
fn density_from_eye(view: &View, path: &LightPath, i: usize) -> f64 {
    let (x, before) = (&path.vertices[i], &path.vertices[i + 1]);
    if before.vertex.is_camera() {
        x.reverse
    } else if before.vertex.delta {
        x.reverse
            / f64::from(
                view.scene
                    .surface(&before.vertex, &mut Resolved::default())
                    .event_probability(before.to_eye, -x.to_eye),
            )
    } else {
        x.per_area_here(1.0)
    }
}

/// q_i of x_i traced from x_{i−1}, where the direction out of x_l is turned.
fn density_from_light(view: &View, path: &LightPath, i: usize, l: usize) -> f64 {
    let (x, before) = (&path.vertices[i], &path.vertices[i - 1]);
    if i - 1 == l {
        return before.per_area_there(1.0);
    }
    let given = -path.vertices[i - 2].to_eye;
    x.forward
        / f64::from(
            view.scene.surface(&before.vertex, &mut Resolved::default()).event_probability(given, before.to_eye),
        )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Generator, Purpose, generator, uniform_f32};
    use glam::UVec2;

    /// χ² of the counts in 8×8 cells, 63 degrees of freedom, of points that lay evenly in a tile before `step` moved them.
    fn unevenness(step: impl Fn(&ImageMove, Vec2, [Vec2; 2], &mut Generator) -> Vec2) -> f64 {
        const MOVED: u32 = 1_024_000;
        let moves = ImageMove { distance: LogUniform::new(LEAST_PIXELS, 5.0), pixel: Vec2::splat(1.0 / 64.0) };
        let corners @ [low, high] = [Vec2::new(0.25, 0.5), Vec2::new(0.5, 0.75)];
        let mut rng = generator(3, Purpose::Chain, 0, 0, 0);
        let mut counts = [0.0; 64];
        for _ in 0..MOVED {
            let x = low + (high - low) * Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng));
            let moved = (step(&moves, x, corners, &mut rng) - low) / (high - low);
            let cell = (8.0 * moved).as_uvec2().min(UVec2::splat(7));
            counts[(cell.y * 8 + cell.x) as usize] += 1.0;
        }
        let expected = f64::from(MOVED) / 64.0;
        counts.iter().map(|n: &f64| (n - expected).powi(2) / expected).sum()
    }

    /// A law that is the same there and back keeps an even spread even. The control stops at the tile's sides instead.
    #[test]
    fn image_moves_are_mirrored_at_the_sides() {
        // What falls on a side itself, but for rounding, is rejected.
        let mirrored = unevenness(|moves, x, corners, rng| moves.apply(x, corners, rng).unwrap_or(x));
        assert!(mirrored < 120.0, "{mirrored}");
        let stopped = unevenness(|moves, x, [low, high], rng| {
            moves.apply(x, [Vec2::splat(-1.0), Vec2::splat(2.0)], rng).expect("room").clamp(low, high)
        });
        assert!(stopped > 1000.0, "{stopped}");
    }
}
