//! Errors of an image, from the scatter of its rounds.

use super::Film;
use rayon::prelude::*;
use std::ops::Range;

/// Half the sides of the squares around a site, until one of them has sites enough.
const RADII: [usize; 5] = [2, 3, 4, 6, 8];
/// Sites of equal noise that are enough to know how noisy a site is; they count as so many more of its rounds.
const ENOUGH: f64 = 16.0;
/// Sites whose squares one thread sums.
const SITES_PER_SUM: u32 = 1 << 10;

impl<const C: usize> Film<C> {
    /// Estimated relative error of the image, √(Σ stderr² / Σ value²) over sites, of values Σ_c weights_c × channel c; infinite
    /// before the second round and for a black image.
    pub fn relative_error(&self, weights: [f64; C]) -> f64 {
        let sums = |first: u32| {
            let (mut errors, mut squares) = (0.0, 0.0);
            for site in first..self.sites().min(first + SITES_PER_SUM) {
                let value = self.weighted(site as usize, weights);
                errors += value.stderr * value.stderr;
                squares += value.mean * value.mean;
            }
            [errors, squares]
        };
        let parts = self.sites().div_ceil(SITES_PER_SUM);
        let parts: Vec<_> = (0..parts).into_par_iter().map(|part| sums(part * SITES_PER_SUM)).collect();
        let [errors, squares] = [0, 1].map(|i| parts.iter().map(|part: &[f64; 2]| part[i]).sum::<f64>());
        if squares > 0.0 { (errors / squares).sqrt() } else { f64::INFINITY }
    }

    /// Standard errors of all sites, row by row and channel by channel:
    ///
    /// s² = ((R − 1) v + 16 v̄)/(R − 1 + 16),
    ///
    /// v being the scatter of the site's own R rounds and v̄ its mean over a square around the site. Where few rounds have met what
    /// is bright, the scatter of most sites is too small, that of rounds which all found nothing is 0, and only some have it all.
    /// The square is the smallest of 5, 7, 9, 13 and 17 sites a side with (Σ v)²/Σ v² ≥ 16. Both estimate the same variance where
    /// sites are alike, so their mean does, and their maximum would be too large.
    ///
    /// Sources: [Kish65], section 11.2, for the number of sites of equal weight; [Smyth04] for the mean.
    pub fn standard_errors(&self) -> Vec<[f64; C]> {
        self.standard_errors_of(0..self.size()[1] as usize)
    }

    /// Those of some rows alone.
    pub fn standard_errors_of(&self, rows: Range<usize>) -> Vec<[f64; C]> {
        let size @ [width, height] = self.size().map(|n| n as usize);
        let margin = RADII[RADII.len() - 1];
        let around = rows.start.saturating_sub(margin)..rows.end.saturating_add(margin).min(height);
        let own = |site: usize| self.pixel(site).map(|channel| channel.stderr * channel.stderr);
        let own = (around.start * width..around.end * width).into_par_iter().map(own).collect();
        let variances = Variances { own, first: around.start * width, size };
        let freedom = self.rounds().saturating_sub(1) as f64;
        let shared = |site: usize| {
            let around = variances.mean_around(site);
            let own = variances.own[site - variances.first];
            std::array::from_fn(|c| match own[c] {
                v if v.is_finite() => ((freedom * v + ENOUGH * around[c]) / (freedom + ENOUGH)).sqrt(),
                unknown => unknown,
            })
        };
        (rows.start * width..rows.end * width).into_par_iter().map(shared).collect()
    }
}

/// Variances of the sites of some rows.
struct Variances<const C: usize> {
    own: Vec<[f64; C]>,
    /// The first of these sites.
    first: usize,
    /// Of the whole film.
    size: [usize; 2],
}

impl<const C: usize> Variances<C> {
    /// Mean of the variances over the square around a site. Those that are not known do not count.
    fn mean_around(&self, site: usize) -> [f64; C] {
        let [width, height] = self.size;
        let (x, y) = (site % width, site / width);
        let mut mean = [0.0; C];
        for radius in RADII {
            let side = |at: usize, n: usize| at.saturating_sub(radius)..(at + radius + 1).min(n);
            let (columns, rows) = (side(x, width), side(y, height));
            let (mut sums, mut sum, mut squares) = ([0.0; C], 0.0, 0.0);
            for row in rows.clone() {
                for variance in &self.own[row * width - self.first..][columns.clone()] {
                    let known = variance.map(|v| if v.is_finite() { v } else { 0.0 });
                    let all = known.iter().sum::<f64>();
                    sums.iter_mut().zip(known).for_each(|(sum, v)| *sum += v);
                    (sum, squares) = (sum + all, squares + all * all);
                }
            }
            mean = sums.map(|sum| sum / (rows.len() * columns.len()) as f64);
            if squares > 0.0 && sum * sum >= ENOUGH * squares {
                break;
            }
        }
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, Sink, Splat, generator, uniform};

