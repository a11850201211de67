//! Perturbations that begin at the camera: the camera ray is moved, and what lies behind is turned up to a vertex x_m.
//!
//! They differ in the paths that they apply to, in m, and in how an edge behind a diffuse vertex is turned. With x_{k−1} … x_m replaced,
//!
//! T(y→x) / T(x→y) = Π_{m ≤ i < k} q_i(x) / q_i(y),
//!
//! the q_i being those of [`follow`](super::follow).

use super::event::{microfacet, same_events};
use super::follow::{SUITABILITY, Turn, ratio};
use super::log_uniform::LogUniform;
use crate::engine::Mutation;
use crate::transport::bsdf::NarrowLobe;
use crate::transport::geometry::Vertex;
use crate::transport::methods::metropolis::stratum::LightStratum;
use crate::transport::paths::LightPath;
use crate::transport::paths::subpath::start_at_eye;
use crate::transport::scene::{Camera, Resolved, View};
use glam::Vec2;
use rand_pcg::rand_core::Rng;
use std::f32::consts::PI;
use std::marker::PhantomData;

/// Shortest move on the image, pixels: shorter ones are accepted, but leave the pixel's colour as it was.
const LEAST_PIXELS: f32 = 1.0;
/// Area of the largest move on the image, as a share of the image.
const LARGEST_SHARE: f32 = 0.02;
/// Shortest and longest move on a lens, in its radius.
const LEAST_ON_LENS: f32 = 1e-2;
const LARGEST_ON_LENS: f32 = 1.0;

/// How such a perturbation differs from the others.
pub(super) trait FromEye {
    /// Its name in reports.
    const NAME: &'static str;
    /// How often it is chosen where it applies, relative to the bidirectional mutation.
    const SUITABILITY: f64 = SUITABILITY;
    /// Goes on behind a diffuse vertex.
    type Turn: Turn;
    /// Whether it applies to a path.
    fn applies(view: &View, current: &LightPath) -> bool;
    /// Draws m for a path that it applies to.
    fn draw_end(view: &View, current: &LightPath, rng: &mut impl Rng) -> usize;
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

/// Moves the camera ray, and turns what lies behind as `K` says.
#[derive(Clone, Copy, Debug)]
pub struct EyePerturbation<'a, K> {
    view: View<'a>,
    moves: ImageMove,
    kind: PhantomData<K>,
}

impl<'a, K> EyePerturbation<'a, K> {
    /// For the paths of a view.
    pub fn new(view: View<'a>) -> Self {
        Self { view, moves: ImageMove::new(view.camera), kind: PhantomData }
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
        if !same_events(view, [current, proposal], m.max(2) - 1..last) {
            return None;
        }
        Some(turns * ratio([current, proposal], m..last, |path, i| density_from_eye(view, path, i)))
    }
}

impl<'a, K: FromEye> Mutation<LightPath, LightStratum<'a>> for EyePerturbation<'_, K> {
    fn name(&self) -> &'static str {
        K::NAME
    }

    /// Positive for paths that it applies to, else 0.
    fn suitability(&self, current: &LightPath) -> f64 {
        if K::applies(&self.view, current) { K::SUITABILITY } else { 0.0 }
    }

    fn propose(
        &self,
        current: &LightPath,
        proposal: &mut LightPath,
        within: &LightStratum<'a>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let m = K::draw_end(&self.view, current, rng);
        self.perturb::<K::Turn>(current, proposal, m, within, rng)
    }
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
        let narrow = if view.scene.needs().narrow { microfacet(view, path, i + 1) } else { None };
        let per_turn = |(lobe, _): (NarrowLobe, _)| {
            lobe.slopes_per_solid_angle(before.vertex.shading_normal, before.to_eye, -x.to_eye)
        };
        x.per_area_here(1.0) * narrow.map_or(1.0, per_turn)
    }
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
