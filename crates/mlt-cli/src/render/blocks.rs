//! How well the rounds of a render agree, block by block of the image.

use mlt_core::engine::Film;
use mlt_core::transport::{Rgb, luminance};
use rayon::prelude::*;

use crate::report::Agreement;

/// Blocks along each side of the image, where it has as many pixels.
const SIDE: usize = 8;
/// Rounds that are kept.
const MOST_ROUNDS: usize = 4096;
/// Fewest rounds whose disagreement says anything.
const LEAST_ROUNDS: usize = 4;

/// Blocks of an image: nearly equal rectangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    size: [usize; 2],
    /// Columns and rows.
    pub cut: [usize; 2],
}

impl Grid {
    /// Up to `side` columns and rows of blocks for an image of this width and height.
    pub fn new(size: [usize; 2], side: usize) -> Self {
        Self { size, cut: size.map(|n| n.min(side)) }
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.cut[0] * self.cut[1]
    }

    /// The block of a pixel, row by row.
    pub fn block(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.size[0], pixel / self.size[0]);
        (y * self.cut[1] / self.size[1]) * self.cut[0] + x * self.cut[0] / self.size[0]
    }

    /// Σ over the pixels of each block of their values, over the number of the image's pixels. Rows are summed on all threads,
    /// and then in their order.
    pub fn shares(&self, value: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let ([width, height], columns) = (self.size, self.cut[0]);
        let row = |y: usize| {
            let mut sums = vec![0.0; columns];
            (0..width).for_each(|x| sums[x * columns / width] += value(y * width + x));
            sums
        };
        let sums_of_rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
        let mut sums = vec![0.0; self.count()];
        for (y, row) in sums_of_rows.iter().enumerate() {
            let blocks = &mut sums[self.block(y * width)..];
            blocks.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        }
        let n = (width * height) as f64;
        sums.into_iter().map(|sum| sum / n).collect()
    }
}

/// Contribution of each round to each block: mean luminance of the image that comes from it.
#[derive(Clone, Debug)]
pub struct Blocks {
    grid: Grid,
    /// Rounds seen, Σ of their weights, and Σ weight × round.
    seen: [u64; 2],
    sums: Vec<f64>,
    /// Of each round, up to 4096 of them.
    pub rounds: Vec<Vec<f64>>,
}

impl Blocks {
    /// No rounds, for images of this size.
    pub fn new(size: [u32; 2]) -> Self {
        let grid = Grid::new(size.map(|n| n as usize), SIDE);
        Self { grid, seen: [0; 2], sums: vec![0.0; grid.count()], rounds: Vec::new() }
    }

    /// Takes in the round that was closed last. Rounds that were not shown are skipped.
    pub fn add(&mut self, film: &Film<3>) {
        let (now, [rounds, weight]) = ([film.rounds(), film.weight()], self.seen);
        if now[0] == rounds || self.rounds.len() == MOST_ROUNDS {
            return;
        }
        let level = |i: usize| f64::from(luminance(Rgb::from_array(film.mean(i).map(|channel| channel as f32))));
        let sums: Vec<f64> = self.grid.shares(level).iter().map(|mean| mean * now[1] as f64).collect();
        if now[0] == rounds + 1 {
            let of_round = (now[1] - weight) as f64;
            self.rounds.push(sums.iter().zip(&self.sums).map(|(now, before)| (now - before) / of_round).collect());
        }
        (self.sums, self.seen) = (sums, now);
    }

    /// The largest share that one round has of the light of a part of the image, over parts that are no darker than the image;
    /// `None` for a black image. A part is four blocks: one alone is small enough to be lit by chance.
    pub fn largest_round(&self) -> Option<f64> {
        let [columns, rows] = self.grid.cut;
        let part = |block: usize| (block / columns / 2) * columns.div_ceil(2) + block % columns / 2;
        let mut parts = vec![(0.0_f64, 0.0_f64); columns.div_ceil(2) * rows.div_ceil(2)];
        for round in &self.rounds {
            let mut sums = vec![0.0; parts.len()];
            round.iter().enumerate().for_each(|(block, light)| sums[part(block)] += light);
            parts.iter_mut().zip(sums).for_each(|(part, sum)| *part = (part.0 + sum, part.1.max(sum)));
        }
        let mean = parts.iter().map(|part| part.0).sum::<f64>() / parts.len() as f64;
        let lit = parts.into_iter().filter(|&(total, _)| total >= mean && mean > 0.0);
        lit.map(|(total, most)| most / total).reduce(f64::max)
    }