    /// Four rounds of an image of 40×40 pixels, each of which has `value(pixel, round)` in all channels.
    fn film(value: impl Fn(u32, u32) -> f64) -> Film<3> {
        let mut film = Film::<3>::of_image([40, 40], 1.0);
        for round in 0..4 {
            let mut deposits = film.deposits();
            (0..1600).for_each(|site| deposits.deposit(Splat { site, value: [value(site, round); 3] }, 1.0));
            film.add(&mut [deposits]);
            film.close_round(u64::from(round), 1);
        }
        film
    }

    #[test]
    fn a_pixel_without_light_takes_the_errors_around_it() {
        // One pixel in five of each row and column is lit, in one round of two.
        let film = film(|site, round| f64::from(u32::from(site % 5 == 2 && site / 40 % 5 == 2) * (round % 2)));
        let lit = film.pixel(2 * 40 + 2)[0].stderr;
        let errors = film.standard_errors();
        // A square of 17 holds 9 to 16 of them, of which those near the corner hold 4.
        let around = |pixel: usize, own: f64| ((errors[pixel][0] / lit).powi(2) * 19.0 - 3.0 * own) / 16.0;
        let held = around(19 * 40 + 19, 0.0) * 289.0;
        assert!((held - 9.0).abs() < 1e-6 || (held - 16.0).abs() < 1e-6, "{held}");
        assert!((around(2 * 40 + 2, 1.0) * 121.0 - 4.0).abs() < 1e-6, "{}", around(2 * 40 + 2, 1.0) * 121.0);
    }

    #[test]
    fn a_pixel_of_little_noise_among_many_takes_the_smallest_square_that_is_enough() {
        // Noise of a half, but for one pixel that was lucky.
        let film = film(|site, round| if site == 820 { 1.0 } else { f64::from(round % 2) });
        let errors = film.standard_errors();
        let noise = film.pixel(0)[0].stderr;
        assert!((errors[0][0] - noise).abs() < 1e-9);
        let expected = (16.0 / 19.0 * 24.0 / 25.0f64).sqrt();
        assert!((errors[820][0] / noise - expected).abs() < 1e-6, "{}", errors[820][0] / noise);
    }

    /// Pixels that a round lights once in twenty times, evenly or by a law with a few large values: the mean square of the bars is
    /// that of the errors.
    #[test]
    fn bars_are_as_wide_as_errors_on_average() {
        let (mut squares, mut bars, mut largest) = (0.0, 0.0, 0.0);
        for seed in 0..20 {
            let value = |site: u32, round: u32| {
                let rng = &mut generator(seed, Purpose::Image, u64::from(round), u64::from(site), 0);
                if uniform(rng) < 0.05 { 1.0 + 3.0 * uniform(rng).powi(4) } else { 0.0 }
            };
            let film = film(value);
            let shared = film.standard_errors();
            let own = (0..1600).map(|i| film.pixel(i).map(|c| c.stderr.powi(2))).collect();
            let own = Variances { own, first: 0, size: [40, 40] };
            for (i, bar) in shared.iter().enumerate() {
                squares += (film.pixel(i)[0].mean - 0.05 * 1.6).powi(2);
                bars += bar[0].powi(2);
                // The negative control.
                largest += own.own[i][0].max(own.mean_around(i)[0]);
            }
        }
        assert!((bars / squares - 1.0).abs() < 0.05, "{}", bars / squares);
        assert!(largest / squares > 1.5, "{}", largest / squares);
    }

    #[test]
    fn errors_that_are_not_known_stay_so_and_do_not_spread() {
        let film = film(|site, round| if site == 820 { 1e15 } else { f64::from(round % 2) });
        let errors = film.standard_errors();
        assert!(errors[820][0].is_infinite() && errors[821][0].is_finite());
    }
    #[test]
    fn rows_have_the_errors_of_the_whole() {
        let film = film(|site, round| f64::from((site * 7 + round * 3) % 11));
        let whole = film.standard_errors();
        for rows in [0..1, 3..17, 30..40] {
            assert_eq!(film.standard_errors_of(rows.clone()), whole[rows.start * 40..rows.end * 40]);
        }
    }
}
