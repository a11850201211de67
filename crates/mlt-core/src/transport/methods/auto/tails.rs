//! Tails: light that independent samples have not met yet, told by chains.

use super::constants::{CHAIN_PILOT, CHAINS, MUTATIONS_PER_SAMPLE, NEW};
use super::per_method::PerMethod;
use crate::engine::{Chain, Importance, Mixture, Purpose, Sink, Stratum, Watch, generator, uniform};
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightRegion;
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::metropolis::LightStratum;
use crate::transport::methods::metropolis::PathMutation;
use crate::transport::paths::mis::Ends;
use crate::transport::paths::{LightPath, mis};
use crate::transport::scene::{View, rays_traced};
use rayon::prelude::*;

/// Second moments of the events that an independent method has not met.
///
/// A sample that makes path x by technique s, with density p_s and weight w_s, has the value v_s = w_s f/p_s there. With
/// u_p, the weight of pixel p's squared error, and V, a value that samples reached in several pixels, what is missing of the error is
///
/// Σ_s ∫_{v_s > V} u v_s² p_s dμ = b E_{x ~ I/b}[ u Σ_{s: v_s > V} v_s² p_s / I ].
///
/// Roulette, which makes values larger and rarer, is left out, so the truth may be larger still.
///
/// The share of a part's light that comes in such values is Σ_s ∫_{v_s > V} w_s I dμ / b = E_{x ~ I/b}[ Σ_{s: v_s > V} w_s ].
pub(super) struct Tails<'a> {
    pub(super) view: View<'a>,
    pub(super) importance: &'a PixelImportance,
    /// All lights.
    pub(super) lights: &'a LightRegion,
    pub(super) seed: u64,
    /// u, pixel by pixel.
    pub(super) weights: &'a [f64],
    pub(super) watch: Watch<'a>,
}

/// Light of a part that a method has not met.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tail {
    /// Second moment.
    pub(super) moment: f64,
    /// Share of the light that chains found.
    pub(super) light: f64,
}

impl Tail {
    /// With another one, so many times.
    fn plus(self, factor: f64, other: Self) -> Self {
        Self { moment: self.moment + factor * other.moment, light: self.light + factor * other.light }
    }
}

/// Tails by one chain.
#[derive(Clone, Copy, Default)]
struct OfChain {
    /// b of the part, from the samples that it started from.
    b: f64,
    /// In the mean over its states.
    tails: PerMethod<Tail>,
}

/// A sink that forgets.
struct Nothing;

impl<S> Sink<S> for Nothing {
    fn deposit(&mut self, _: S, _: f64) {}
}

impl Tails<'_> {
    /// Those of path tracing and of bidirectional path tracing in each part, `largest` being V of both, from `mutations`
    /// of each part's chains; and what that took. Nothing if it is stopped.
    pub(super) fn measure(
        &self,
        parts: &[LightStratum],
        largest: &[PerMethod<f64>],
        mutations: u64,
    ) -> Option<(Vec<PerMethod<Tail>>, PilotCounts)> {
        let chains: Vec<_> = (0..parts.len() as u64 * CHAINS).collect();
        let pieces = self.watch.pieces(chains.len());
        let of_chain = |&i: &u64| {
            let part = (i / CHAINS) as usize;
            pieces.unless_stopped(|| {
                let before = rays_traced();
                (self.of_chain(&parts[part], largest[part], i, mutations / CHAINS), rays_traced() - before)
            })
        };
        let (found, rays): (Vec<OfChain>, Vec<u64>) =
            chains.par_iter().map(of_chain).collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let spent = PilotCounts { mutations: chains.len() as u64 * (mutations / CHAINS), rays: rays.iter().sum() };
        let mean = |of: &[OfChain]| {
            let all: f64 = of.iter().map(|chain| chain.b).sum();
            let sums = of.iter().fold(PerMethod::<Tail>::default(), |sums, chain| {
                sums.zip(chain.tails).map(|(sum, tail)| sum.plus(chain.b, tail))
            });
            sums.map(|Tail { moment, light }| Tail {
                moment: moment / CHAINS as f64,
                light: if all > 0.0 { light / all } else { 0.0 },
            })
        };
        Some((found.chunks(CHAINS as usize).map(mean).collect(), spent))
    }

    /// From one chain, which starts at one of some independent samples, drawn in proportion to its importance weight.
    fn of_chain(&self, part: &LightStratum, largest: PerMethod<f64>, index: u64, mutations: u64) -> OfChain {
        let stream = |purpose| generator(self.seed, purpose, CHAIN_PILOT - 1, index, 0);
        let [mut rng, mut pick, mut steps] = [Purpose::Sample, Purpose::Start, Purpose::Chain].map(stream);
        let (samples, mut total, mut start) = (mutations.div_ceil(MUTATIONS_PER_SAMPLE), 0.0, LightPath::default());
        for _ in 0..samples {
            part.sample(&mut rng, &mut |path, weight| {
                let weight = weight * self.importance.eval(path);
                if weight > 0.0 && weight.is_finite() {
                    total += weight;
                    if uniform(&mut pick) * total < weight {
                        start.clone_from(path);
                    }
                }
            });
        }
        if total <= 0.0 {
            return OfChain::default();
        }
        let mixture = Mixture::new(PathMutation::all(self.view));
        let Some(mut chain) = Chain::new(&mixture, self.importance, part, start) else { return OfChain::default() };
        let mut tails = PerMethod::<Tail>::default();
        for _ in 0..mutations {
            chain.step(&mut Nothing, 0.0, &mut steps);
            tails = tails.zip(self.unmet(chain.current(), largest)).map(|(tail, here)| Tail {
                moment: tail.moment + here.moment / mutations as f64,
                light: tail.light + here.light / mutations as f64,
            });
        }
        OfChain { b: total / samples as f64, tails }
    }

    /// u Σ_{s: v_s > V} v_s² p_s / I and Σ_{s: v_s > V} w_s of both methods.
    fn unmet(&self, path: &LightPath, largest: PerMethod<f64>) -> PerMethod<Tail> {
        let vertices = path.vertices();
        let ends = Ends::new(path, &self.view, self.lights, 1.0);
        let densities = mis::densities(vertices, ends);
        let contribution = path.contribution().element_sum();
        // Path tracing seldom draws points of the lights for the camera.
        let drawn = path.edges() > 1 || self.view.camera.has_tiny_lights();
        let of_path = densities.clone().take(1 + usize::from(drawn));
        let tails = PerMethod {
            path: beyond(of_path, contribution, largest.path),
            bidirectional: beyond(densities, contribution, largest.bidirectional),
        };
        let weight = self.weights[path.pixel as usize] / self.importance.eval(path);
        tails.map(|tail| Tail { moment: weight * tail.moment, ..tail })
    }
}

