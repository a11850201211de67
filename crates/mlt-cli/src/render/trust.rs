//! Signs that an image's error bars say too little: light that few samples or few rounds have met.

use mlt_core::engine::{Film, StratumStats};
use mlt_core::transport::image::{luminance_and_error, mean_luminance};
use mlt_core::transport::render::Counts;
use rayon::prelude::*;
use serde::Serialize;

use super::{blocks::Blocks, plan::TRUSTED_ROUNDS};

/// Share of the pixels that are the worst.
const WORST: f64 = 0.01;
/// Half the side of the square that is around a pixel.
const AROUND: usize = 2;
/// Share of the image's squared relative error that is too much for them.
const MOST_OF_WORST: f64 = 0.7;
/// Share of the light in a part of the image that is too much for one round.
const MOST_OF_ROUND: f64 = 1.0 / 3.0;
/// Fewest independent samples of equal weight that chains should start from.
const LEAST_STARTS: f64 = 50.0;
/// The remedy, in words.
const REMEDY: &str = "some paths are met by few rounds; take more, or another method";

/// Figures that tell whether the bars of an image can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Trust {
    /// Share of the squared relative error, as estimated, that lies in the worst hundredth of the pixels; `None` without any, and with
    /// too few rounds.
    pub worst_pixels: Option<f64>,
    /// Largest share that one round has of the light in a part of the image; `None` with too few rounds.
    pub largest_round: Option<f64>,
    /// Independent samples of equal weight that chains start from; `None` without chains.
    pub starts: Option<f64>,
}

impl Trust {
    /// Of a render.
    pub fn new(film: &Film<3>, counts: &Counts, blocks: &Blocks, size: [u32; 2]) -> Self {
        let enough = film.rounds() >= TRUSTED_ROUNDS;
        Self {
            worst_pixels: enough.then(|| worst_pixels(film, size)).flatten(),
            largest_round: enough.then(|| blocks.largest_round()).flatten(),
            starts: starts(&counts.chains.strata),
        }
    }

