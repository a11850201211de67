//! Paths that nothing but a camera subpath meets, which are sampled on their own.
//!
//! No two neighbours of such a path may be connected: at least one of them is specular. A camera subpath ends where that fails, mostly
//! at the first surface, so that a sample is hardly more than one ray. At vertices that are not specular it may be guided ([`Guide`]).

use super::guide::Guide;
use super::sampler::{Bidirectional, SCRATCH, Scratch};
use crate::engine::uniform_f32;
use crate::transport::paths::mis::connectible;
use crate::transport::paths::subpath::{follow_from_eye, start_at_eye, step_from_eye};
use crate::transport::paths::{LightPath, PathVertex, set_scattering};
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;

/// Draws camera subpaths that no connection could end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByChance<'a> {
    pub(crate) sampler: Bidirectional<'a>,
    pub(crate) guide: Option<&'a Guide>,
}

impl ByChance<'_> {
    /// Draws a camera subpath through a film point, and shows `visit` each path that ends on a light it meets, with its weight 1/p: see
    /// [`Bidirectional::sample_through`]. Weights are right for paths that no connection makes.
    pub(crate) fn sample(&self, film: Vec2, area: f64, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        SCRATCH.with_borrow_mut(|scratch| {
            let Bidirectional { view, max_edges, .. } = self.sampler;
            let camera = PathVertex::new(view.camera.sample_lens(rng));
            scratch.eye.reset(max_edges + 1, camera, 1.0);
            let last = scratch.eye.vertices.len() - 1;
            scratch.eye.vertices[last] = camera;
            scratch.path.cross(&view, film);
            let mut factor = 1.0;
            for i in (last - max_edges + 1..=last).rev() {
                let Some(quotient) = self.step(&mut scratch.eye.vertices, i, film, rng) else { return };
                factor *= quotient;
                if !extend(scratch, i, quotient, rng) {
                    return;
                }
                let t = scratch.eye.len();
                if let Some(weight) = self.sampler.connect(scratch, [0, t], area) {
                    visit(&scratch.path, weight * factor / scratch.eye.carried(t).survival);
                }
            }
        });
    }

    /// Draws x_{i−1}, unless x_i and x_{i+1} may be connected; returns the density by the BSDF over the one that it has.
    fn step(&self, vertices: &mut [PathVertex], i: usize, film: Vec2, rng: &mut impl Rng) -> Option<f64> {
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
        let guide = self.guide.filter(|_| !x.delta && uniform_f32(rng) < 0.5);
        match guide.and_then(|guide| guide.sample(x, rng)) {
            Some(direction) => follow_from_eye(vertices, i, direction, view, rng)?,
            None => step_from_eye(vertices, i, view, rng)?,
        }
        set_scattering(vertices, i, view)?;
        Some(self.quotient(vertices, i))
    }

    /// The density of x_{i−1}, drawn from x_i by the BSDF, over that of (G1).
    fn quotient(&self, vertices: &[PathVertex], i: usize) -> f64 {
        let (x, to_light) = (&vertices[i].vertex, &vertices[i - 1]);
        let guide = self.guide.filter(|_| !x.delta);
        let guided = guide.and_then(|guide| guide.density(x, -to_light.to_eye));
        guided.map_or(1.0, |density| 2.0 / (1.0 + to_light.per_area_here(density) / to_light.reverse))
    }

    /// The density of a path over that of a camera subpath without a guide.
    pub(crate) fn relative_density(&self, path: &LightPath) -> f64 {
        let vertices = path.vertices();
        (1..vertices.len() - 1).map(|i| 1.0 / self.quotient(vertices, i)).product()
    }
}

/// Takes in x_{i−1}, whose density is that by the BSDF over `quotient`, unless roulette ends the subpath.
fn extend(scratch: &mut Scratch, i: usize, quotient: f64, rng: &mut impl Rng) -> bool {
    let [x, y] = [&scratch.eye.vertices[i], &scratch.eye.vertices[i - 1]];
    let factor: DVec3 = x.scatter.as_dvec3() * (y.geometric_term / y.reverse * quotient);
    scratch.eye.extend(factor, 0.0, 1.0, rng)
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
    use crate::transport::tests::worlds::{glass, lambert, mirror, room, two_lights};

    /// Light of paths with a vertex that is not specular, with the weights of samples, and with these times the relative density, as if
    /// nothing knew of the guide, but no more than four times, so that noise does not hide it: means and their variances.
    fn moments(by_chance: ByChance, samples: u64) -> [[f64; 2]; 2] {
        let mut sums = [[0.0; 2]; 2];
        for i in 0..samples {
            let (rng, mut found) = (&mut generator(3, Purpose::Sample, 0, 0, i), [0.0; 2]);
            let film = Vec2::new(uniform_f32(rng), uniform_f32(rng));
            by_chance.sample(film, 1.0, rng, &mut |path, weight| {
                let x = path.vertices();
                if met_by_chance(x) && x[1..x.len() - 1].iter().any(|x| !x.vertex.delta) {
                    let value = weight * Luminance.eval(path);
                    found = [found[0] + value, found[1] + value * by_chance.relative_density(path).min(4.0)];
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

    /// A guide finds the same light with less noise. The negative control leaves its density out.
    #[test]
    fn guided_subpaths_find_the_same_light() {
        let worlds = [room(mirror(), true), room(glass(0.0), true), two_lights(lambert(Rgb::splat(0.5)), glass(0.0))];
        let (mut gain, mut wrong) = (0.0_f64, 0.0_f64);
        for world in worlds {
            let (view, region) = (world.view(), &LightRegion::whole(world.scene.lights()));
            let (guide, rays) = Guide::new(&view, &Settings::new(Method::Auto, 16.0), region);
            assert!(rays > 1024);
            let sampler = Bidirectional { view, region, max_edges: 8 };
            let [free, _] = moments(ByChance { sampler, guide: None }, 1_000_000);
            let [guided, control] = moments(ByChance { sampler, guide: Some(&guide) }, 1_000_000);
            assert!(free[0] > 0.0 && z(free, guided).abs() < 4.0, "{free:?} {guided:?}");
            wrong = wrong.max(z(free, control).abs());
            gain = gain.max(free[1] / guided[1]);
        }
        assert!(gain > 2.0 && wrong > 5.0, "{gain} {wrong}");
    }
}
