//! Where light comes from that mirrors and lenses gather, as photons tell.
//!
//! A path that nothing but a camera subpath meets (L S D S E) needs a direction at D that goes through S into the lamp. Light subpaths
//! that go to D know such directions. They are kept as photons, at D with the last specular vertex before it, in a tree for each sequence of
//! reflections and refractions that they came by and each material that they came from. A camera subpath that comes to D takes its direction from the
//! photons around it, or by the BSDF:
//!
//! p(ω) = ½ p_s(ω) + ½ Σ_e s_e (⅓ q(ω; d, ε) + ⅓ 1/n_e Σ_j q(ω; d_j, ε_j) + ⅓ 1/m_e Σ_k q(ω; d_k, ε_k)),   s_e = ¾ a_e/Σ a + ¼ 1/K      (G1)
//!
//! with K trees, n_e photons in the leaf of tree e that D lies in, and about a_e of them an area there. q is a spherical Cauchy distribution
//! ([`Lobe`](super::lobe::Lobe)) about the direction d that a [`Fit`](super::fit::Fit) foretells, the direction to the specular vertex of each photon of
//! the leaf, or the one of each of m_e [`Clusters`](super::clusters::Clusters) of the photons farther around.
//!
//! docs/theory-strata.md, section 8. Sources: [Jensen95], photons as a guide for path tracing; [KatoMcCullagh20], the distribution.

use super::place::Photon;
use super::tree::Tree;
use super::walk::{Walk, Walker, Way};
use crate::engine::{PILOT, Purpose, generator, uniform};
use crate::transport::geometry::Vertex;
use crate::transport::lights::LightRegion;
use crate::transport::methods::settings::Settings;
use crate::transport::scene::{View, rays_traced};
use glam::Vec3A;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;
use std::array;

/// Light subpaths for a sample of a round, half of them near one that ended as a photon: they take a small part of its time.
const PHOTONS_PER_SAMPLE: f64 = 2.0;
/// Fewest and most of them.
const LIMITS: [f64; 2] = [1024.0, 262_144.0];
/// Number of a round that nothing else has.
const ROUND: u64 = PILOT + (1 << 41);
/// Most trees, and fewest photons of one: fewer tell nothing of what lies around them.
const MOST_TREES: usize = 16;
const FEWEST: usize = 8;
/// Share of directions from trees that have photons here.
const LOCAL: f64 = 0.75;

/// Photons that came through specular surfaces to one that is not.
#[derive(Clone, Debug, Default)]
pub(in crate::transport::methods::bidirectional) struct Photons {
    trees: Vec<Tree>,
}

impl Photons {
    /// For a render, and the rays that it took.
    pub(super) fn new(view: &View, settings: &Settings, lights: &LightRegion) -> (Self, u64) {
        let samples = settings.per_pixel * f64::from(view.camera.pixels());
        let walks = (PHOTONS_PER_SAMPLE * samples).clamp(LIMITS[0], LIMITS[1]) as u64;
        let (walks, walker) = (walks / 2, Walker { view, lights, max_edges: settings.most_edges() });
        let rng = |kind, i| generator(settings.seed, Purpose::Sample, ROUND, kind, i);
        let (found, rays) = walked(walks, |i| walker.any(i.is_multiple_of(2), &mut rng(0, i)));
        let parent = |i| &found[(i * found.len() as u64 / walks) as usize];
        let more = if found.is_empty() { 0 } else { walks };
        let (near, rays_near) = walked(more, |i| walker.near(parent(i), &mut rng(1, i)));
        let all = found.iter().chain(&near).map(|walk| (walk.way(), walk.photon)).collect();
        (Self::of(all), rays + rays_near)
    }

    fn of(mut photons: Vec<(Way, Photon)>) -> Self {
        photons.sort_by_key(|(way, _)| *way);
        let mut groups: Vec<_> = photons.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() >= FEWEST).collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        groups.truncate(MOST_TREES);
        let tree = |group: &[(Way, Photon)]| Tree::new(group.iter().map(|(_, photon)| *photon).collect());
        Self { trees: groups.into_iter().map(tree).collect() }
    }

    /// Draws a direction at x; nothing where there are no photons.
    pub(in crate::transport::methods::bidirectional) fn sample(&self, x: &Vertex, rng: &mut impl Rng) -> Option<Vec3A> {
        let (local, chosen) = (uniform(rng) < LOCAL, uniform(rng));
        let here: [f64; MOST_TREES] =
            array::from_fn(|i| self.trees.get(i).map_or(0.0, |tree| tree.near(x).photons_per_area()));
        let (mut rest, all) = (chosen * here.iter().sum::<f64>(), self.trees.len());
        let any = (chosen * all as f64) as usize;
        let nearest = here.iter().position(|photons| {
            rest -= photons;
            rest < 0.0
        });
        let number = if local { nearest.unwrap_or(any) } else { any };
        self.trees.get(number).map(|tree| tree.near(x).sample(rng))
    }

    /// The density of the directions that [`sample`](Self::sample) draws, sr⁻¹; nothing where there are no photons.
    pub(in crate::transport::methods::bidirectional) fn density(&self, x: &Vertex, direction: Vec3A) -> Option<f32> {
        let with = |[photons, here, sum]: [f64; 3], tree: &Tree| {
            let near = tree.near(x);
            let (of_tree, density) = (near.photons_per_area(), f64::from(near.density(direction)));
            [photons + of_tree, here + of_tree * density, sum + density]
        };
        let [photons, here, sum] = self.trees.iter().fold([0.0; 3], with);
        let any = sum / self.trees.len() as f64;
        let local = if photons > 0.0 { here / photons } else { any };
        (!self.trees.is_empty()).then_some((LOCAL * local + (1.0 - LOCAL) * any) as f32)
    }

    /// Places of about so many photons, half of them as many of each tree: see [`Tree::places`].
    pub(super) fn places(&self, count: usize) -> impl Iterator<Item = (Vec3A, f32)> {
        let (all, trees) = (self.trees.iter().map(Tree::len).sum::<usize>(), self.trees.len());
        let of_tree = move |tree: &Tree| count.div_ceil(2 * trees) + count * tree.len() / (2 * all);
        self.trees.iter().flat_map(move |tree| tree.places(of_tree(tree)))
    }
}

/// Those of so many walks that end as a photon, and the rays of all.
fn walked(count: u64, walk: impl Fn(u64) -> Option<Walk> + Sync) -> (Vec<Walk>, u64) {
    let counted = |i| {
        let before = rays_traced();
        let walk = walk(i);
        (walk, rays_traced() - before)
    };
    let walks: Vec<_> = (0..count).into_par_iter().map(counted).collect();
    (walks.iter().filter_map(|(walk, _)| *walk).collect(), walks.iter().map(|(_, rays)| rays).sum())
}
