//! Signs that an image's error bars say too little: light that few samples or few rounds have met.

use mlt_core::engine::{Film, StratumStats, TRUSTED_ROUNDS};
use mlt_core::transport::image::{luminance_and_error, mean_luminance};
use mlt_core::transport::render::Counts;
use rayon::prelude::*;

use super::blocks::Blocks;
use crate::report::Trust;

/// Share of the pixels that are the worst.
const WORST: f64 = 0.01;
/// Half the side of the square that is around a pixel.
const AROUND: usize = 2;

/// The figures of a render.
pub(super) fn trust(film: &Film<3>, counts: &Counts, blocks: &Blocks, size: [u32; 2]) -> Trust {
    let (enough, b) = (film.rounds() >= TRUSTED_ROUNDS, mean_luminance(film));
    Trust {
        worst_pixels: enough.then(|| worst_pixels(film, size)).flatten(),
        largest_round: enough.then(|| blocks.largest_round()).flatten(),
        starts: starts(&counts.chains().strata),
        unmet_light: unmet_light(counts, b.mean),
        b_error: Some(b.stderr / b.mean).filter(|error| error.is_finite()),
    }
}

/// Share of Σ v/(l² + (l̄/10)²) in the worst hundredth of the pixels: v is a pixel's variance, l the luminance around it, l̄ the image's.
///
/// The luminance around a pixel tells two kinds of noise apart. The edge of a lamp is noisy and bright around; a pixel that few paths lit
/// is noisy and dark around.
fn worst_pixels(film: &Film<3>, size: [u32; 2]) -> Option<f64> {
    let luminance = |i| luminance_and_error(film, i).0 as f32;
    let luminance: Vec<_> = (0..film.sites() as usize).into_par_iter().map(luminance).collect();
    let floor = (0.1 * mean_luminance(film).mean).powi(2);
    let [width, height] = size.map(|n| n as usize);
    let around = |i: usize| {
        let side = |at: usize, n: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(n);
        let (columns, rows) = (side(i % width, width), side(i / width, height));
        let sum: f64 =
            rows.clone().flat_map(|row| &luminance[row * width..][columns.clone()]).map(|&l| f64::from(l)).sum();
        sum / (rows.len() * columns.len()) as f64
    };
    let error = |i: usize| (luminance_and_error(film, i).1.powi(2) / (around(i).powi(2) + floor)) as f32;
    let mut errors: Vec<f32> = (0..luminance.len()).into_par_iter().map(error).collect();
    errors.sort_unstable_by(|a, b| b.total_cmp(a));
    let worst = (WORST * errors.len() as f64).ceil() as usize;
    let sum = |errors: &[f32]| errors.iter().map(|&error| f64::from(error)).sum::<f64>();
    let share = sum(&errors[..worst]) / sum(&errors);
    share.is_finite().then_some(share)
}

/// Σ_j b_j u_j over all light, u_j being the share of a stratum that samples were to meet fewer than ten times. Without samples of the
/// image all light is that of the chains; with them it is `b`, and chains sample luminance.
fn unmet_light(counts: &Counts, b: f64) -> Option<f64> {
    let sum = |value: fn(&StratumStats) -> f64| counts.chains().strata.iter().map(value).sum::<f64>();
    let chains = sum(StratumStats::b);
    let all = if counts.samples() == 0 { chains } else { chains.max(b) };
    (all > 0.0 && counts.steps() > 0).then(|| sum(|s| s.b() * s.rarity.unmet(s.weight_sum.value())) / all)
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
    use mlt_core::engine::{Sink, Splat, Tally};
    use mlt_core::transport::methods::SampleTally;

    use super::*;

    const SIDE: u32 = 20;

    /// A hundred samples, `n` of which have this weight and all others 0.
    fn stratum(n: u32, weight: f64) -> StratumStats {
        StratumStats {
            samples: 100,
            weight_sum: (f64::from(n) * weight).into(),
            weight_squares: (f64::from(n) * weight * weight).into(),
            ..StratumStats::default()
        }
    }

    /// Eight rounds of a square image with `value(column, row, round)` in all channels.
    fn film(value: impl Fn(u32, u32, u32) -> f64) -> Film<3> {
        let mut film = Film::<3>::new(SIDE * SIDE, 1.0);
        for round in 0..8 {
            let mut deposits = film.deposits();
            for site in 0..SIDE * SIDE {
                deposits.deposit(Splat { site, value: [value(site % SIDE, site / SIDE, round); 3] }, 1.0);
            }
            film.add(&mut [deposits]);
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
        assert!(worst(firefly) > Trust::MOST_OF_WORST);
        // Columns of a lamp, of which every other pixel of the first is hidden in half of the rounds.
        let lamp = |x: u32, y: u32, round| match x {
            ..15 => noise(x, y, round),
            15 if y.is_multiple_of(2) => 100.0 * f64::from(round % 2),
            _ => 100.0,
        };
        assert!(worst(lamp) < Trust::MOST_OF_WORST, "{}", worst(lamp));
        assert_eq!(worst_pixels(&film(|_, _, _| 0.0), [SIDE; 2]), None);
    }

    #[test]
    fn unmet_light_is_a_share_of_all_light() {
        // Half of a stratum's energy is worth 1/8 to a sample, half 256: the 40 samples of weight 2 meet that 0.16 times.
        let mut chains = stratum(40, 2.0);
        (0..8).for_each(|i| chains.rarity.add([0.125, 256.0][i % 2], 1.0, 1.0));
        let chains = Tally { strata: vec![StratumStats { idle: 1, ..chains }, stratum(40, 2.0)], ..Tally::default() };
        let of = |samples| Counts::new(SampleTally { samples, rays: 0 }, chains.clone());
        assert_eq!([0, 1].map(|samples| unmet_light(&of(samples), 8.0)), [Some(0.25), Some(0.05)]);
        assert_eq!(unmet_light(&Counts::default(), 8.0), None);
    }

    #[test]
    fn starts_are_samples_of_equal_weight() {
        let of = |strata: &[StratumStats]| starts(strata).expect("samples").round();
        assert_eq!(of(&[stratum(40, 2.0)]), 40.0);
        assert_eq!(of(&[stratum(40, 2.0), stratum(40, 2.0)]), 80.0);
        // A dim stratum counts for little.
        assert_eq!(of(&[stratum(40, 2.0), stratum(1, 1e-3)]), 40.0);
        assert_eq!(starts(&[]), None);
    }
}
