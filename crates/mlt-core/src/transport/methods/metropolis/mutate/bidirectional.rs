//! The bidirectional mutation: delete a subpath, trace a new one.
//!
//! With s vertices kept on the light's side and t on the camera's (the camera itself is always kept, but for its point of
//! the lens where t = 1), d are deleted and a
//! new ones are traced, a′ of them from the light's side and a − a′ from the camera's, and the two ends are connected:
//!
//! T(x→y | s, t) = P(d | n_x) / (n_x − d) · P(a | d) · Σ_{a′} P(a′ | a) Π_{s ≤ i < s+a′} forward_i(y) Π_{s+a′ ≤ i < s+a} reverse_i(y)
//!
//! All a′ that could have made y are counted. The way back deletes a and traces d, with the same s and t. Densities are those
//! of [`Ends`]: x_0 is drawn on the stratum's part of the lights, for x_1 where it is the only new vertex from the light's side
//! (s = 0, a′ = 1) and so comes last; and x_{k−1} through the stratum's part of the image. They are relative to g, as those of
//! [`mis`] are; so the ratio has the factor g(y)/g(x) over the vertices that are kept on the light's side.
//!
//! Source: [VeachGuibas97], section 5.3.1; in a stratum: [Jankauski15], section 4.2.

use crate::engine::{Mutation, uniform};
use crate::transport::lights::LightRegion;
use crate::transport::methods::metropolis::stratum::LightStratum;
use crate::transport::paths::mis::Ends;
use crate::transport::paths::subpath::{
    light_numbers, start_at_eye, start_at_light, start_near, step_from_eye, step_from_light,
};
use crate::transport::paths::{LightPath, PathVertex, copy_vertices, mis};
use crate::transport::scene::View;
use rand_pcg::rand_core::Rng;
use std::array;

/// P(d): relative weight of deleting no vertex; of deleting d = 1, 2 … it is 2^−d.
const NONE_DELETED: f64 = 0.1;
/// P(a | d): relative weights of |a − d| = 0, 1, 2.
const CHANGE: [f64; 3] = [0.5, 0.15, 0.05];
/// Relative weight of techniques that seldom succeed: a light is hit by chance, or the camera is connected to.
const CHANCE: f64 = 0.25;

/// Deletes a subpath and traces a new one; what replaces the light end starts on the stratum.
#[derive(Clone, Copy, Debug)]
pub struct BidirectionalMutation<'a> {
    /// Scene and camera.
    pub view: View<'a>,
}

/// Which vertices stay, and how many come between them.
#[derive(Clone, Copy)]
struct Edit {
    /// Vertices kept on the light's side.
    s: usize,
    /// Vertices kept on the camera's side.
    t: usize,
    /// Vertices between them: before.
    deleted: usize,
    /// Vertices between them: after.
    added: usize,
}

impl<'a> Mutation<LightPath, LightStratum<'a>> for BidirectionalMutation<'_> {
    fn name(&self) -> &'static str {
        "bidirectional"
    }

    fn propose(
        &self,
        current: &LightPath,
        proposal: &mut LightPath,
        within: &LightStratum<'a>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let edit = Edit::draw(current.vertices.len(), within.max_edges(), rng)?;
        let split = edit.draw_split(rng);
        edit.copy_kept(current, proposal);
        let region = within.region_at(&current.light);
        self.trace(proposal, &edit, split, (within, region), rng)?;
        Some(edit.ratio(current, proposal, within))
    }
}

impl BidirectionalMutation<'_> {
    /// Traces the new vertices, `split` of them from the light's side, connects, and evaluates the path.
    fn trace(
        &self,
        path: &mut LightPath,
        edit: &Edit,
        split: usize,
        (within, region): (&LightStratum, &LightRegion),
        rng: &mut impl Rng,
    ) -> Option<()> {
        let joint = edit.s + split;
        if edit.t == 1 && self.view.camera.has_aperture() {
            path.vertices[edit.s + edit.added].vertex = self.view.camera.sample_lens(rng);
        }
        let light_end = (edit.s == 0 && split > 0).then(|| light_numbers(rng));
        if let (Some(numbers), 2..) = (light_end, joint) {
            (path.vertices[0], path.light) = start_at_light(&self.view, region, numbers);
        }
        for i in edit.s.max(1)..joint {
            step_from_light(&mut path.vertices, i - 1, &self.view, rng)?;
        }
        for i in (joint..edit.s + edit.added).rev() {
            if path.vertices[i + 1].vertex.is_camera() {
                let film = within.image_point(rng);
                path.cross(&self.view, film);
                start_at_eye(&mut path.vertices, i + 1, film, &self.view, rng)?;
            } else {
                step_from_eye(&mut path.vertices, i + 1, &self.view, rng)?;
            }
        }
        if let (Some(numbers), 1) = (light_end, joint) {
            let x_1 = &path.vertices[1];
            (path.vertices[0], path.light, _) = start_near(&self.view, region, x_1, numbers);
        }
        let changed = edit.s.saturating_sub(1)..=edit.s + edit.added;
        if joint == 0 {
            let x = &path.vertices[0].vertex;
            path.light = self.view.scene.lights().point(x.primitive, x.position)?;
            return path.update(&self.view, changed);
        }
        path.connect(&self.view, joint, changed)
    }
}