/// Σ_{s: v_s > V} v_s² p_s and Σ_{s: v_s > V} w_s, with w_s = p_s²/Σ_i p_i².
fn beyond(densities: impl Iterator<Item = f64> + Clone, contribution: f64, largest: f64) -> Tail {
    let squares: f64 = densities.clone().map(|p| p * p).sum();
    let value = |p: f64| p * contribution / squares;
    let rare = densities.filter(|&p| p > 0.0 && value(p) > NEW * largest);
    rare.fold(Tail::default(), |tail, p| Tail {
        moment: tail.moment + p * value(p).powi(2),
        light: tail.light + p * p / squares,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::uniform_f32;
    use crate::transport::lights::{Cell, LightStrata, Stratification};
    use crate::transport::methods::bidirectional::Bidirectional;
    use crate::transport::methods::independent::ImageSampler;
    use crate::transport::methods::path_tracing::PathTracer;
    use crate::transport::methods::sobol::OwenSobol;
    use crate::transport::tests::worlds::{World, pond, room, rough_metal};
    use glam::{DVec2, DVec3, Vec2};

    /// Longest path: short enough for no roulette.
    const MAX_EDGES: usize = 3;
    const LARGEST: f64 = 0.5;

    /// E[Σ v²] over values above `LARGEST`, and its standard error.
    fn sampled(sampler: &impl ImageSampler) -> [f64; 2] {
        let n = 400_000;
        let moment = |i: u64| {
            let rng = &mut OwenSobol::new(i);
            let (film, mut sum) = (Vec2::new(uniform_f32(rng), uniform_f32(rng)), 0.0);
            sampler.sample(film, rng, &mut |_, value: DVec3, _| {
                let value = value.element_sum();
                sum += if value > NEW * LARGEST { value * value } else { 0.0 };
            });
            sum
        };
        let (sum, squares) = (0..n).map(moment).fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let mean = sum / n as f64;
        [mean, ((squares / n as f64 - mean * mean) / n as f64).sqrt()]
    }

    /// By chains, and the standard error.
    fn by_chains(world: &World, region: &LightRegion) -> [[f64; 2]; 2] {
        let view = world.view();
        let weights = &vec![1.0; view.camera.pixels() as usize];
        let lights = LightStrata::new(view.scene.lights(), Stratification::None);
        let strata = LightStratum::all(&lights, view, MAX_EDGES);
        let of = |seed| {
            let (importance, watch) = (&PixelImportance::default(), Watch::NEVER);
            let tails = Tails { view, importance, lights: region, seed, weights, watch };
            let largest = [PerMethod { path: LARGEST, bidirectional: LARGEST }];
            let (found, _) = tails.measure(&strata, &largest, 50_000).expect("nothing stops it");
            let PerMethod { path, bidirectional } = found[0];
            [path.moment, bidirectional.moment]
        };
        const SEEDS: u64 = 36;
        let found: Vec<_> = (0..SEEDS).map(of).collect();
        [0, 1].map(|m| {
            let n = SEEDS as f64;
            let mean = found.iter().map(|x| x[m]).sum::<f64>() / n;
            let variance = found.iter().map(|x| (x[m] - mean).powi(2)).sum::<f64>() / (n - 1.0);
            [mean, (variance / n).sqrt()]
        })
    }

    #[test]
    fn chains_tell_the_second_moments_of_independent_samples() {
        // In the second one, most paths can be made by one technique alone.
        for (world, several) in [(room(rough_metal(), false), true), (pond(), false)] {
            let view = world.view();
            let lights = view.scene.lights();
            let region = &LightRegion::whole(lights);
            let (max_edges, max_image_edges) = (MAX_EDGES, MAX_EDGES);
            let path =
                PathTracer { view, light_sampler: region.light_sampler(), max_edges, max_image_edges, branches: 1 };
            let exact = [sampled(&path), sampled(&Bidirectional { view, region, max_edges })];
            let z = |found: [[f64; 2]; 2]| [0, 1].map(|m| (found[m][0] - exact[m][0]) / found[m][1].hypot(exact[m][1]));
            let found = by_chains(&world, region);
            assert!(z(found).iter().all(|z| z.abs() < 4.0), "{found:?} {exact:?}");
            // The negative control: densities of a part of the light.
            let part = Cell { high: DVec2::new(0.7, 1.0), ..Cell::whole(0) };
            let wrong = by_chains(&world, &LightRegion::new(lights, vec![part]));
            assert!(!several || z(wrong)[1].abs() > 4.0, "{wrong:?} {exact:?}");
        }
    }
}
