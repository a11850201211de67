//! The noise that path tracing would leave without chains, told by chains.

use super::constants::CHAIN_PILOT;
use super::split::Taken;
use crate::engine::{Chain, Importance, Mixture, Purpose, Sink, Stratum, Watch, generator, uniform};
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::metropolis::{LightStratum, PathMutation};
use crate::transport::paths::{LightPath, Luminance};
use crate::transport::scene::rays_traced;
use rayon::prelude::*;

/// Chains that tell it.
const CHAINS: u64 = 16;
/// Mutations for each independent sample.
const MUTATIONS_PER_SAMPLE: u64 = 8;

/// The second moment of what chains take from path tracing's samples,
///
/// T = ∫ w f u (1 − (1 − W)²) = b E_{x ~ I W/b}[ w u (2 − W) f/I ],
///
/// with w the weight of the pixel's squared error. Such values may come once in more samples than a pilot takes; chains go there on purpose.
pub(super) struct Tail<'a> {
    pub(super) taken: Taken<'a>,
    /// w, pixel by pixel.
    pub(super) weights: &'a [f64],
    pub(super) seed: u64,
}

/// A sink that forgets.
struct Nothing;

impl<S> Sink<S> for Nothing {
    fn deposit(&mut self, _: S, _: f64) {}
}

impl Tail<'_> {
    /// T from so many mutations in each stratum, and what that took. Nothing if it is stopped.
    pub(super) fn measure(&self, strata: &[LightStratum], mutations: u64, watch: Watch) -> Option<(f64, PilotCounts)> {
        let chains: Vec<_> = (0..strata.len() as u64 * CHAINS).collect();
        let (pieces, mutations) = (watch.pieces(chains.len()), mutations / CHAINS);
        let of_chain = |&i: &u64| {
            let stratum = &strata[(i / CHAINS) as usize];
            pieces.unless_stopped(|| {
                let before = rays_traced();
                (self.of_chain(stratum, i, mutations), rays_traced() - before)
            })
        };
        let (found, rays): (Vec<f64>, Vec<u64>) =
            chains.par_iter().map(of_chain).collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let spent = PilotCounts { mutations: chains.len() as u64 * mutations, rays: rays.iter().sum() };
        Some((found.iter().sum::<f64>() / CHAINS as f64, spent))
    }

    /// From one chain, which starts at one of some independent samples, drawn in proportion to its importance weight.
    fn of_chain(&self, stratum: &LightStratum, index: u64, mutations: u64) -> f64 {
        let stream = |purpose| generator(self.seed, purpose, CHAIN_PILOT - 1, index, 0);
        let [mut rng, mut pick, mut steps] = [Purpose::Sample, Purpose::Start, Purpose::Chain].map(stream);
        let (samples, mut total, mut start) = (mutations.div_ceil(MUTATIONS_PER_SAMPLE), 0.0, LightPath::default());
        for _ in 0..samples {
            stratum.sample(&mut rng, &mut |path, weight| {
                let weight = weight * self.taken.eval(path);
                if weight > 0.0 && weight.is_finite() {
                    total += weight;
                    if uniform(&mut pick) * total < weight {
                        start.clone_from(path);
                    }
                }
            });
        }
        let mixture = Mixture::new(PathMutation::all(self.taken.view));
        let chain = (total > 0.0).then(|| Chain::new(&mixture, &self.taken, stratum, start)).flatten();
        let Some(mut chain) = chain else { return 0.0 };
        let mut sum = 0.0;
        for _ in 0..mutations {
            chain.step(&mut Nothing, 0.0, &mut steps);
            sum += self.of_path(chain.current());
        }
        total / samples as f64 * sum / mutations as f64
    }

    /// w u (2 − W) f/I, u and f as sums over channels.
    fn of_path(&self, path: &LightPath) -> f64 {
        let Taken { importance, view, lights, split } = self.taken;
        let (value, colour) = (split.value(path, &view, lights), path.contribution().element_sum());
        let weight = self.weights[path.pixel as usize] * (2.0 - split.share(value, path.pixel));
        weight * value * colour * colour / (Luminance.eval(path) * importance.eval(path))
    }
}
