//! Where light comes from that mirrors and lenses gather, as photons tell.
//!
//! A path that nothing but a camera subpath meets (L S D S E) needs a direction at D that goes through S into the lamp. Light subpaths
//! that go to D know such directions. They are kept as photons, at D with the last specular vertex before it, in a tree for each sequence of
//! reflections and refractions that they came by. A camera subpath that comes to D takes its direction from the photons around it, or by the BSDF:
//!
//! p(ω) = ½ p_s(ω) + ½ Σ_e n_e/n (½ q(ω; d, ε) + ½ 1/n_x Σ_j q(ω; d_j, ε_j))                                          (G1)
//!
//! with n_e of the n photons in tree e, n_x of them in the leaf that D lies in, and q a spherical Cauchy distribution ([`Lobe`](super::lobe::Lobe))
//! about the direction d that a linear fit foretells, or about the direction to the specular vertex of each photon of the leaf.
//!
//! docs/theory-strata.md, section 8. Sources: [Jensen95], photons as a guide for path tracing; [KatoMcCullagh20], the distribution.

use super::events::{Events, is_refraction};
use super::tree::{Photon, Place, Tree};
use crate::engine::{PILOT, Purpose, generator, uniform_f32};
use crate::transport::geometry::Vertex;
use crate::transport::lights::LightRegion;
use crate::transport::methods::settings::Settings;
use crate::transport::paths::PathVertex;
use crate::transport::paths::subpath::{follow_from_light, light_numbers, start_at_light, step_from_light};
use crate::transport::scene::{Resolved, View, rays_traced};
use glam::Vec3A;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Light subpaths for a sample of a round: they take a small part of its time.
const PHOTONS_PER_SAMPLE: f64 = 2.0;
/// Fewest and most of them.
const LIMITS: [f64; 2] = [1024.0, 262_144.0];
/// Number of a round that nothing else has.
const ROUND: u64 = PILOT + (1 << 41);
/// Most trees.
const MOST_TREES: usize = 16;

/// Photons that came through specular surfaces to one that is not.
#[derive(Clone, Debug, Default)]
pub(in crate::transport::methods::bidirectional) struct Photons {
    /// With the share of all photons up to and with those of each.
    trees: Vec<(f32, Tree)>,
}

impl Photons {
    /// For a render, and the rays that it took.
    pub(super) fn new(view: &View, settings: &Settings, lights: &LightRegion) -> (Self, u64) {
        let samples = settings.per_pixel * f64::from(view.camera.pixels());
        let walks = (PHOTONS_PER_SAMPLE * samples).clamp(LIMITS[0], LIMITS[1]) as u64;
        let walk = |i: u64| {
            let before = rays_traced();
            let rng = &mut generator(settings.seed, Purpose::Sample, ROUND, 0, i);
            let photon = photon(view, lights, (settings.most_edges(), i.is_multiple_of(2)), rng);
            (photon, rays_traced() - before)
        };
        let walks: Vec<_> = (0..walks).into_par_iter().map(walk).collect();
        let photons = Self::of(walks.iter().filter_map(|(photon, _)| *photon).collect());
        (photons, walks.iter().map(|(_, rays)| rays).sum())
    }

    fn of(mut photons: Vec<(Events, Photon)>) -> Self {
        photons.sort_by_key(|(events, _)| *events);
        let mut groups: Vec<_> = photons.chunk_by(|a, b| a.0 == b.0).collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        groups.truncate(MOST_TREES);
        let (all, mut so_far) = (groups.iter().map(|group| group.len()).sum::<usize>(), 0);
        let tree = |group: &[(Events, Photon)]| {
            so_far += group.len();
            (so_far as f32 / all as f32, Tree::new(group.iter().map(|(_, photon)| *photon).collect()))
        };
        Self { trees: groups.into_iter().map(tree).collect() }
    }

    /// Draws a direction at x; nothing where there are no photons.
    pub(in crate::transport::methods::bidirectional) fn sample(&self, x: &Vertex, rng: &mut impl Rng) -> Option<Vec3A> {
        let chosen = uniform_f32(rng);
        let (_, tree) = self.trees.iter().find(|(so_far, _)| chosen < *so_far)?;
        Some(tree.sample(x, rng))
    }

    /// The density of the directions that [`sample`](Self::sample) draws, sr⁻¹; nothing where there are no photons.
    pub(in crate::transport::methods::bidirectional) fn density(&self, x: &Vertex, direction: Vec3A) -> Option<f32> {
        let mut before = 0.0;
        let part = |(so_far, tree): &(f32, Tree)| {
            let share = so_far - before;
            before = *so_far;
            share * tree.density(x, direction)
        };
        (!self.trees.is_empty()).then(|| self.trees.iter().map(part).sum())
    }

    /// Places of about so many photons, half of them as many of each tree: see [`Tree::places`].
    pub(super) fn places(&self, count: usize) -> impl Iterator<Item = (Vec3A, f32)> {
        let (all, trees) = (self.trees.iter().map(|(_, tree)| tree.len()).sum::<usize>(), self.trees.len());
        self.trees
            .iter()
            .flat_map(move |(_, tree)| tree.places(count.div_ceil(2 * trees) + count * tree.len() / (2 * all)))
    }
}

/// A light subpath's first vertex that is not specular, and the events before it, if there are some. `even`: reflection and refraction are
/// chosen evenly, so that rare ones have photons, too.
fn photon(
    view: &View,
    lights: &LightRegion,
    (max_edges, even): (usize, bool),
    rng: &mut impl Rng,
) -> Option<(Events, Photon)> {
    let (x_0, _) = start_at_light(view, lights, light_numbers(rng));
    let (mut vertices, mut events) = (vec![x_0], Events::default());
    for i in 0..max_edges.saturating_sub(1).min(Events::MOST + 1) {
        vertices.push(PathVertex::new(x_0.vertex));
        if even && i > 0 {
            step_evenly(&mut vertices, i, view, rng)?;
        } else {
            step_from_light(&mut vertices, i, view, rng)?;
        }
        if i > 0 {
            events = events.with(is_refraction(&vertices[i], -vertices[i - 1].to_eye))?;
        }
        let [from, x] = [vertices[i].vertex, vertices[i + 1].vertex];
        if !x.delta {
            return (i > 0).then_some((events, Photon { at: Place::of(&x), from: from.position }));
        }
    }
    None
}

/// Draws x_{i+1} from x_i, which is specular, by one of both events if both are possible.
fn step_evenly(vertices: &mut [PathVertex], i: usize, view: &View, rng: &mut impl Rng) -> Option<()> {
    let (x, to_light) = (&vertices[i].vertex, -vertices[i - 1].to_eye);
    let (mut room, refracts) = (Resolved::default(), uniform_f32(rng) < 0.5);
    let surface = view.scene.surface(x, &mut room);
    let direction =
        surface.delta_direction(to_light, refracts).or_else(|| surface.delta_direction(to_light, !refracts))?;
    let ray = x.ray(direction);
    follow_from_light(vertices, i, ray, view, rng)
}
