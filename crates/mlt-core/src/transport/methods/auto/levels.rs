//! The level of each part of the image: what a pixel is expected to show, without noise.

use super::constants::{LEVEL_FLOOR, LEVEL_RADIUS, LEVEL_SAMPLES};
use crate::engine::{DecodeError, PILOT, Purpose, Reader, Watch, generator, put, put_list};
use crate::transport::colour::LUMINANCE;
use crate::transport::image::blurred;
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::methods::independent::{ImageSampler, point_in_pixel};
use crate::transport::methods::sobol::OwenSobol;
use crate::transport::paths::Kinds;
use glam::DVec3;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Luminance of a small image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Levels {
    size: [u32; 2],
    values: Vec<f64>,
}

/// The pixel and half that a sample falls into; its luminance.
type Shown = ([usize; 2], f64);

impl Levels {
    /// The same everywhere.
    pub(super) fn even(level: f64) -> Self {
        Self { size: [1, 1], values: vec![level] }
    }

    /// By bidirectional samples, which miss little that others meet, of paths of these kinds. Nothing if it is stopped.
    pub(super) fn measure(sampler: &Bidirectional, kinds: Kinds, seed: u64, watch: Watch) -> Option<Self> {
        let size = sampler.size();
        let pixels = size[0] * size[1];
        let pieces = watch.pieces(pixels as usize);
        let of_pixel = |pixel| pieces.unless_stopped(|| shown(sampler, kinds, pixel, seed));
        let shown: Vec<Vec<Shown>> = (0..pixels).into_par_iter().map(of_pixel).collect::<Option<_>>()?;
        let mut halves = [(); 2].map(|()| vec![0.0; pixels as usize]);
        for ([pixel, half], value) in shown.into_iter().flatten() {
            halves[half][pixel] += value / (LEVEL_SAMPLES / 2) as f64;
        }
        let light = without_noise(&halves, size);
        let floor = LEVEL_FLOOR * light.iter().sum::<f64>() / f64::from(pixels);
        let values = light.into_iter().map(|level| level.max(floor)).collect();
        Some(Self { size, values })
    }

    /// Whether there is no light at all.
    pub(super) fn is_dark(&self) -> bool {
        self.values.iter().all(|&level| level <= 0.0)
    }

    /// All of them, row by row.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// For an image of this size: a number for each column and one for each row. Their sum is the index of a pixel's level in
    /// [`values`](Self::values).
    pub(super) fn places(&self, [width, height]: [u32; 2]) -> [Vec<u32>; 2] {
        let [w, h] = self.size;
        let along = |i: u32, small: u32, large: u32| (u64::from(i) * u64::from(small) / u64::from(large)) as u32;
        [(0..width).map(|x| along(x, w, width)).collect(), (0..height).map(|y| along(y, h, height) * w).collect()]
    }

    /// Appends them to bytes.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        self.size.into_iter().for_each(|n| put(to, n.into()));
        put_list(to, &self.values, |to, level| put(to, level.to_bits()));
    }

    /// Reads what [`write`](Self::write) has written.
    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let size = [from.number()?, from.number()?].map(|n| u32::try_from(n).unwrap_or(0));
        let values = from.list(|from| from.number().map(f64::from_bits))?;
        let fits = size.map(u64::from).iter().product::<u64>() == values.len() as u64 && !values.is_empty();
        match fits && values.iter().all(|level| level.is_finite() && *level >= 0.0) {
            true => Ok(Self { size, values }),
            false => Err(DecodeError::Damaged),
        }
    }
}

/// An image from two with independent noise: smooth, but where both are bright.
fn without_noise([a, b]: &[Vec<f64>; 2], size: [u32; 2]) -> Vec<f64> {
    let radius = (LEVEL_RADIUS * f64::from(size[0].max(size[1]))).ceil() as usize;
    let mean: Vec<_> = a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
    let darker = a.iter().zip(b).map(|(a, b)| a.min(*b));
    blurred(&mean, size, radius).into_iter().zip(darker).map(|(smooth, darker)| smooth.max(darker)).collect()
}

fn shown(sampler: &Bidirectional, kinds: Kinds, pixel: u32, seed: u64) -> Vec<Shown> {
    let mut shown = Vec::new();
    let rng = &mut OwenSobol::new(generator(seed, Purpose::Image, PILOT - 1, 0, pixel.into()).next_u64());
    for index in 0..LEVEL_SAMPLES {
        rng.go_to(index);
        let film = point_in_pixel(pixel.into(), sampler.size(), rng);
        sampler.sample(film, rng, &mut |elsewhere, value, end| {
            if kinds.contains(end.kind) {
                let at = [elsewhere.unwrap_or(pixel) as usize, index as usize % 2];
                shown.push((at, value.dot(DVec3::from_array(LUMINANCE))));
            }
        });
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each pixel of a larger image has the level of the pixel that it lies in.
    #[test]
    fn a_pixel_has_the_level_of_its_place() {
        let levels = Levels { size: [2, 3], values: (0..6).map(f64::from).collect() };
        let [columns, rows] = levels.places([5, 7]);
        let level = |x: usize, y: usize| levels.values()[(columns[x] + rows[y]) as usize];
        let row = |y| (0..5).map(|x| level(x, y)).collect::<Vec<_>>();
        assert_eq!(row(0), [0.0, 0.0, 0.0, 1.0, 1.0]);
        assert_eq!(row(6), [4.0, 4.0, 4.0, 5.0, 5.0]);
        assert_eq!((0..7).map(|y| level(0, y)).collect::<Vec<_>>(), [0.0, 0.0, 0.0, 2.0, 2.0, 4.0, 4.0]);
    }
}
