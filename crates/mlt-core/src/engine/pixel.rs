//! Values of a film's sites, and their errors.

use super::Film;
use super::fixed::{ROUNDING, ROUNDING_OF_WHOLE};
use rayon::prelude::*;

/// Mean and standard error of one channel of one site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Σ w X / Σ w over the rounds.
    pub mean: f64,
    /// Standard error of `mean`; infinite with fewer than two rounds and where the squares left their range.
    pub stderr: f64,
}

impl<const C: usize> Film<C> {
    /// Means of a site's channels, of the rounds closed so far; 0 without any.
    #[inline]
    pub fn mean(&self, site: usize) -> [f64; C] {
        let w = self.weight().max(1) as f64;
        self.sums(site).map(|sums| sums.first() / w * self.unit)
    }

    /// Means of all sites, as an image shows them.
    pub fn means(&self) -> Vec<[f32; C]> {
        (0..self.sites() as usize).into_par_iter().map(|site| self.mean(site).map(|x| x as f32)).collect()
    }

    /// Means of all sites while rounds are made. Before the first is closed: what the current one has so far, an estimate that is
    /// too dark where its tasks are not done.
    pub fn preview(&self) -> Vec<[f32; C]> {
        match self.rounds() {
            0 if !self.round().is_empty() => self.round().to_vec(),
            _ => self.means(),
        }
    }

    /// Mean and standard error of a site's channels, of the rounds closed so far; 0 without any.
    pub fn pixel(&self, site: usize) -> [Pixel; C] {
        self.sums(site).map(|sums| {
            let square = sums.second();
            let Pixel { mean, stderr } = self.moments([sums.first(), square.unwrap_or(f64::MAX)], ROUNDING);
            Pixel { mean, stderr: if square.is_some() { stderr } else { f64::INFINITY } }
        })
    }

    /// Σ_c weights_c × channel c of a site, and a bound on its standard error: Σ weight × error of the channels, which is exact
    /// where their errors are fully correlated.
    pub fn weighted(&self, site: usize, weights: [f64; C]) -> Pixel {
        let channels = self.pixel(site);
        let sum = |value: fn(&Pixel) -> f64| channels.iter().zip(weights).map(|(c, w)| w * value(c)).sum();
        Pixel { mean: sum(|c| c.mean), stderr: sum(|c| c.stderr) }
    }

    /// Mean over all sites of Σ_c weights_c × channel c, and its standard error: the scatter over rounds of that mean. What
    /// sites have in common in a round is in it, which no sum over the sites' own errors has.
    pub fn whole(&self, weights: [f64; C]) -> Pixel {
        self.moments(self.whole.of(weights), ROUNDING_OF_WHOLE)
    }

    /// From Σ w X and Σ w X² over the rounds, in units and units².
    ///
    /// mean = Σ w X / W,  stderr² = (Σ w X² − W mean²) / ((R − 1) W),  W = Σ w,  and what `rounding` may hide of X².
    fn moments(&self, [first, second]: [f64; 2], rounding: f64) -> Pixel {
        let rounds = self.rounds() as f64;
        if rounds == 0.0 {
            return Pixel { mean: 0.0, stderr: f64::INFINITY };
        }
        let w = self.weight() as f64;
        let mean = first / w;
        let rounding = if first == 0.0 { 0.0 } else { rounding };
        let scatter = (second / w - mean * mean).max(0.0) + rounding;
        let variance = if rounds < 2.0 { f64::INFINITY } else { scatter / (rounds - 1.0) };
        Pixel { mean: mean * self.unit, stderr: variance.sqrt() * self.unit }
    }
}
