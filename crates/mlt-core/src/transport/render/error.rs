//! The image's estimated error.

use super::super::blur::blurred;
use crate::engine::{self, Film};
use rayon::prelude::*;

/// Half the sides of the squares around a pixel that no round has lit, until one of them has light.
const RADII: [usize; 4] = [1, 2, 4, 8];

/// Luminance of a pixel's mean, and a bound on its standard error: Σ weight × error of the channels, which is exact where
/// their errors are fully correlated.
pub fn luminance_and_error(film: &Film<3>, pixel: usize) -> (f64, f64) {
    let weights = [0.2126, 0.7152, 0.0722];
    let channels = film.pixel(pixel);
    let sum = |f: fn(&engine::Pixel) -> f64| channels.iter().zip(weights).map(|(c, w)| w * f(c)).sum();
    (sum(|c| c.mean), sum(|c| c.stderr))
}

/// Pixels whose squares one thread sums.
const PIXELS_A_SUM: u32 = 1 << 10;

/// Estimated relative error of the image, √(Σ stderr² / Σ luminance²) over pixels; infinite before the second round and
/// for a black image.
pub fn relative_error(film: &Film<3>) -> f64 {
    let sums = |first: u32| {
        let (mut errors, mut squares) = (0.0, 0.0);
        for pixel in first..film.sites().min(first + PIXELS_A_SUM) {
            let (luminance, error) = luminance_and_error(film, pixel as usize);
            errors += error * error;
            squares += luminance * luminance;
        }
        [errors, squares]
    };
    let parts = film.sites().div_ceil(PIXELS_A_SUM);
    let parts: Vec<_> = (0..parts).into_par_iter().map(|part| sums(part * PIXELS_A_SUM)).collect();
    let [errors, squares] = [0, 1].map(|i| parts.iter().map(|part: &[f64; 2]| part[i]).sum::<f64>());
    if squares > 0.0 { (errors / squares).sqrt() } else { f64::INFINITY }
}

/// Standard errors of all pixels of an image of this size, row by row and channel by channel.
///
/// The spread of rounds that all found nothing is 0, which is no bar at all. Such a pixel takes the root of the mean square of
/// the errors around it, in the smallest square of 3, 5, 9 or 17 pixels a side that has light.
pub fn standard_errors(film: &Film<3>, size: [u32; 2]) -> Vec<[f64; 3]> {
    let pixel = |i: usize| {
        let channels = film.pixel(i);
        (channels.map(|c| c.stderr), channels.iter().all(|c| c.mean == 0.0))
    };
    let (mut errors, dark): (Vec<_>, Vec<_>) = (0..film.sites() as usize).into_par_iter().map(pixel).unzip();
    let mut unlit: Vec<usize> = (0..dark.len()).filter(|&i| dark[i]).collect();
    if unlit.is_empty() {
        return errors;
    }
    let square = |x: f64| if x.is_finite() { x * x } else { 0.0 };
    let squares = [0, 1, 2].map(|c| errors.iter().map(|e| square(e[c])).collect::<Vec<_>>());
    for radius in RADII {
        for (channel, squares) in squares.iter().enumerate() {
            let around = blurred(squares, size, radius);
            unlit.iter().for_each(|&i| errors[i][channel] = around[i].max(0.0).sqrt());
        }
        unlit.retain(|&i| errors[i] == [0.0; 3]);
        if unlit.is_empty() {
            break;
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Sink, Splat};

    #[test]
    fn a_pixel_without_light_takes_the_errors_around_it() {
        let mut film = Film::<3>::new(40, 1.0);
        for round in 0..4 {
            let mut deposits = film.deposits();
            (0..2).for_each(|site| deposits.deposit(Splat { site, value: [1.0, f64::from(round % 2), 0.0] }, 1.0));
            film.add(&[deposits]);
            film.close_round(1);
        }
        let errors = standard_errors(&film, [40, 1]);
        let lit = film.pixel(1)[1].stderr;
        assert!(lit > 0.0 && errors[1] == [0.0, lit, 0.0]);
        // Of three pixels one is lit; of five, one; of nine, two.
        assert!((errors[2][1] - lit * (1f64 / 3.0).sqrt()).abs() < 1e-9, "{errors:?}");
        assert!((errors[3][1] - lit * (1f64 / 5.0).sqrt()).abs() < 1e-9, "{errors:?}");
        assert!(errors[9][1] > 0.0 && errors[10] == [0.0; 3], "{errors:?}");
    }
}