    /// Why the bars are not to be trusted.
    pub fn doubts(&self) -> Vec<String> {
        let doubt = |figure: Option<f64>, doubtful: bool, reason: &dyn Fn(f64) -> String| {
            figure
                .filter(|_| doubtful)
                .map(|figure| format!("the error bars cannot be trusted: {}; {REMEDY}", reason(figure)))
        };
        let Self { worst_pixels, largest_round, starts } = *self;
        [
            doubt(worst_pixels, worst_pixels > Some(MOST_OF_WORST), &|share| {
                format!("one pixel in a hundred holds {:.0} % of the error", 100.0 * share)
            }),
            doubt(largest_round, largest_round > Some(MOST_OF_ROUND), &|share| {
                format!("one round brought {:.0} % of the light in a part of the image", 100.0 * share)
            }),
            doubt(starts, starts < Some(LEAST_STARTS), &|starts| {
                format!("the chains start from what {starts:.0} independent samples are worth")
            }),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// Share of Σ v/(l² + (l̄/10)²) in the worst hundredth of the pixels, v the variance of a pixel, l the luminance around it and l̄ the
/// image's: an edge of a lamp is noisy, but not for its brightness, and what few paths lit is not bright around.
fn worst_pixels(film: &Film<3>, size: [u32; 2]) -> Option<f64> {
    let pixels: Vec<_> = (0..film.sites() as usize).into_par_iter().map(|i| luminance_and_error(film, i)).collect();
    let floor = (0.1 * mean_luminance(film).mean).powi(2);
    let [width, height] = size.map(|n| n as usize);
    let around = |i: usize| {
        let side = |at: usize, n: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(n);
        let (columns, rows) = (side(i % width, width), side(i / width, height));
        let sum: f64 = rows.clone().flat_map(|row| &pixels[row * width..][columns.clone()]).map(|p| p.0).sum();
        sum / (rows.len() * columns.len()) as f64
    };
    let error = |i: usize| pixels[i].1.powi(2) / (around(i).powi(2) + floor);
    let mut errors: Vec<f64> = (0..pixels.len()).into_par_iter().map(error).collect();
    errors.sort_unstable_by(|a, b| b.total_cmp(a));
    let worst = (WORST * errors.len() as f64).ceil() as usize;
    let share = errors[..worst].iter().sum::<f64>() / errors.iter().sum::<f64>();
    share.is_finite().then_some(share)
}

/// (Σ b_j)²/Σ_j Σ w²/m_j², m_j samples of weights w having the mean b_j.
fn starts(strata: &[StratumStats]) -> Option<f64> {
    let b: f64 = strata.iter().map(StratumStats::b).sum();
    let squares = |s: &StratumStats| s.weight_squares.value() / (s.samples as f64).powi(2);
    let starts = b * b / strata.iter().filter(|s| s.samples > 0).map(squares).sum::<f64>();
    starts.is_finite().then_some(starts)
}

#[cfg(test)]
mod tests {
    use mlt_core::engine::{Sink, Splat};

    use super::*;

    const SIDE: u32 = 20;

    /// Eight rounds of a square image with `value(column, row, round)` in all channels.
    fn film(value: impl Fn(u32, u32, u32) -> f64) -> Film<3> {
        let mut film = Film::<3>::new(SIDE * SIDE, 1.0);
        for round in 0..8 {
            let mut deposits = film.deposits();
            for site in 0..SIDE * SIDE {
                deposits.deposit(Splat { site, value: [value(site % SIDE, site / SIDE, round); 3] }, 1.0);
            }
            film.add(&[deposits]);
            film.close_round(u64::from(round), 1);
        }
        film
    }

    fn worst(value: impl Fn(u32, u32, u32) -> f64) -> f64 {
        worst_pixels(&film(value), [SIDE; 2]).expect("noise")
    }

    #[test]
    fn a_pixel_that_one_round_lit_is_told_from_the_edge_of_a_lamp() {
        let noise = |_: u32, _: u32, round: u32| 0.9 + 0.2 * f64::from(round % 2);
        assert!((worst(noise) - 0.01).abs() < 1e-6);
        let firefly = |x, y, round| if (x, y, round) == (9, 9, 3) { 100.0 } else { noise(x, y, round) };
        assert!(worst(firefly) > MOST_OF_WORST);
        // Columns of a lamp, of which every other pixel of the first is hidden in half of the rounds.
        let lamp = |x: u32, y: u32, round| match x {
            ..15 => noise(x, y, round),
            15 if y.is_multiple_of(2) => 100.0 * f64::from(round % 2),
            _ => 100.0,
        };
        assert!(worst(lamp) < MOST_OF_WORST, "{}", worst(lamp));
        assert_eq!(worst_pixels(&film(|_, _, _| 0.0), [SIDE; 2]), None);
    }

    #[test]
    fn starts_are_samples_of_equal_weight() {
        let stratum = |n: u32, weight: f64| StratumStats {
            samples: 100,
            weight_sum: (f64::from(n) * weight).into(),
            weight_squares: (f64::from(n) * weight * weight).into(),
            ..StratumStats::default()
        };
        let of = |strata: &[StratumStats]| starts(strata).expect("samples").round();
        assert_eq!(of(&[stratum(40, 2.0)]), 40.0);
        assert_eq!(of(&[stratum(40, 2.0), stratum(40, 2.0)]), 80.0);
        // A dim stratum counts for little.
        assert_eq!(of(&[stratum(40, 2.0), stratum(1, 1e-3)]), 40.0);
        assert_eq!(starts(&[]), None);
    }

    #[test]
    fn doubts_name_their_figures() {
        let sound = Trust { worst_pixels: Some(0.3), largest_round: Some(0.2), starts: Some(900.0) };
        assert!(sound.doubts().is_empty() && Trust::default().doubts().is_empty());
        let doubts = Trust { worst_pixels: Some(0.93), largest_round: Some(0.5), starts: Some(12.0) }.doubts();
        assert_eq!(doubts.len(), 3);
        for (doubt, figure) in doubts.iter().zip(["93 %", "50 %", "what 12 independent samples"]) {
            assert!(doubt.contains(figure), "{doubt}");
        }
    }
}
