//! How well the rounds of a render agree, block by block of the image.

use mlt_core::engine::{self, Grid};
use mlt_core::transport::LUMINANCE;

use crate::report::Agreement;

/// Fewest rounds whose disagreement says anything.
const LEAST_ROUNDS: usize = 4;

/// Contribution of each round to each block: mean luminance of the image that comes from it.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    grid: Grid,
    /// Of each round in the order of their numbers.
    pub rounds: Vec<Vec<f64>>,
}

impl From<&engine::Blocks<3>> for Blocks {
    fn from(blocks: &engine::Blocks<3>) -> Self {
        Self { grid: blocks.grid(), rounds: blocks.rounds(LUMINANCE) }
    }
}

impl Blocks {
    /// The largest share that one round has of the light of a part of the image, over parts that are no darker than the image;
    /// `None` for a black image. A part is four blocks: one alone is small enough to be lit by chance.
    pub(crate) fn largest_round(&self) -> Option<f64> {
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
    pub(crate) fn agreement(&self) -> Option<Agreement> {
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
    use mlt_core::engine::{Film, Sink, Splat};

    use super::*;

    /// Rounds of `states` states each, a share q of which lies in the left half of an image of two pixels.
    fn rounds(states: u32, shares: &[f64]) -> Blocks {
        let mut film = Film::<3>::new(2, 1.0);
        for &q in shares {
            let left = (q * f64::from(states)).round();
            let mut deposits = film.deposits();
            for (site, count) in [(0, left), (1, f64::from(states) - left)] {
                deposits.deposit(Splat { site, value: [count / f64::from(states); 3] }, 1.0);
            }
            film.add(&mut [deposits]);
            film.close_round(film.rounds(), 1);
        }
        film.blocks().into()
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
        assert_eq!(rounds(1000, &[]).largest_round(), None);
    }
}
