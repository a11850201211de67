//! Weights of the squares of an image's errors.

use super::importance::smooth;

/// Weights of the error's squares: 1/(a² + (mean/10)²), a the image without its noise. It is relMSE, in units of the
/// image's mean.
pub(crate) fn error_weights(image: &[f64], size: [u32; 2]) -> Vec<f64> {
    let mean = image.iter().sum::<f64>() / image.len() as f64;
    let floor = (0.1 * mean).powi(2);
    let weight = |a: f64| if floor > 0.0 { 1.0 / (a * a + floor) } else { 0.0 };
    smooth(image, size).into_iter().map(weight).collect()
}
