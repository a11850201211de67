//! The noise that chains tell of: what path tracing would leave without them, and what their own starts leave.

use super::constants::{CHAIN_PILOT, PILOT_MUTATIONS_PER_SAMPLE, TOLD_CHAINS};
use super::split::Taken;
use crate::engine::{
    CHAIN_LENGTH, Chain, Generator, Importance, Mixture, Purpose, Sink, Stratum, Watch, generator, uniform,
};
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::metropolis::{LightStratum, PathMutation};
use crate::transport::paths::{LightPath, Luminance};
use crate::transport::scene::rays_traced;
use rayon::prelude::*;

/// Findings of chains, each of them per sample a pixel.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// The second moment of what chains take from path tracing's samples,
    ///
    /// T = ∫ w f u (1 − (1 − W)²) = b E_{x ~ I W/b}[ w u (2 − W) f/I ],
    ///
    /// with w the weight of the pixel's squared error. Such values may come once in more samples than a pilot takes; chains go there on purpose.
    pub(super) tail: f64,
    /// Q = ∫ w² f u³ (1 − (1 − W)²), of the whole image: T is known as well as it would be from N T²/Q equal events, if N samples met them.
    pub(super) squares: f64,
    /// R_j = b_j E[ I W/p_j Σ_pixels w K² ], by strata: what chains leave of error by where they start. K is the sum of f/I over a
    /// chain's visits of a pixel, over the number of all its visits; p_j the density of the samples that it may start from.
    ///
    /// A start of weight I W/p has its share of the chains, and these show it as K.
    pub(super) starts: Vec<f64>,
}

/// The chains that tell it.
pub(super) struct Tail<'a> {
    pub(super) taken: Taken<'a>,
    /// w, pixel by pixel.
    pub(super) weights: &'a [f64],
    pub(super) seed: u64,
}

/// T, R and Q of a stratum, from those of its chains. R/T is that of all chains but the one with the largest T: where one of them is stuck
/// and no other has been, it says nothing about the rest.
fn of_stratum(found: &[[f64; 3]]) -> [f64; 3] {
    let largest = found.iter().copied().max_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or_default();
    let [tail, starts, squares] = [0, 1, 2].map(|i| found.iter().map(|of_chain| of_chain[i]).sum::<f64>());
    let others = [tail - largest[0], starts - largest[1]];
    let ratio = if others[0] > 0.0 { others[1] / others[0] } else { starts / tail.max(f64::MIN_POSITIVE) };
    [tail, tail * ratio, squares].map(|sum| sum / found.len() as f64)
}

/// A sink that forgets.
struct Nothing;

impl<S> Sink<S> for Nothing {
    fn deposit(&mut self, _: S, _: f64) {}
}

/// Chains of light's paths.
type PathChain<'a> = Chain<'a, LightPath, LightStratum<'a>, PathMutation<'a>, Taken<'a>>;