impl Edit {
    /// Draws s, t and the number of new vertices for a path of n vertices; `None` where nothing would change.
    fn draw(n: usize, max_edges: usize, rng: &mut impl Rng) -> Option<Self> {
        let deleted = draw_deletion(n, rng);
        let s = ((uniform(rng) * (n - deleted) as f64) as usize).min(n - deleted - 1);
        let mut edit = Self { s, t: n - deleted - s, deleted, added: 0 };
        edit.added = edit.draw_addition(max_edges, rng);
        (edit.deleted + edit.added > 0 && edit.addition_weight(max_edges) > 0.0).then_some(edit)
    }

    /// The edit that leads back.
    fn undo(&self) -> Self {
        Self { deleted: self.added, added: self.deleted, ..*self }
    }

    /// T(y→x | s, t) / T(x→y | s, t) of an edit that turns x = `current` into y = `proposal`.
    fn ratio(&self, current: &LightPath, proposal: &LightPath, within: &LightStratum) -> f64 {
        // A light end that was drawn afresh lies in the region; one in another region was hit by chance alone, and that is
        // the only way back, too: all densities that start on the region are zero.
        let same = within.same_region(&current.light, &proposal.light);
        let region = within.region_at(&current.light);
        let power = if same { region.power() } else { f64::INFINITY };
        let transition = |edit: &Self, from: &LightPath, to: &LightPath| {
            let ends = Ends { power, ..edit.ends(to, within, region) };
            edit.probability(from.vertices.len(), within.max_edges()) * edit.density(&to.vertices, ends)
        };
        self.kept_reference(current, proposal)
            * (transition(&self.undo(), proposal, current) / transition(self, current, proposal))
    }

    /// g(y)/g(x) over the vertices that are kept. On the camera's side it is 1 but where s = 0 and the first of them is x_0 in one
    /// path, where g does not count it, and a surface in the other.
    fn kept_reference(&self, x: &LightPath, y: &LightPath) -> f64 {
        let first = |path: &LightPath, replaced: usize| mis::reference(&path.vertices, self.s + replaced);
        mis::kept_reference(&x.vertices, &y.vertices, self.s) * (first(y, self.added) / first(x, self.deleted))
    }

    /// The ends that the new vertices of `path` start on. If x_0 is kept, it does not matter how it could be drawn.
    fn ends(&self, path: &LightPath, within: &LightStratum, region: &LightRegion) -> Ends {
        let area = within.image_area();
        match (self.s, self.added) {
            (0, 1..) => Ends::new(path, within.view(), region, area),
            _ => Ends { power: region.power(), preference: 1.0, area },
        }
    }

    /// P(d | n) / (n − d) · P(a | d).
    fn probability(&self, n: usize, max_edges: usize) -> f64 {
        let additions: f64 = self.additions(max_edges).iter().sum();
        deletion_weight(self.deleted) * self.addition_weight(max_edges)
            / (deletion_weights(n) * (n - self.deleted) as f64 * additions)
    }

    /// P(a | d) without its normalisation for a = d − 2 … d + 2.
    fn additions(&self, max_edges: usize) -> [f64; 2 * CHANGE.len() - 1] {
        array::from_fn(|i| match (self.deleted + i).checked_sub(CHANGE.len() - 1) {
            Some(added) => Self { added, ..*self }.addition_weight(max_edges),
            None => 0.0,
        })
    }

