//! The importance that chains sample in proportion to.

use super::blur::blurred;
use crate::engine::{DecodeError, Importance, Reader, put, put_list};
use crate::transport::paths::{LightPath, Luminance};

/// Which scalar I is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Target {
    /// Luminance of f(x).
    #[default]
    Luminance,
    /// Luminance of f(x) over a smooth estimate of the image's luminance where x arrives.
    Relative,
}

/// I(x) = luminance of f(x) · w(pixel of x).
#[derive(Clone, Debug, Default)]
pub struct PixelImportance {
    /// One weight a pixel; empty: all are 1.
    weights: Vec<f64>,
}

/// The darkest luminance that is told from black, as a share of the image's mean.
const DARKEST: f64 = 0.02;
/// Side of the squares over which the image is smoothed, as a share of the image's.
const SMOOTHING: f64 = 1.0 / 16.0;

impl PixelImportance {
    /// w = 1/(smooth image + ε): every part of the image gets as many visits as any other, and the relative error is even.
    ///
    /// Source: [HoberockHart10].
    pub(crate) fn relative(image: &[f64], size: [u32; 2]) -> Self {
        let darkest = DARKEST * image.iter().sum::<f64>() / image.len() as f64;
        if darkest <= 0.0 {
            return Self::default();
        }
        let weights = smooth(image, size).into_iter().map(|level| 1.0 / (level + darkest)).collect();
        Self { weights }
    }
}

impl PixelImportance {
    /// Appends it to bytes.
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        put_list(to, &self.weights, |to, w| put(to, w.to_bits()));
    }

    /// Reads what [`write`](Self::write) has written for an image of so many pixels.
    pub(crate) fn read(pixels: u32, from: &mut Reader) -> Result<Self, DecodeError> {
        let weights = from.list(|from| from.number().map(f64::from_bits))?;
        let sound = weights.is_empty() || weights.len() == pixels as usize;
        match sound && weights.iter().all(|w| w.is_finite() && *w > 0.0) {
            true => Ok(Self { weights }),
            false => Err(DecodeError::Damaged),
        }
    }
}

/// The image without the noise of short renders.
pub(crate) fn smooth(image: &[f64], size: [u32; 2]) -> Vec<f64> {
    let side = f64::from(size[0].min(size[1]));
    blurred(image, size, (0.5 * SMOOTHING * side).ceil() as usize)
}

impl Importance<LightPath> for PixelImportance {
    #[inline]
    fn eval(&self, path: &LightPath) -> f64 {
        let luminance = Luminance.eval(path);
        if self.weights.is_empty() { luminance } else { luminance * self.weights[path.pixel as usize] }
    }
}
