//! Measurement of path tracing on a small image.

use super::constants::LONG_SEQUENCE;
use super::split::{IN_VIEW, Rest, Split};
use crate::engine::{PILOT, Purpose, Watch, generator};
use crate::transport::methods::independent::{ImageSampler, Selection, point_in_pixel};
use crate::transport::methods::path_tracing::PathTracer;
use crate::transport::methods::sobol::OwenSobol;
use crate::transport::paths::Kind;
use crate::transport::scene::rays_traced;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Classes of paths whose noise depends in different ways on how samples are taken: lamps in view, other paths of at most two edges, all
/// others.
pub(super) const CLASSES: usize = 3;

/// Path tracing's share of the image, by classes.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// Each pixel's value, summed over channels.
    pub(super) image: Vec<f64>,
    /// Variance of one sample in each pixel.
    variances: Vec<[f64; CLASSES]>,
    /// Mean over pixels, sum over channels.
    pub(super) energies: [f64; CLASSES],
    /// Samples taken of each pixel.
    pub(super) samples: f64,
    /// Rays of a sample.
    pub(super) work: f64,
}

/// One pixel: of each class the sums of x and of x² over the sequences, x being a sequence's mean; what crossed the image elsewhere; rays.
type Pixel = ([[f64; 2]; CLASSES], Vec<(u32, f64)>, u64);

impl Measured {
    /// Takes some sequences of `samples` samples in every pixel: as many as a round is to take, since the noise of well-stratified samples does
    /// not fall like that of others. Nothing if it is stopped.
    pub(super) fn new(sampler: &PathTracer, split: &Split, samples: u64, seed: u64, watch: Watch) -> Option<Self> {
        let count = sampler.size().iter().product::<u32>();
        let sequences = if samples < LONG_SEQUENCE { 4 } else { 2 };
        let pieces = watch.pieces(count as usize);
        let of_pixel =
            |pixel| pieces.unless_stopped(|| of_pixel(sampler, &Rest(split), pixel, [sequences, samples], seed));
        let pixels: Vec<Pixel> = (0..count).into_par_iter().map(of_pixel).collect::<Option<_>>()?;
        let [n, samples] = [sequences, samples].map(|count| count as f64);
        let work = pixels.iter().map(|(.., rays)| *rays).sum::<u64>() as f64 / (f64::from(count) * n * samples);
        let empty = vec![0.0; count as usize];
        let mut measured = Self {
            variances: vec![[0.0; CLASSES]; empty.len()],
            image: empty,
            energies: [0.0; CLASSES],
            samples: n * samples,
            work,
        };
        for (pixel, (sums, elsewhere, _)) in pixels.iter().enumerate() {
            for (class, [sum, squares]) in sums.iter().enumerate() {
                let variance = (squares - sum * sum / n).max(0.0) / (n - 1.0);
                measured.add(pixel, class, [sum / n, variance * samples]);
            }
            // Each is one of many points of the lights and hits its pixel rarely: Var ≈ E[v²].
            for &(site, value) in elsewhere {
                measured.add(site as usize, 0, [value, value * value].map(|x| x / (n * samples)));
            }
        }
        Some(measured)
    }

    fn add(&mut self, pixel: usize, class: usize, [value, variance]: [f64; 2]) {
        self.variances[pixel][class] += variance;
        self.image[pixel] += value;
        self.energies[class] += value / self.image.len() as f64;
    }

    /// Error that one sample a pixel leaves: mean over pixels of weight × variance.
    pub(super) fn errors(&self, weights: &[f64]) -> [f64; CLASSES] {
        let mut errors = [0.0; CLASSES];
        for (variances, weight) in self.variances.iter().zip(weights) {
            errors.iter_mut().zip(variances).for_each(|(error, variance)| *error += weight * variance);
        }
        errors.map(|error| error / weights.len() as f64)
    }
}

/// The class of a kind of paths.
fn class(kind: Kind) -> usize {
    match kind {
        _ if IN_VIEW.contains(kind) => 0,
        _ if kind == Kind::new(2, false) => 1,
        _ => 2,
    }
}

fn of_pixel(sampler: &PathTracer, rest: &Rest, pixel: u32, [sequences, samples]: [u64; 2], seed: u64) -> Pixel {
    let before = rays_traced();
    let (mut sums, mut elsewhere) = ([[0.0; 2]; CLASSES], Vec::new());
    for sequence in 0..sequences {
        let mut here = [0.0; CLASSES];
        let key = generator(seed, Purpose::Image, PILOT + sequence, 0, pixel.into()).next_u64();
        let rng = &mut OwenSobol::new(key);
        for index in 0..samples {
            rng.go_to(index);
            let film = point_in_pixel(pixel.into(), sampler.size(), rng);
            sampler.sample(film, rng, &mut |site, value, end| {
                let value = rest.part(value, pixel, &end).element_sum();
                match site {
                    None => here[class(end.kind)] += value / samples as f64,
                    Some(site) => elsewhere.push((site, value)),
                }
            });
        }
        sums.iter_mut().zip(here).for_each(|(sum, x)| *sum = [sum[0] + x, sum[1] + x * x]);
    }
    (sums, elsewhere, rays_traced() - before)
}

/// Rays of a sample, from one in every pixel.
pub(super) fn work_of<T: ImageSampler>(sampler: &T, seed: u64) -> f64 {
    let pixels = sampler.size().map(u64::from).iter().product();
    let of_pixel = |pixel| {
        let before = rays_traced();
        let rng = &mut OwenSobol::new(generator(seed, Purpose::Image, PILOT, 0, pixel).next_u64());
        let film = point_in_pixel(pixel, sampler.size(), rng);
        sampler.sample(film, rng, &mut |_, _, _| {});
        rays_traced() - before
    };
    (0..pixels).into_par_iter().map(of_pixel).sum::<u64>() as f64 / pixels as f64
}
