//! Measurement of each part of path space by independent samples of a small image.

use super::constants::{ENOUGH_PIXELS, LONG};
use super::parts::Parts;
use crate::engine::{PILOT, Purpose, Watch, generator};
use crate::transport::methods::independent::{ImageSampler, point_in_pixel};
use crate::transport::methods::sobol::OwenSobol;
use crate::transport::scene::rays_traced;
use glam::DVec3;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Moments of an independent method in every pixel and part.
pub(super) struct Measured {
    /// Number of parts.
    parts: usize,
    /// Sum over channels of the estimated image, pixel by pixel, part after part.
    mean: Vec<f64>,
    /// Variance of that, times the samples of a pixel.
    variance: Vec<f64>,
    /// The value that samples have reached in [`ENOUGH_PIXELS`] pixels, part by part.
    pub(super) largest: Vec<f64>,
    /// Samples taken of each pixel.
    pub(super) samples: f64,
    /// Rays of a sample.
    pub(super) work: f64,
}

/// One pixel's parts.
struct Pixel {
    /// Σ x and Σ x² over the sequences, part after part; x is a sequence's mean.
    sums: Vec<[f64; 2]>,
    /// Contributions that crossed the image at other pixels.
    splats: Vec<Splat>,
    /// Largest value, part after part.
    largest: Vec<f64>,
    rays: u64,
}

/// Contribution that crosses the image at another pixel than the one sampled.
struct Splat {
    /// The pixel, and the part.
    at: (u32, usize),
    value: f64,
}

impl Measured {
    /// Takes some sequences of `samples` samples in every pixel: as many as a round is to take, since the noise of
    /// well-stratified samples does not fall like that of others. Nothing if it is stopped.
    pub(super) fn new<T: ImageSampler>(
        sampler: &T,
        parts: &Parts,
        samples: u64,
        seed: u64,
        watch: Watch,
    ) -> Option<Self> {
        let [w, h] = sampler.size().map(u64::from);
        let sequences = if samples < LONG { 4 } else { 2 };
        let pieces = watch.pieces((w * h) as usize);
        let of_pixel = |pixel| pieces.unless_stopped(|| Pixel::new(sampler, parts, pixel, [sequences, samples], seed));
        let pixels: Vec<_> = (0..w * h).into_par_iter().map(of_pixel).collect::<Option<_>>()?;
        let (n, taken) = (sequences as f64, (samples * sequences) as f64);
        let variance = |s: &[f64; 2]| (s[1] - s[0] * s[0] / n).max(0.0) / (n - 1.0) * samples as f64;
        let sums = || pixels.iter().flat_map(|pixel| &pixel.sums);
        let (mut mean, mut variance): (Vec<_>, Vec<_>) = sums().map(|s| (s[0] / n, variance(s))).unzip();
        // A splat is one of many light subpaths' and hits its pixel rarely: Var ≈ E[v²].
        for Splat { at: (pixel, part), value } in pixels.iter().flat_map(|pixel| &pixel.splats) {
            let at = *pixel as usize * parts.len() + part;
            mean[at] += value / taken;
            variance[at] += value * value / taken;
        }
        let work = pixels.iter().map(|pixel| pixel.rays).sum::<u64>() as f64 / (taken * pixels.len() as f64);
        let largest = |part: usize| {
            let mut values: Vec<_> = pixels.iter().map(|pixel| pixel.largest[part]).collect();
            values.sort_by(|a, b| b.total_cmp(a));
            values[(ENOUGH_PIXELS - 1).min(values.len() - 1)]
        };
        let largest = (0..parts.len()).map(largest).collect();
        Some(Self { parts: parts.len(), mean, variance, largest, samples: taken, work })
    }

    /// Moments of an image with one part.
    #[cfg(test)]
    pub(super) fn of_image(mean: Vec<f64>, variance: Vec<f64>, samples: f64) -> Self {
        Self { parts: 1, mean, variance, largest: vec![0.0], samples, work: 1.0 }
    }

    /// The image, sums over channels.
    pub(super) fn image(&self) -> Vec<f64> {
        self.mean.chunks(self.parts).map(|parts| parts.iter().sum()).collect()
    }

    /// Mean over pixels of a part's image, and its standard error.
    pub(super) fn energy(&self, part: usize) -> [f64; 2] {
        let pixels = (self.mean.len() / self.parts) as f64;
        let mean = |values: &[f64]| values.iter().skip(part).step_by(self.parts).sum::<f64>() / pixels;
        [mean(&self.mean), (mean(&self.variance) / (pixels * self.samples)).sqrt()]
    }

    /// A part's image at a pixel, and its variance.
    pub(super) fn pixel(&self, part: usize, pixel: usize) -> (f64, f64) {
        let at = pixel * self.parts + part;
        (self.mean[at], self.variance[at] / self.samples)
    }

    /// Error of one sample a pixel in a part: mean over pixels of weight × variance.
    pub(super) fn error(&self, part: usize, weights: &[f64]) -> f64 {
        let of_part = self.variance.iter().skip(part).step_by(self.parts);
        of_part.zip(weights).map(|(v, w)| v * w).sum::<f64>() / weights.len() as f64
    }

    /// The same of the whole image, if the parts' errors are independent.
    pub(super) fn whole_error(&self, weights: &[f64]) -> f64 {
        (0..self.parts).map(|part| self.error(part, weights)).sum()
    }
}

impl Pixel {
    fn new<T: ImageSampler>(sampler: &T, parts: &Parts, pixel: u64, [sequences, samples]: [u64; 2], seed: u64) -> Self {
        let before = rays_traced();
        let (mut sums, mut splats) = (vec![[0.0; 2]; parts.len()], Vec::new());
        let mut largest = vec![0.0; parts.len()];
        for sequence in 0..sequences {
            let key = generator(seed, Purpose::Image, PILOT + sequence, 0, pixel).next_u64();
            let mut here = vec![0.0; parts.len()];
            let rng = &mut OwenSobol::new(key);
            for index in 0..samples {
                rng.go_to(index);
                let film = point_in_pixel(pixel, sampler.size(), rng);
                sampler.sample(film, rng, &mut |elsewhere, value: DVec3, end| {
                    let (part, value) = (parts.index(&end), value.element_sum());
                    largest[part] = f64::max(largest[part], value);
                    match elsewhere {
                        None => here[part] += value / samples as f64,
                        Some(pixel) => splats.push(Splat { at: (pixel, part), value }),
                    }
                });
            }
            sums.iter_mut().zip(here).for_each(|(sum, x)| *sum = [sum[0] + x, sum[1] + x * x]);
        }
        Self { sums, splats, largest, rays: rays_traced() - before }
    }
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
