//! Paths that nothing but a camera subpath meets, which are sampled on their own.
//!
//! No two neighbours of such a path may be connected: at least one of them is specular. A camera subpath ends where that fails, mostly
//! at the first surface, so that a sample is hardly more than one ray. A [`Guide`] knows where such light is seen, and at vertices that are not
//! specular where it comes from.

use super::guide::{Events, Glimpses, Guide};
use super::sampler::{Bidirectional, SCRATCH, Scratch};
use crate::engine::uniform_f32;
use crate::transport::paths::mis::connectible;
use crate::transport::paths::subpath::{follow_from_eye, start_at_eye, step_from_eye};
use crate::transport::paths::{LightPath, PathVertex, set_scattering};
use crate::transport::scene::Resolved;
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;

/// Share of camera subpaths that begin in a glimpse.
const GLIMPSED: f32 = 0.25;

/// Draws camera subpaths that no connection could end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByChance<'a> {
    pub(crate) sampler: Bidirectional<'a>,
    pub(crate) guide: Option<&'a Guide>,
}

impl ByChance<'_> {
    /// Draws a camera subpath through a film point, or through one of a glimpse, and shows `visit` each path that ends on a light it meets, with
    /// its weight 1/p: see [`Bidirectional::sample_through`]. Weights are right for paths that no connection makes.
    pub(crate) fn sample(&self, film: Vec2, area: f64, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        match self.glimpses().filter(|_| uniform_f32(rng) < GLIMPSED) {
            None => self.sample_through(film, None, area, rng, visit),
            Some(glimpses) => {
                if let Some((film, events)) = glimpses.sample(rng) {
                    self.sample_through(film, Some(events), area, rng, visit);
                }
            }
        }
    }

    fn glimpses(&self) -> Option<&Glimpses> {
        self.guide.map(|guide| &guide.glimpses).filter(|glimpses| !glimpses.is_empty())
    }

    /// Draws a camera subpath that begins with given events, or with any.
    fn sample_through(
        &self,
        film: Vec2,
        events: Option<Events>,
        area: f64,
        rng: &mut impl Rng,
        visit: &mut impl FnMut(&LightPath, f64),
    ) {
        SCRATCH.with_borrow_mut(|scratch| {
            let Bidirectional { view, max_edges, .. } = self.sampler;
            let camera = PathVertex::new(view.camera.sample_lens(rng));
            scratch.eye.reset(max_edges + 1, camera, 1.0);
            let last = scratch.eye.vertices.len() - 1;
            scratch.eye.vertices[last] = camera;
            scratch.path.cross(&view, film);
            let mut factor = 1.0;
            for i in (last - max_edges + 1..=last).rev() {
                let Some(quotient) = self.step(&mut scratch.eye.vertices, i, (film, events), rng) else { return };
                factor *= quotient;
                if !extend(scratch, i, [quotient, factor], rng) {
                    return;
                }
                let t = scratch.eye.len();
                if events.is_some_and(|events| t < events.len() + 2) {
                    continue;
                }
                if let Some(weight) = self.sampler.connect(scratch, [0, t], area) {
                    let factor = factor / self.of_glimpses(&scratch.path, area);
                    visit(&scratch.path, weight * factor / scratch.eye.carried(t).survival);
                }
            }
        });
    }

    /// Draws x_{i−1}, unless x_i and x_{i+1} may be connected; returns the density by the BSDF over the one that it has.
    fn step(
        &self,
        vertices: &mut [PathVertex],
        i: usize,
        (film, events): (Vec2, Option<Events>),
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let view = &self.sampler.view;
        if i + 1 == vertices.len() {
            start_at_eye(vertices, i, film, view, rng)?;
            set_scattering(vertices, i, view)?;
            return Some(1.0);
        }
        if connectible(vertices, i + 1) {
            return None;
        }
        let x = &vertices[i].vertex;
        let number = vertices.len() - 2 - i;
        match events.filter(|events| number <= events.len()) {
            Some(events) if x.delta => {
                let mut room = Resolved::default();
                let surface = view.scene.surface(x, &mut room);
                let direction = surface.delta_direction(vertices[i].to_eye, events.get(number)?)?;
                follow_from_eye(vertices, i, direction, view, rng)?;
            }
            Some(events) if number < events.len() => return None,
            _ => self.step_anywhere(vertices, i, rng)?,
        }
        set_scattering(vertices, i, view)?;
        Some(self.quotient(vertices, i))
    }

    /// Draws x_{i−1} with the density (G1).
    fn step_anywhere(&self, vertices: &mut [PathVertex], i: usize, rng: &mut impl Rng) -> Option<()> {
        let (view, x) = (&self.sampler.view, &vertices[i].vertex);
        let guide = self.guide.filter(|_| !x.delta && uniform_f32(rng) < 0.5);
        match guide.and_then(|guide| guide.photons.sample(x, rng)) {
            Some(direction) => follow_from_eye(vertices, i, direction, view, rng),
            None => step_from_eye(vertices, i, view, rng),
        }
    }

    /// The density of x_{i−1}, drawn from x_i by the BSDF, over that of (G1).
    fn quotient(&self, vertices: &[PathVertex], i: usize) -> f64 {
        let (x, to_light) = (&vertices[i].vertex, &vertices[i - 1]);
        let guide = self.guide.filter(|_| !x.delta);
        let guided = guide.and_then(|guide| guide.photons.density(x, -to_light.to_eye));
        guided.map_or(1.0, |density| 2.0 / (1.0 + to_light.per_area_here(density) / to_light.reverse))
    }

    /// The density of a path over that of a camera subpath without a guide.
    pub(crate) fn relative_density(&self, path: &LightPath, area: f64) -> f64 {
        self.of_photons(path) * self.of_glimpses(path, area)
    }

    /// The same where film points are drawn without a guide.
    fn of_photons(&self, path: &LightPath) -> f64 {
        let vertices = path.vertices();
        (1..vertices.len() - 1).map(|i| 1.0 / self.quotient(vertices, i)).product()
    }

    /// The same where all else is drawn without one: (G2).
    fn of_glimpses(&self, path: &LightPath, area: f64) -> f64 {
        let (view, part) = (&self.sampler.view, f64::from(GLIMPSED));
        self.glimpses().map_or(1.0, |glimpses| 1.0 - part + part * area * glimpses.relative_density(path, view))
    }
}

