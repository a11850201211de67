//! Luminance of a film's pixels, and its errors.

use crate::engine::{Film, Pixel};
use crate::transport::colour::LUMINANCE;

/// Luminance of a pixel's mean, and a bound on its standard error: Σ weight × error of the channels, which is exact where
/// their errors are fully correlated.
pub fn luminance_and_error(film: &Film<3>, pixel: usize) -> (f64, f64) {
    let Pixel { mean, stderr } = film.weighted(pixel, LUMINANCE);
    (mean, stderr)
}

/// Mean luminance of the image.
pub fn mean_luminance(film: &Film<3>) -> Pixel {
    film.whole(LUMINANCE)
}

/// Estimated relative error of the image's luminance; see [`Film::relative_error`].
pub fn relative_error(film: &Film<3>) -> f64 {
    film.relative_error(LUMINANCE)
}