    /// Potential scale reduction R̂ of the rounds, each taken as one chain, for the worst block.
    ///
    /// The estimated quantity is the share q = m/M of the image's luminance that lies in the block. A state of a chain that
    /// samples luminance lies there or not, with variance W = q(1 − q). Rounds whose states are worth n independent
    /// ones differ by B/n = Var(q̂), so R̂² = 1 + Var(q̂)/W and n = W/Var(q̂): R̂ = 1.05 means ten.
    ///
    /// Source: [GelmanRubin92].
    pub fn agreement(&self) -> Option<Agreement> {
        if self.rounds.len() < LEAST_ROUNDS {
            return None;
        }
        let n = self.rounds.len() as f64;
        let mean = |block: usize| self.rounds.iter().map(|round| round[block]).sum::<f64>() / n;
        let means: Vec<f64> = (0..self.grid.count()).map(mean).collect();
        let image: f64 = means.iter().sum();
        let ratio = |block: usize| {
            let m = means[block];
            let variance = self.rounds.iter().map(|round| (round[block] - m).powi(2)).sum::<f64>() / (n - 1.0);
            // A block that holds the whole image, but for rounding, has no variance of its own.
            let within = m * (image - m);
            if within > 1e-12 * image * image { variance / within } else { 0.0 }
        };
        let (worst, ratio) = (0..means.len())
            .map(|block| (block, ratio(block)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|_| image > 0.0)?;
        let block = [worst % self.grid.cut[0], worst / self.grid.cut[0]];
        let effective_samples = n / ratio.max(f64::MIN_POSITIVE);
        Some(Agreement { r_hat: (1.0 + ratio).sqrt(), block, blocks: self.grid.cut, effective_samples })
    }
}

#[cfg(test)]
mod tests {
    use mlt_core::engine::{Sink, Splat};

    use super::*;

    /// Rounds of `states` states each, a share q of which lies in the left half of an image of two pixels.
    fn rounds(states: u32, shares: &[f64]) -> Blocks {
        let (mut film, mut blocks) = (Film::<3>::new(2, 1.0), Blocks::new([2, 1]));
        for &q in shares {
            let left = (q * f64::from(states)).round();
            let mut deposits = film.deposits();
            for (site, count) in [(0, left), (1, f64::from(states) - left)] {
                deposits.deposit(Splat { site, value: [count / f64::from(states); 3] }, 1.0);
            }
            film.add(&[deposits]);
            film.close_round(film.rounds(), 1);
            blocks.add(&film);
        }
        blocks
    }

    #[test]
    fn rounds_are_told_apart() {
        let blocks = rounds(100, &[0.25, 0.75, 0.5]);
        let left: Vec<f64> = blocks.rounds.iter().map(|round| (round[0] * 200.0).round()).collect();
        assert_eq!(left, [25.0, 75.0, 50.0]);
        assert_eq!(blocks.agreement(), None);
    }

    /// q̂ = 0.5 ± 0.05 is what a hundred independent states give; chains that are stuck on either side are worth one.
    #[test]
    fn effective_samples_are_those_of_a_binomial() {
        let agreement = rounds(1000, &[0.45, 0.55, 0.45, 0.55]).agreement().expect("four rounds");
        let per_round = agreement.effective_samples / 4.0;
        assert!((per_round - 75.0).abs() < 1.0 && agreement.r_hat < 1.01, "{agreement:?}");

        let stuck = rounds(1000, &[0.0, 1.0, 1.0, 0.0]).agreement().expect("four rounds");
        assert!(stuck.r_hat > 1.4 && stuck.effective_samples < 4.0, "{stuck:?}");
    }

    #[test]
    fn a_round_that_brought_most_of_the_light_is_found() {
        let even = rounds(1000, &[0.5; 8]).largest_round().expect("lit");
        assert!((even - 0.125).abs() < 1e-6, "{even}");
        let mut blocks = rounds(1000, &[0.5; 8]);
        blocks.rounds[3].iter_mut().for_each(|light| *light *= 10.0);
        assert!((blocks.largest_round().expect("lit") - 10.0 / 17.0).abs() < 1e-6);
        assert_eq!(Blocks::new([8, 8]).largest_round(), None);
    }

    #[test]
    fn a_grid_covers_the_image() {
        let grid = Grid::new([5, 3], 4);
        let blocks: Vec<usize> = (0..15).map(|pixel| grid.block(pixel)).collect();
        assert_eq!((grid.count(), blocks[0], blocks[14]), (12, 0, 11));
        let shares = grid.shares(|_| 1.0);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
    }
}