    /// Draws a with probability P(a | d); any where all are zero.
    fn draw_addition(&self, max_edges: usize, rng: &mut impl Rng) -> usize {
        let weights = self.additions(max_edges);
        let mut remaining = uniform(rng) * weights.iter().sum::<f64>();
        let drawn = weights.iter().position(|&weight| {
            remaining -= weight;
            remaining < 0.0
        });
        (self.deleted + drawn.unwrap_or(0)).saturating_sub(CHANGE.len() - 1)
    }

    /// P(a | d) without its normalisation: 0 for a path of less than an edge or of too many, and for no change at all.
    fn addition_weight(&self, max_edges: usize) -> f64 {
        let n = self.s + self.added + self.t;
        let possible = n >= 2 && n <= max_edges + 1 && self.added + self.deleted > 0;
        let change = self.added.abs_diff(self.deleted);
        if possible { CHANGE.get(change).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// P(a′ | a) without its normalisation.
    fn split_weight(&self, split: usize) -> f64 {
        let hits_light = self.s + split == 0;
        let connects_camera = self.t == 1 && split == self.added;
        if hits_light || connects_camera { CHANCE } else { 1.0 }
    }

    /// Σ_{a′} of these weights; all but the first and the last are 1.
    fn split_weights(&self) -> f64 {
        match self.added {
            0 => self.split_weight(0),
            a => self.split_weight(0) + (a - 1) as f64 + self.split_weight(a),
        }
    }

    /// Draws a′ with probability P(a′ | a).
    fn draw_split(&self, rng: &mut impl Rng) -> usize {
        let beyond = uniform(rng) * self.split_weights() - self.split_weight(0);
        if beyond < 0.0 { 0 } else { (1 + beyond as usize).min(self.added) }
    }

    /// Σ_{a′} P(a′ | a) Π forward/g Π reverse/g over the new vertices of `path`.
    fn density(&self, path: &[PathVertex], ends: Ends) -> f64 {
        // `sum`: over the splits so far, with the vertices so far; the later ones are still to be drawn from the camera.
        let technique = |split: usize| match mis::connectible(path, self.s + split) {
            true => self.split_weight(split) * ends.preference(self.s + split),
            false => 0.0,
        };
        let (mut sum, mut forward) = (technique(0), 1.0);
        for split in 0..self.added {
            let i = self.s + split;
            let reference = mis::reference(path, i);
            forward *= ends.forward(path, i) / reference;
            sum = sum * (ends.reverse(path, i) / reference) + forward * technique(split + 1);
        }
        sum / self.split_weights()
    }

    /// Copies what is kept to its new place, with room between.
    fn copy_kept(&self, from: &LightPath, to: &mut LightPath) {
        to.light = from.light;
        (to.film, to.pixel, to.pixels) = (from.film, from.pixel, from.pixels);
        let (near, far) = (&from.vertices[..self.s], &from.vertices[self.s + self.deleted..]);
        to.vertices.resize(self.s + self.added + self.t, from.vertices[0]);
        copy_vertices(&mut to.vertices[..self.s], near);
        copy_vertices(&mut to.vertices[self.s + self.added..], far);
    }
}

/// P(d) without its normalisation.
fn deletion_weight(d: usize) -> f64 {
    if d == 0 { NONE_DELETED } else { power_of_half(d) }
}

/// Σ_{d < n} of these weights.
fn deletion_weights(n: usize) -> f64 {
    NONE_DELETED + 1.0 - power_of_half(n - 1)
}

/// Draws d < `n` with probability P(d).
fn draw_deletion(n: usize, rng: &mut impl Rng) -> usize {
    // Beyond the first weight lie those of d = 1, 2 … up to ½, ¾ …: d is how often 1 − x can be doubled below 1.
    let x = uniform(rng) * deletion_weights(n) - NONE_DELETED;
    let doublings = 1023 - ((1.0 - x).to_bits() >> 52) as usize;
    if x < 0.0 { 0 } else { doublings.clamp(1, n - 1) }
}

/// 2^−i
fn power_of_half(i: usize) -> f64 {
    f64::from_bits(1023u64.saturating_sub(i as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Generator, Purpose, Stratum, generator};
    use crate::transport::colour::Rgb;
    use crate::transport::lights::{LightStrata, Stratification};
    use crate::transport::tests::balance::{Imbalance, imbalance, imbalance_in_tiles, imbalance_of_mutation_only};
    use crate::transport::tests::paths::{check_recomputed, long_path};
    use crate::transport::tests::worlds::{
        World, blurred, glass, glossy, glowing, lambert, lamps, lamps_and_sky, mirror, outdoors, parallel, room,
        two_lights, worlds,
    };

    /// The steps of [`BidirectionalMutation::propose`], with a ratio of the caller's.
    fn propose_with(
        world: &World,
        [current, proposal]: [&mut LightPath; 2],
        within: &LightStratum,
        rng: &mut Generator,
        ratio: impl Fn(&Edit, usize, &LightPath, &LightPath) -> f64,
    ) -> Option<f64> {
        let edit = Edit::draw(current.vertices.len(), within.max_edges(), rng)?;
        let split = edit.draw_split(rng);
        edit.copy_kept(current, proposal);
        BidirectionalMutation { view: world.view() }.trace(proposal, &edit, split, (within, within.region()), rng)?;
        Some(ratio(&edit, split, current, proposal))
    }

    #[test]
    fn the_way_back_has_the_inverse_ratio() {
        for (name, world) in worlds() {
            let strata = LightStrata::new(world.scene.lights(), Stratification::Grid(2, 1));
            let mut compared = 0;
            for (j, stratum) in (0..).zip(LightStratum::all(&strata, world.view(), 8)) {
                for i in 0..300 {
                    let mut rng = generator(1, Purpose::Chain, 0, j, i);
                    let mut current = LightPath::default();
                    stratum.sample(&mut rng, &mut |path, _| current.clone_from(path));
                    if current.vertices.is_empty() {
                        continue;
                    }
                    let mut proposal = LightPath::default();
                    for _ in 0..20 {
                        let paths = [&mut current, &mut proposal];
                        let ratios = propose_with(&world, paths, &stratum, &mut rng, |edit, _, x, y| {
                            let (there, back) = (edit.ratio(x, y, &stratum), edit.undo().ratio(y, x, &stratum));
                            // A path with a connection that nothing can make is not led back to.
                            assert!(there == 0.0 && back.is_infinite() || (there * back - 1.0).abs() < 1e-9, "{name}");
                            there
                        });
                        if ratios.is_some() {
                            check_recomputed(name, &proposal, &world);
                            compared += 1;
                        }
                    }
                }
            }
            assert!(compared > 1000, "{name}: {compared}");
        }
    }

    #[test]
    fn long_paths_have_finite_ratios() {
        let world = room(mirror(), true);
        let strata = LightStrata::new(world.scene.lights(), Stratification::None);
        let within = &LightStratum::all(&strata, world.view(), 1000)[0];
        for (exponent, (s, deleted, added)) in
            [-9.0, 9.0].into_iter().flat_map(|e| [(0, 200, 201), (90, 2, 3), (5, 190, 191)].map(|edit| (e, edit)))
        {
            let edit = Edit { s, t: 201 - s - deleted, deleted, added };
            let x = long_path(200, exponent, 1);
            let mut y = long_path(201, exponent, 2);
            // What is kept is the same; all but the densities next to what changes.
            y.vertices[..s].copy_from_slice(&x.vertices[..s]);
            y.vertices[s.saturating_sub(2)..s].iter_mut().for_each(|v| v.reverse *= 1.3);
            let (there, back) = (edit.ratio(&x, &y, within), edit.undo().ratio(&y, &x, within));
            assert!(there.is_normal() && back.is_normal(), "10^{exponent}: {there}, {back}");
            assert!((there * back - 1.0).abs() < 1e-9, "10^{exponent}: {there}, {back}");
        }
    }

    #[test]
    fn flows_are_balanced() {
        for (name, world) in [
            ("mirror", room(mirror(), true)),
            ("coated", room(glossy(), true)),
            ("two lights", two_lights(glass(0.0), mirror())),
            ("frosted glass", room(glass(0.4), false)),
            ("glowing ball", glowing()),
            ("sky", outdoors(glass(0.0))),
            ("lamps and sky", lamps_and_sky()),
            ("thin lens", blurred()),
            ("orthographic camera", parallel()),
        ] {
            let mutation = BidirectionalMutation { view: world.view() };
            for (cut, batches) in [(Stratification::None, 40_000), (Stratification::Grid(2, 1), 10_000)] {
                let found = imbalance(&world, cut, batches, |x, y, within, rng| mutation.propose(x, y, within, rng));
                println!("{name}, {cut:?}: z = {:.2}", found.z);
                found.assert_balanced(name);
            }
        }
    }

    /// The control for a surface that emits and reflects: without its factor in g where it is kept.
    #[test]
    fn a_kept_light_that_is_forgotten_is_seen() {
        let world = glowing();
        let found = imbalance(&world, Stratification::None, 40_000, |x, y, within, rng| {
            let paths = [&mut x.clone(), y];
            propose_with(&world, paths, within, rng, |edit, _, x, y| {
                let forgetful = mis::kept_reference(&x.vertices, &y.vertices, edit.s);
                edit.ratio(x, y, within) * forgetful / edit.kept_reference(x, y)
            })
        });
        found.assert_detected("without the light's factor");
    }

    #[test]
    fn flows_are_balanced_where_lights_are_drawn_for_a_vertex() {
        let world = &lamps();
        let mutation = BidirectionalMutation { view: world.view() };
        let propose = |x: &LightPath, y: &mut LightPath, within: &LightStratum, rng: &mut Generator| {
            mutation.propose(x, y, within, rng)
        };
        for (cut, batches) in [(Stratification::None, 20_000), (Stratification::Count(3), 10_000)] {
            imbalance(world, cut, batches, propose).assert_balanced(&format!("{cut:?}"));
        }
        let cut = Stratification::Count(3);
        imbalance_of_mutation_only(world, cut, 20_000, propose).assert_balanced("mutation only");
    }

    /// The ratio if x_0 were drawn with a preference of the caller's.
    fn ratio_with(
        preference: impl Fn(&LightPath) -> f64,
        edit: &Edit,
        [x, y]: [&LightPath; 2],
        within: &LightStratum,
    ) -> f64 {
        let wrong = |edit: &Edit, path: &LightPath| {
            let ends = edit.ends(path, within, within.region());
            let drawn = edit.s == 0 && edit.added > 0;
            let wrong = Ends { preference: if drawn { preference(path) } else { 1.0 }, ..ends };
            edit.density(&path.vertices, wrong) / edit.density(&path.vertices, ends)
        };
        match edit.ratio(x, y, within) {
            0.0 => 0.0,
            ratio => ratio * wrong(&edit.undo(), x) / wrong(edit, y),
        }
    }

    #[test]
    fn a_wrong_density_of_a_light_drawn_for_a_vertex_is_seen() {
        let world = &lamps();
        let whole = &LightRegion::whole(world.scene.lights());
        let found = |cut, preference: &(dyn Fn(&LightPath, &LightStratum) -> f64 + Sync)| {
            imbalance(world, cut, 20_000, |x, y, within, rng| {
                let paths = [&mut x.clone(), y];
                propose_with(world, paths, within, rng, |edit, _, x, y| {
                    ratio_with(|path| preference(path, within), edit, [x, y], within)
                })
            })
        };
        let right = |path: &LightPath, within: &LightStratum| Ends::new(path, within.view(), within.region(), 1.0);
        let cut = Stratification::Count(3);
        found(cut, &|path, within| right(path, within).preference).assert_balanced("none");
        found(Stratification::None, &|_, _| 1.0).assert_detected("by power");
        found(cut, &|path, within| {
            let of_all = Ends::new(path, within.view(), whole, 1.0);
            of_all.preference * within.region().power() / of_all.power
        })
        .assert_detected("a density over all lights instead of over the stratum's");
    }

    fn with_ratio(ratio: impl Fn(&Edit, usize, &LightPath, &LightPath, &LightStratum) -> f64 + Sync) -> Imbalance {
        let world = two_lights(lambert(Rgb::splat(0.6)), mirror());
        imbalance(&world, Stratification::None, 80_000, |x, y, within, rng| {
            let paths = [&mut x.clone(), y];
            propose_with(&world, paths, within, rng, |edit, split, x, y| ratio(edit, split, x, y, within))
        })
    }

    /// How far the counts of 200,000 draws are from what `weight` says, in standard deviations, at the most.
    fn deviation(n: usize, weight: impl Fn(usize) -> f64, draw: impl Fn(&mut Generator) -> usize) -> f64 {
        let (mut rng, mut counts) = (generator(2, Purpose::Chain, 0, 0, n as u64), vec![0.0; n]);
        (0..200_000).for_each(|_| counts[draw(&mut rng)] += 1.0);
        let total: f64 = (0..n).map(&weight).sum();
        let deviation = |i: usize| {
            let p = weight(i) / total;
            (counts[i] - 2e5 * p).abs() / (2e5 * p * (1.0 - p)).sqrt().max(1.0)
        };
        (0..n).map(deviation).fold(0.0, f64::max)
    }

    #[test]
    fn edits_are_drawn_as_their_weights_say() {
        for n in 2..9 {
            let total: f64 = (0..n).map(deletion_weight).sum();
            assert!((deletion_weights(n) - total).abs() < 1e-12, "{n}");
            assert!(deviation(n, deletion_weight, |rng| draw_deletion(n, rng)) < 4.5, "{n}");
        }
        assert!(
            deviation(4, |d| deletion_weight(d) * if d == 2 { 1.1 } else { 1.0 }, |rng| draw_deletion(4, rng)) > 4.5
        );
        for (s, t, deleted, added) in [(0, 1, 2, 3), (2, 1, 0, 2), (0, 3, 1, 1), (1, 1, 3, 0), (3, 2, 4, 5)] {
            let edit = Edit { s, t, deleted, added };
            let total: f64 = (0..=added).map(|split| edit.split_weight(split)).sum();
            assert_eq!(edit.split_weights(), total);
            assert!(deviation(added + 1, |split| edit.split_weight(split), |rng| edit.draw_split(rng)) < 4.5);
            let weight = |added| Edit { added, ..edit }.addition_weight(6);
            assert!(deviation(deleted + CHANGE.len(), weight, |rng| edit.draw_addition(6, rng)) < 4.5);
        }
    }

    #[test]
    fn errors_in_the_ratio_are_seen() {
        let found = with_ratio(|edit, _, x, y, within| edit.ratio(x, y, within));
        found.assert_balanced("none");
        let found = with_ratio(|edit, _, x, y, within| {
            let density =
                |edit: &Edit, path: &LightPath| edit.density(&path.vertices, edit.ends(path, within, within.region()));
            density(&edit.undo(), x) / density(edit, y)
        });
        println!("z = {:.2}", found.z);
        found.assert_detected("without the probability of the edit");
        let found = with_ratio(|edit, _, x, y, within| {
            edit.ratio(x, y, within) * (edit.added + 1) as f64 / (edit.deleted + 1) as f64
        });
        println!("z = {:.2}", found.z);
        found.assert_detected("with the wrong weight of a split");
        let found = with_ratio(|edit, split, x, y, within| {
            let ends = edit.ends(y, within, within.region());
            let drawn = |i: usize| match i < edit.s + split {
                true => ends.forward(&y.vertices, i),
                false => ends.reverse(&y.vertices, i),
            };
            let made: f64 = (edit.s..edit.s + edit.added).map(|i| drawn(i) / mis::reference(&y.vertices, i)).product();
            let all: f64 = (0..=edit.added).map(|split| edit.split_weight(split)).sum();
            let one = edit.split_weight(split) / all * made * ends.preference(edit.s + split);
            edit.ratio(x, y, within) * edit.density(&y.vertices, ends) / one
        });
        println!("z = {:.2}", found.z);
        found.assert_detected("counting only the split that was drawn");
        let found = with_ratio(|edit, _, x, y, within| {
            edit.ratio(x, y, within) * 1.1f64.powi(edit.added as i32 - edit.deleted as i32)
        });
        println!("z = {:.2}", found.z);
        found.assert_detected("a tenth too much for a vertex");
    }

    #[test]
    fn the_cameras_end_is_drawn_within_a_tile() {
        let world = room(mirror(), true);
        let mutation = BidirectionalMutation { view: world.view() };
        let found = imbalance_in_tiles(&world, 10_000, |x, y, within, rng| mutation.propose(x, y, within, rng));
        println!("z = {:.2}", found.z);
        found.assert_balanced("tiles");
        let found = imbalance_in_tiles(&world, 10_000, |x, y, within, rng| {
            let paths = [&mut x.clone(), y];
            propose_with(&world, paths, within, rng, |edit, _, x, y| {
                let wrong = |edit: &Edit, to: &LightPath| {
                    let ends = edit.ends(to, within, within.region());
                    edit.density(&to.vertices, Ends { area: 1.0, ..ends }) / edit.density(&to.vertices, ends)
                };
                edit.ratio(x, y, within) * wrong(&edit.undo(), x) / wrong(edit, y)
            })
        });
        println!("z = {:.2}", found.z);
        found.assert_detected("with the density of the whole image");
    }
}