/// Takes in x_{i−1}, unless roulette ends the subpath. `quotient` and `factor`: the densities of the vertex and of the whole subpath by BSDFs,
/// over those that they have. Roulette goes by the throughput without a guide: with one it is small where the guide is right.
fn extend(scratch: &mut Scratch, i: usize, [quotient, factor]: [f64; 2], rng: &mut impl Rng) -> bool {
    let [x, y] = [&scratch.eye.vertices[i], &scratch.eye.vertices[i - 1]];
    let change: DVec3 = x.scatter.as_dvec3() * (y.geometric_term / y.reverse * quotient);
    scratch.eye.extend(change, 0.0, factor, rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Importance, Purpose, generator};
    use crate::transport::colour::Rgb;
    use crate::transport::lights::LightRegion;
    use crate::transport::methods::settings::{Method, Settings};
    use crate::transport::paths::Luminance;
    use crate::transport::paths::mis::met_by_chance;
    use crate::transport::tests::worlds::{World, blurred, glass, lambert, mirror, parallel, room, two_lights};

    /// Light of paths through the part of the film between two corners, and of those of them with a vertex that is not specular; then the
    /// negative controls, the former with weights as if nothing knew of glimpses, the latter as if nothing knew of photons, but no more than
    /// four times as large, so that noise does not hide it. Means and their variances.
    fn moments(by_chance: ByChance, [low, high]: [Vec2; 2], samples: u64) -> [[f64; 2]; 4] {
        let (mut sums, area) = ([[0.0; 2]; 4], f64::from((high - low).element_product()));
        for i in 0..samples {
            let (rng, mut found) = (&mut generator(3, Purpose::Sample, 0, 0, i), [0.0; 4]);
            let film = low + (high - low) * Vec2::new(uniform_f32(rng), uniform_f32(rng));
            by_chance.sample(film, area, rng, &mut |path, weight| {
                let (x, inside) = (path.vertices(), path.film.cmpge(low).all() && path.film.cmplt(high).all());
                if inside && met_by_chance(x) {
                    let value = weight * Luminance.eval(path);
                    let rough = f64::from(u8::from(x[1..x.len() - 1].iter().any(|x| !x.vertex.delta)));
                    let [glimpses, photons] = [by_chance.of_glimpses(path, area), by_chance.of_photons(path)];
                    let factors = [1.0, rough, glimpses.min(4.0), rough * photons.min(4.0)];
                    found.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += value * factor);
                }
            });
            for (sum, value) in sums.iter_mut().zip(found) {
                *sum = [sum[0] + value, sum[1] + value * value];
            }
        }
        let n = samples as f64;
        sums.map(|[sum, squares]| [sum / n, (squares - sum * sum / n) / (n * n)])
    }

    fn z(a: [f64; 2], b: [f64; 2]) -> f64 {
        (a[0] - b[0]) / (a[1] + b[1]).sqrt()
    }

    /// Light that is found without a guide, and with one.
    fn found(world: &World, part: [Vec2; 2]) -> [[[f64; 2]; 4]; 2] {
        let (view, region) = (world.view(), &LightRegion::whole(world.scene.lights()));
        let (guide, rays) = Guide::new(&view, &Settings::new(Method::Auto, 16.0), region);
        assert!(rays > 1024);
        let sampler = Bidirectional { view, region, max_edges: 8 };
        [None, Some(&guide)].map(|guide| moments(ByChance { sampler, guide }, part, 500_000))
    }

    /// A guide finds the same light with less noise, in the whole image and in a part of it.
    #[test]
    fn guided_subpaths_find_the_same_light() {
        let glass_room = room(glass(0.0), true);
        let worlds = [room(mirror(), true), two_lights(lambert(Rgb::splat(0.5)), glass(0.0)), blurred(), parallel()];
        let (whole, lower) = ([Vec2::ZERO, Vec2::ONE], [Vec2::new(0.0, 0.5), Vec2::ONE]);
        let cases = worlds.iter().map(|world| (world, whole)).chain([(&glass_room, whole), (&glass_room, lower)]);
        let (mut wrong, mut gain) = ([0.0_f64; 2], 0.0_f64);
        for (number, (world, part)) in cases.enumerate() {
            let [free, guided] = found(world, part);
            assert!(free[0][0] > 0.0 && z(free[0], guided[0]).abs() < 4.0, "{number}: {free:?} {guided:?}");
            assert!(free[1][0] == 0.0 || z(free[1], guided[1]).abs() < 4.0, "{number}: {free:?} {guided:?}");
            let controls = [[0, 2], [1, 3]].map(|[right, control]| z(free[right], guided[control]).abs());
            wrong = [wrong[0].max(controls[0]), wrong[1].max(controls[1])];
            gain = gain.max(free[0][1] / guided[0][1]);
        }
        assert!(gain > 10.0 && wrong.into_iter().all(|z| z > 5.0), "{gain} {wrong:?}");
    }
}
