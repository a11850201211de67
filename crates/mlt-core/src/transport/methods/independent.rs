//! Independent samples of the image, in rounds: path tracing and bidirectional path tracing as estimators.

use super::sobol::OwenSobol;
use crate::engine::{
    Counted, DecodeError, Deposits, Estimator, Purpose, Reader, Sink, Splat, add_count, generator, put, uniform_f32,
};
use crate::instructions::{InstructionSet, Work};
use crate::transport::paths::PathEnd;
use crate::transport::scene::rays_traced;
use glam::{DVec3, Vec2};
use rand_pcg::rand_core::Rng;
use std::ops::Range;

/// Pixel samples of one task.
const TASK_SAMPLES: u64 = 1 << 13;

/// A method that samples the image at given points.
pub trait ImageSampler: Sync {
    /// Number of pixels in a row, and of rows.
    fn size(&self) -> [u32; 2];

    /// Takes one sample through `film`, in [0, 1)², and shows `visit` its parts: the pixel, if it is not the one at
    /// `film`, and the radiance. Over uniform film points, their expected sum in a pixel is the pixel's radiance
    /// over the number of pixels.
    fn sample(&self, film: Vec2, rng: &mut OwenSobol, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd));
}

/// A part of what paths contribute.
pub trait Selection: Sync {
    /// The part of a contribution that belongs to it, of a path that crosses the image at a pixel.
    fn part(&self, value: DVec3, pixel: u32, end: &PathEnd) -> DVec3;
}

/// All paths.
#[derive(Debug)]
pub struct AllPaths;

impl Selection for AllPaths {
    #[inline]
    fn part(&self, value: DVec3, _: u32, _: &PathEnd) -> DVec3 {
        value
    }
}

/// Samples every pixel equally often in each round.
#[derive(Debug)]
pub struct Independent<'a, T, S = AllPaths> {
    /// The method.
    pub sampler: &'a T,
    /// The paths that are sampled.
    pub selection: S,
    /// Samples of each pixel in a round, on average over the rounds: round r takes ⌊(r + 1) n⌋ − ⌊r n⌋ of them, but one
    /// at least.
    pub samples_per_pixel: f64,
    /// Key of all random streams.
    pub seed: u64,
}

/// Counts of independent sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleTally {
    /// Samples of the image.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

impl Counted for SampleTally {
    fn merge(&mut self, other: &Self) {
        add_count(&mut self.samples, other.samples);
        add_count(&mut self.rays, other.rays);
    }

    fn write(&self, to: &mut Vec<u8>) {
        [self.samples, self.rays].into_iter().for_each(|count| put(to, count));
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        Ok(Self { samples: from.number()?, rays: from.number()? })
    }
}

impl<T: ImageSampler, S: Selection> Independent<'_, T, S> {
    fn pixels(&self) -> u64 {
        let [w, h] = self.sampler.size();
        u64::from(w) * u64::from(h)
    }

    fn samples(&self, round: u64) -> u64 {
        // The small addend keeps whole multiples whole: ten thirds in three rounds are ten.
        let up_to = |rounds: u64| (rounds as f64 * self.samples_per_pixel + 1e-6).floor() as u64;
        (up_to(round + 1) - up_to(round)).max(1)
    }

    /// Pixels of one task: at least one, as many as make a task worth its while.
    fn pixels_per_task(&self) -> u64 {
        (TASK_SAMPLES / (self.samples_per_pixel.ceil() as u64).max(1)).max(1)
    }

    /// Takes a pixel's samples of a round: the first points of one Owen-scrambled Sobol sequence.
    #[inline(always)]
    fn sample_pixel(&self, round: u64, pixel: u64, rng: &mut OwenSobol, deposits: &mut Deposits<3>) {
        let samples = self.samples(round);
        let seed = generator(self.seed, Purpose::Image, round, 0, pixel).next_u64();
        let size = self.sampler.size();
        let weight = 1.0 / samples as f64;
        let mut here = DVec3::ZERO;
        rng.restart(seed);
        for index in 0..samples {
            rng.go_to(index);
            let film = point_in_pixel(pixel, size, rng);
            self.sampler.sample(film, rng, &mut |elsewhere, value, end| {
                let value = self.selection.part(value, elsewhere.unwrap_or(pixel as u32), &end);
                match elsewhere {
                    Some(site) => deposits.deposit(Splat { site, value: value.to_array() }, weight),
                    None => here += value,
                }
            });
        }
        if here != DVec3::ZERO {
            deposits.deposit(Splat { site: pixel as u32, value: here.to_array() }, weight);
        }
    }
}

