//! Independent samples of the image, in rounds: path tracing and bidirectional path tracing as estimators.

use super::bdpt::Bidirectional;
use super::kind::PathEnd;
use super::low_discrepancy::OwenSobol;
use super::pt::PathTracer;
use super::scene::rays_traced;
use crate::engine::{Deposits, Estimator, Purpose, Sink, Splat, generator, uniform_f32};
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;

/// Pixel samples of one task.
const TASK_SAMPLES: u64 = 1 << 13;

/// A method that samples the image at given points.
pub trait ImageSampler: Sync {
    /// Number of pixels in a row, and of rows.
    fn size(&self) -> [u32; 2];

    /// Takes one sample through `image`, in [0, 1)², and shows `visit` its parts: the pixel, if it is not the one at
    /// `image`, and the radiance. Over uniform points of the image, their expected sum in a pixel is the pixel's radiance
    /// over the number of pixels.
    fn sample(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd));
}

impl ImageSampler for PathTracer<'_> {
    fn size(&self) -> [u32; 2] {
        self.view.camera.size()
    }

    fn sample(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        self.sample(image, rng, &mut |radiance, end| visit(None, radiance, end));
    }
}

impl ImageSampler for Bidirectional<'_> {
    fn size(&self) -> [u32; 2] {
        self.view.camera.size()
    }

    fn sample(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        self.sample_image(image, rng, visit);
    }
}

/// A part of path space.
pub trait Selection: Sync {
    /// Whether a path that ends like this belongs to it.
    fn contains(&self, end: &PathEnd) -> bool;
}

/// All paths.
pub struct AllPaths;

impl Selection for AllPaths {
    #[inline]
    fn contains(&self, _: &PathEnd) -> bool {
        true
    }
}

/// How many samples each pixel gets.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleCounts {
    /// The same in every pixel: on average over the rounds so many; round r takes ⌊(r + 1) n⌋ − ⌊r n⌋ of them, but one at
    /// least.
    Even(f64),
    /// So many of each pixel in every round, one or more.
    Each(Vec<u32>),
}

/// Samples the pixels in each round, independently of all other rounds.
pub struct Independent<'a, T, S = AllPaths> {
    /// The method.
    pub sampler: &'a T,
    /// The paths that are sampled.
    pub selection: S,
    /// Samples of the pixels.
    pub counts: SampleCounts,
    /// Key of all random streams.
    pub seed: u64,
}

/// What independent sampling counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleTally {
    /// Samples of the image.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

impl SampleCounts {
    /// Samples of all pixels together in a round.
    fn total(&self, round: u64, pixels: u64) -> u64 {
        match self {
            Self::Even(_) => pixels * self.of(round, 0),
            Self::Each(counts) => counts.iter().map(|&n| u64::from(n)).sum(),
        }
    }

    /// Samples of a pixel in a round.
    fn of(&self, round: u64, pixel: u64) -> u64 {
        match self {
            Self::Even(n) => {
                // The small addend keeps whole multiples whole: ten thirds in three rounds are ten.
                let up_to = |rounds: u64| (rounds as f64 * n + 1e-6).floor() as u64;
                (up_to(round + 1) - up_to(round)).max(1)
            }
            Self::Each(counts) => u64::from(counts[pixel as usize]),
        }
    }

    /// Weight of a round: Var ∝ 1/weight.
    fn weight(&self, round: u64) -> u64 {
        match self {
            Self::Even(_) => self.of(round, 0),
            Self::Each(_) => 1,
        }
    }

    /// Mean samples of a pixel.
    fn mean(&self) -> f64 {
        match self {
            Self::Even(n) => n.max(1.0),
            Self::Each(counts) => counts.iter().map(|&n| f64::from(n)).sum::<f64>() / counts.len() as f64,
        }
    }
}

impl<T: ImageSampler, S: Selection> Independent<'_, T, S> {
    fn pixels(&self) -> u64 {
        let [w, h] = self.sampler.size();
        u64::from(w) * u64::from(h)
    }

    /// Takes a pixel's samples of a round, the first points of one Owen-scrambled Sobol sequence; returns their number.
    fn sample_pixel(&self, task: &ImageTask, pixel: u64, deposits: &mut Deposits<3>) -> u64 {
        let samples = self.counts.of(task.round, pixel);
        let seed = generator(self.seed, Purpose::Image, task.round, 0, pixel).next_u64();
        let [w, h] = self.sampler.size();
        let corner = Vec2::new((pixel % u64::from(w)) as f32, (pixel / u64::from(w)) as f32);
        let mut here = DVec3::ZERO;
        for index in 0..samples {
            let rng = &mut OwenSobol::new(seed, index);
            let inside = Vec2::new(uniform_f32(rng), uniform_f32(rng));
            let image = (corner + inside) / Vec2::new(w as f32, h as f32);
            self.sampler.sample(image.min(Vec2::splat(1.0 - f32::EPSILON)), rng, &mut |elsewhere, value, end| {
                match elsewhere {
                    _ if !self.selection.contains(&end) => {}
                    Some(site) => deposits.deposit(Splat { site, value: value.to_array() }, task.splat_weight),
                    None => here += value,
                }
            });
        }
        if here != DVec3::ZERO {
            deposits.deposit(Splat { site: pixel as u32, value: here.to_array() }, 1.0 / samples as f64);
        }
        samples
    }
}

/// What the tasks of a round share.
pub struct ImageTask {
    round: u64,
    /// One over the mean samples of a pixel: the weight of what crosses the image elsewhere.
    splat_weight: f64,
    pixels_per_task: u64,
}

impl<T: ImageSampler, S: Selection> Estimator<3> for Independent<'_, T, S> {
    type Prepared = ImageTask;
    type Tally = SampleTally;

    fn prepare(&self, round: u64) -> ImageTask {
        let pixels = self.pixels();
        let samples = self.counts.total(round, pixels);
        let pixels_per_task = (TASK_SAMPLES * pixels / samples).max(1);
        ImageTask { round, splat_weight: pixels as f64 / samples as f64, pixels_per_task }
    }

    fn tasks(&self, prepared: &ImageTask) -> usize {
        self.pixels().div_ceil(prepared.pixels_per_task) as usize
    }

    fn task_deposits(&self) -> usize {
        TASK_SAMPLES.max(self.counts.mean() as u64) as usize
    }

    fn run(&self, prepared: &ImageTask, task: usize, deposits: &mut Deposits<3>) -> SampleTally {
        let before = rays_traced();
        let first = task as u64 * prepared.pixels_per_task;
        let last = (first + prepared.pixels_per_task).min(self.pixels());
        let samples = (first..last).map(|pixel| self.sample_pixel(prepared, pixel, deposits)).sum();
        SampleTally { samples, rays: rays_traced() - before }
    }

    fn weight(&self, round: u64) -> u64 {
        self.counts.weight(round)
    }

    fn tally(&self, total: &mut SampleTally, _: &ImageTask, tasks: Vec<SampleTally>) {
        total.samples += tasks.iter().map(|t| t.samples).sum::<u64>();
        total.rays += tasks.iter().map(|t| t.rays).sum::<u64>();
    }
}