impl Tail<'_> {
    /// From so many mutations in each stratum, and what that took. Nothing if it is stopped.
    pub(super) fn measure(&self, strata: &[LightStratum], mutations: u64, watch: Watch) -> Option<(Told, PilotCounts)> {
        let chains: Vec<_> = (0..strata.len() as u64 * TOLD_CHAINS).collect();
        let (pieces, mutations) = (watch.pieces(chains.len()), mutations / TOLD_CHAINS);
        let of_chain = |&i: &u64| {
            let stratum = &strata[(i / TOLD_CHAINS) as usize];
            pieces.unless_stopped(|| {
                let before = rays_traced();
                (self.of_chain(stratum, i, mutations), rays_traced() - before)
            })
        };
        let (found, rays): (Vec<[f64; 3]>, Vec<u64>) =
            chains.par_iter().map(of_chain).collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let spent = PilotCounts { mutations: chains.len() as u64 * mutations, rays: rays.iter().sum() };
        let told: Vec<_> = found.chunks(TOLD_CHAINS as usize).map(of_stratum).collect();
        let sum = |i: usize| told.iter().map(|of_stratum| of_stratum[i]).sum();
        let starts = told.iter().map(|&[_, starts, _]| starts).collect();
        Some((Told { tail: sum(0), squares: sum(2), starts }, spent))
    }

    /// T, R and Q from one chain, which starts at one of some independent samples, drawn in proportion to its importance weight.
    fn of_chain(&self, stratum: &LightStratum, index: u64, mutations: u64) -> [f64; 3] {
        let stream = |purpose| generator(self.seed, purpose, CHAIN_PILOT - 1, index, 0);
        let [mut rng, mut pick, mut steps] = [Purpose::Sample, Purpose::Start, Purpose::Chain].map(stream);
        let (samples, mut total, mut start) =
            (mutations.div_ceil(PILOT_MUTATIONS_PER_SAMPLE), 0.0, LightPath::default());
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
        let (Some(mut chain), b) = (chain, total / samples as f64) else { return [0.0; 3] };
        let pieces = (0..mutations).step_by(CHAIN_LENGTH as usize);
        let found =
            pieces.map(|made| self.of_piece(&mut chain, stratum, CHAIN_LENGTH.min(mutations - made), &mut steps));
        let sums = found.fold([0.0; 3], |sums, found| [0, 1, 2].map(|i| sums[i] + found[i]));
        sums.map(|sum| b * sum / mutations as f64)
    }

    /// Sums over the visits of a piece of a chain, which is as long as the chains of a render.
    fn of_piece(&self, chain: &mut PathChain, stratum: &LightStratum, length: u64, rng: &mut Generator) -> [f64; 3] {
        let (mut tail, mut squares, mut weights, mut visits) = (0.0, 0.0, 0.0, Vec::new());
        for _ in 0..length {
            chain.step(&mut Nothing, 0.0, rng);
            let path = chain.current();
            let [of_tail, of_squares] = self.of_path(path);
            (tail, squares) = (tail + of_tail, squares + of_squares);
            weights += self.taken.eval(path) / stratum.density(path);
            visits.push((path.pixel, path.contribution().element_sum() / self.taken.importance.eval(path)));
        }
        visits.sort_by_key(|(pixel, _)| *pixel);
        let square = |at: &[(u32, f64)]| {
            self.weights[at[0].0 as usize] * (at.iter().map(|(_, value)| value).sum::<f64>() / length as f64).powi(2)
        };
        [tail, weights * visits.chunk_by(|a, b| a.0 == b.0).map(square).sum::<f64>(), squares]
    }

    /// w u (2 − W) f/I, u and f as sums over channels; the same times w u².
    fn of_path(&self, path: &LightPath) -> [f64; 2] {
        let Taken { importance, view, lights, split } = self.taken;
        let (value, colour) = (split.value(path, &view, lights), path.contribution().element_sum());
        let weight = self.weights[path.pixel as usize] * (2.0 - split.share(value, path.pixel));
        let colours = colour / Luminance.eval(path);
        let tail = weight * value * colours * colour / importance.eval(path);
        [tail, tail * self.weights[path.pixel as usize] * (colours * value).powi(2)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::levels::Levels;
    use super::super::split::{IN_VIEW, Split};
    use super::*;
    use crate::transport::colour::Rgb;
    use crate::transport::image::PixelImportance;
    use crate::transport::lights::{LightRegion, LightStrata, Stratification};
    use crate::transport::scene::View;
    use crate::transport::tests::worlds::{lambert, mirror, room};

    /// Mean and standard error.
    fn moments(values: &[f64]) -> [f64; 2] {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt()]
    }

    fn z([a, a_error]: [f64; 2], [b, b_error]: [f64; 2]) -> f64 {
        (a - b) / a_error.hypot(b_error)
    }

    /// In an image of one pixel where all is nearly grey, K is f/I, and R an integral that independent samples estimate as they do T, but for
    /// the chain that is left out.
    #[test]
    fn chains_tell_what_independent_samples_tell() {
        let mut control = 0.0_f64;
        for surface in [lambert(Rgb::ONE), mirror()] {
            let world = room(surface, false);
            let camera = world.camera.with_size([1, 1]);
            let view = View { camera: &camera, ..world.view() };
            let (importance, lights) = (PixelImportance::default(), LightRegion::whole(view.scene.lights()));
            let split = Split::new(&Levels::even(0.02), [1, 1], 6);
            let taken = Taken { importance: &importance, view, lights: &lights, split: &split };
            let parts = LightStrata::new(view.scene.lights(), Stratification::None);
            let strata = LightStratum::of_kinds(&parts, IN_VIEW.others(), view, 6);
            let told: Vec<Told> = (0..24)
                .map(|seed| {
                    Tail { taken, weights: &[2.0], seed }.measure(&strata, 32_000, Watch::NEVER).expect("runs").0
                })
                .collect();
            let integrals = |i: u64| {
                let mut sums = [0.0; 4];
                for (j, stratum) in (0..).zip(&strata) {
                    stratum.sample(&mut generator(9, Purpose::Sample, 0, j, i), &mut |path, weight| {
                        let (value, eval) = (split.value(path, &view, &lights), taken.eval(path));
                        let colours = path.contribution().element_sum() / Luminance.eval(path);
                        let of_pixel = 2.0 * weight * colours.powi(2);
                        if eval > 0.0 {
                            let share = eval / importance.eval(path);
                            let all = of_pixel * value * importance.eval(path);
                            sums[0] += all * share * (2.0 - share);
                            sums[1] += if j == 0 { of_pixel * eval * eval / stratum.density(path) } else { 0.0 };
                            sums[2] += all * share;
                            sums[3] += all * share * (2.0 - share) * 2.0 * (colours * value).powi(2);
                        }
                    });
                }
                sums
            };
            let found: Vec<[f64; 4]> = (0..100_000).map(integrals).collect();
            let [tail, starts, first, squares] =
                [0, 1, 2, 3].map(|i| moments(&found.iter().map(|f| f[i]).collect::<Vec<_>>()));
            let of_chains = moments(&told.iter().map(|told| told.tail).collect::<Vec<_>>());
            assert!(z(of_chains, tail).abs() < 4.0, "{of_chains:?} {tail:?}");
            control = control.max(z(of_chains, first).abs());
            let of_chains = moments(&told.iter().map(|told| told.squares).collect::<Vec<_>>());
            assert!(z(of_chains, squares).abs() < 4.0, "{of_chains:?} {squares:?}");
            let of_chains = moments(&told.iter().map(|told| told.starts[0]).collect::<Vec<_>>());
            assert!((of_chains[0] / starts[0] - 1.0).abs() < 0.25, "{of_chains:?} {starts:?}");
        }
        // The negative control: as if samples kept nothing of what chains share with them.
        assert!(control > 5.0, "{control}");
    }

    #[test]
    fn one_chain_that_is_stuck_says_nothing_of_the_others() {
        let stuck = [[[1.0, 0.01, 0.0]; 15].as_slice(), &[[1e6, 1e6, 0.0]]].concat();
        let [tail, starts, _] = of_stratum(&stuck);
        assert!((starts / tail - 0.01).abs() < 1e-9 && (tail / 62_500.9 - 1.0).abs() < 1e-4, "{tail} {starts}");
        let all = of_stratum(&[[1.0, 0.5, 2.0]; 16]);
        assert!(all.iter().zip([1.0, 0.5, 2.0]).all(|(found, right)| (found - right).abs() < 1e-12));
        assert_eq!(of_stratum(&[[0.0; 3]; 16]), [0.0; 3]);
    }
}