/// The samples of some pixels in a round.
struct Pixels<'a, T, S> {
    of: &'a Independent<'a, T, S>,
    round: u64,
    pixels: Range<u64>,
    deposits: &'a mut Deposits<3>,
}

impl<T: ImageSampler, S: Selection> Work for Pixels<'_, T, S> {
    type Outcome = ();

    #[inline(always)]
    fn perform(self) {
        let mut rng = OwenSobol::new(0);
        for pixel in self.pixels {
            self.of.sample_pixel(self.round, pixel, &mut rng, self.deposits);
        }
    }
}

/// A uniform point of a pixel, as a film point in [0, 1)².
pub(crate) fn point_in_pixel(pixel: u64, [w, h]: [u32; 2], rng: &mut impl Rng) -> Vec2 {
    let pixel = pixel as u32;
    let corner = Vec2::new((pixel % w) as f32, (pixel / w) as f32);
    let inside = Vec2::new(uniform_f32(rng), uniform_f32(rng));
    ((corner + inside) / Vec2::new(w as f32, h as f32)).min(Vec2::splat(1.0 - f32::EPSILON))
}

impl<T: ImageSampler, S: Selection> Estimator<3> for Independent<'_, T, S> {
    type Prepared = u64;
    type Task = SampleTally;
    type Tally = SampleTally;

    fn prepare(&self, round: u64) -> u64 {
        round
    }

    fn tasks(&self, _: &u64) -> usize {
        self.pixels().div_ceil(self.pixels_per_task()) as usize
    }

    fn task_deposits(&self) -> usize {
        (self.pixels_per_task() * (self.samples_per_pixel.ceil() as u64).max(1)) as usize
    }

    fn run(&self, round: &u64, task: usize, deposits: &mut Deposits<3>) -> SampleTally {
        let before = rays_traced();
        let first = task as u64 * self.pixels_per_task();
        let last = (first + self.pixels_per_task()).min(self.pixels());
        InstructionSet::detect().perform(Pixels { of: self, round: *round, pixels: first..last, deposits });
        SampleTally { samples: (last - first) * self.samples(*round), rays: rays_traced() - before }
    }

    fn weight(&self, round: u64) -> u64 {
        self.samples(round)
    }

    fn tally(&self, total: &mut SampleTally, _: &u64, tasks: Vec<SampleTally>) {
        tasks.iter().for_each(|task| total.merge(task));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::lights::LightRegion;
    use crate::transport::methods::bidirectional::Bidirectional;
    use crate::transport::methods::path_tracing::PathTracer;
    use crate::transport::tests::worlds::worlds;

    /// Deposits of a task with the instructions that the processor has, and with those that all have.
    fn both<T: ImageSampler>(sampler: &T) -> [Deposits<3>; 2] {
        let of = &Independent { sampler, selection: AllPaths, samples_per_pixel: 9.0, seed: 5 };
        let mut deposits = [(); 2].map(|()| Deposits::new(of.pixels() as u32, 31));
        let [best, portable] = deposits.each_mut().map(|deposits| Pixels { of, round: 2, pixels: 0..50, deposits });
        InstructionSet::detect().perform(best);
        portable.perform();
        deposits
    }

    #[test]
    fn instructions_change_no_bit() {
        for (name, world) in worlds() {
            let (view, region) = (world.view(), &LightRegion::whole(world.scene.lights()));
            let light_sampler = region.light_sampler();
            let paths = PathTracer { view, light_sampler, max_edges: 12, max_image_edges: 12, branches: 2 };
            let connected = Bidirectional { view, region, max_edges: 12 };
            for [best, portable] in [both(&paths), both(&connected)] {
                assert!(!portable.list().is_empty(), "{name}");
                assert_eq!(best.list(), portable.list(), "{name}");
            }
        }
    }
}
