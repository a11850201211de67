//! What independent samples of a small image tell about each part of path space.

use super::parts::Parts;
use crate::engine::{PILOT, Purpose, generator, uniform_f32};
use crate::transport::independent::ImageSampler;
use crate::transport::low_discrepancy::OwenSobol;
use crate::transport::scene::rays_traced;
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Points of one sequence for which two sequences a pixel, whose spread is the noise, are enough; shorter ones are four.
const LONG: u64 = 4;

/// Moments of an independent method in every pixel and part.
pub(super) struct Measured {
    /// Number of parts.
    parts: usize,
    /// Sum over channels of the estimated image, pixel by pixel, part after part.
    mean: Vec<f64>,
    /// Variance of that, times the samples of a pixel.
    variance: Vec<f64>,
    /// Samples taken of each pixel.
    pub(super) samples: f64,
    /// Rays of a sample.
    pub(super) work: f64,
}

/// What crosses the image at another pixel than the one sampled.
struct Splat {
    at: usize,
    value: f64,
}

impl Measured {
    /// Takes some sequences of `samples` samples in every pixel: as many as a round is to take, since the noise of
    /// well-stratified samples does not fall like that of others.
    pub(super) fn new<T: ImageSampler>(sampler: &T, parts: &Parts, samples: u64, seed: u64) -> Self {
        let [w, h] = sampler.size();
        let (pixels, n) = ((w * h) as usize, parts.len());
        let sequences = if samples < LONG { 4 } else { 2 };
        let row = |y: u32| {
            let before = rays_traced();
            let mut splats = Vec::new();
            let mut sums = vec![[0.0; 2]; w as usize * n];
            for x in 0..w {
                for sequence in 0..sequences {
                    let key = generator(seed, Purpose::Image, PILOT + sequence, 0, u64::from(y * w + x)).next_u64();
                    let mut here = vec![0.0; n];
                    for index in 0..samples {
                        let rng = &mut OwenSobol::new(key, index);
                        let inside = Vec2::new(uniform_f32(rng), uniform_f32(rng));
                        let image = (Vec2::new(x as f32, y as f32) + inside) / Vec2::new(w as f32, h as f32);
                        sampler.sample(
                            image.min(Vec2::splat(1.0 - f32::EPSILON)),
                            rng,
                            &mut |elsewhere, v: DVec3, end| {
                                let (part, value) = (parts.index(&end), v.element_sum());
                                match elsewhere {
                                    None => here[part] += value / samples as f64,
                                    Some(pixel) => splats.push(Splat { at: pixel as usize * n + part, value }),
                                }
                            },
                        );
                    }
                    for (sum, x) in sums[x as usize * n..].iter_mut().zip(here) {
                        *sum = [sum[0] + x, sum[1] + x * x];
                    }
                }
            }
            (sums, splats, rays_traced() - before)
        };
        let rows: Vec<_> = (0..h).into_par_iter().map(row).collect();
        let taken = (samples * sequences) as f64;
        let mut measured = Self { parts: n, mean: Vec::new(), variance: Vec::new(), samples: taken, work: 0.0 };
        for (sums, _, rays) in &rows {
            let count = sequences as f64;
            measured.mean.extend(sums.iter().map(|s| s[0] / count));
            let variance = |s: &[f64; 2]| (s[1] - s[0] * s[0] / count).max(0.0) / (count - 1.0) * samples as f64;
            measured.variance.extend(sums.iter().map(variance));
            measured.work += *rays as f64 / (taken * pixels as f64);
        }
        // A splat is one of many light subpaths' and hits its pixel rarely: Var ≈ E[v²].
        for Splat { at, value } in rows.iter().flat_map(|row| &row.1) {
            measured.mean[*at] += value / taken;
            measured.variance[*at] += value * value / taken;
        }
        measured
    }

    /// The image, sums over channels.
    pub(super) fn image(&self) -> Vec<f64> {
        self.mean.chunks(self.parts).map(|parts| parts.iter().sum()).collect()
    }

    /// Mean over pixels of a part's image, and its standard error.
    pub(super) fn energy(&self, part: usize) -> [f64; 2] {
        let pixels = (self.mean.len() / self.parts) as f64;
        let sum = |values: &[f64]| values.iter().skip(part).step_by(self.parts).sum::<f64>() / pixels;
        [sum(&self.mean), (sum(&self.variance) / (pixels * self.samples)).sqrt()]
    }

    /// Error of one sample a pixel in a part: mean over pixels of weight × variance.
    pub(super) fn error(&self, part: usize, weights: &[f64]) -> f64 {
        let of_part = self.variance.iter().skip(part).step_by(self.parts);
        of_part.zip(weights).map(|(v, w)| v * w).sum::<f64>() / weights.len() as f64
    }

    /// Error of one sample of each pixel in some of the parts: weight × variance.
    pub(super) fn errors(&self, parts: &[bool], weights: &[f64]) -> Vec<f64> {
        let of_pixel = |v: &[f64]| v.iter().zip(parts).filter(|(_, taken)| **taken).map(|(v, _)| v).sum::<f64>();
        self.variance.chunks(self.parts).zip(weights).map(|(v, w)| w * of_pixel(v)).collect()
    }
}
