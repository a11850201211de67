//! The image's estimated error.

use crate::engine::{self, Film};

/// Luminance of a pixel's mean, and a bound on its standard error: Σ weight × error of the channels, which is exact where
/// their errors are fully correlated.
pub fn luminance_and_error(film: &Film<3>, pixel: usize) -> (f64, f64) {
    let weights = [0.2126, 0.7152, 0.0722];
    let channels = film.pixel(pixel);
    let sum = |f: fn(&engine::Pixel) -> f64| channels.iter().zip(weights).map(|(c, w)| w * f(c)).sum();
    (sum(|c| c.mean), sum(|c| c.stderr))
}

/// Estimated relative error of the image, √(Σ stderr² / Σ luminance²) over pixels; infinite before the second round and
/// for a black image.
pub fn relative_error(film: &Film<3>) -> f64 {
    let (mut errors, mut squares) = (0.0, 0.0);
    for (luminance, error) in (0..film.sites() as usize).map(|i| luminance_and_error(film, i)) {
        errors += error * error;
        squares += luminance * luminance;
    }
    if squares > 0.0 { (errors / squares).sqrt() } else { f64::INFINITY }
}
