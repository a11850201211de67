//! How far an image is from its reference.
//!
//! a: luminance of the reference, b: luminance of the image, mean: over all pixels.

/// Below this luminance the reference no longer divides an error, so that black pixels do not decide a mean.
///
/// Used by [`Measures::relative_diff`] and [`Measures::mape`].
pub const DARKEST_REFERENCE: f64 = 1e-3;

/// Added to the squared reference in [`Measures::rel_mse`].
pub const REL_MSE_EPSILON: f64 = 1e-2;

/// Errors of one image against its reference; all without unit, all but [`mean_ratio`](Self::mean_ratio) best at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// mean (a − b)² / max(a, 10⁻³). Source: [Jankauski15], which has no floor.
    pub relative_diff: f64,
    /// mean (a − b)² / (a² + 10⁻²). Source: [RousselleKnausZwicker11].
    pub rel_mse: f64,
    /// mean |a − b| / max(a, 10⁻³), as a fraction: 0.05 is five per cent.
    pub mape: f64,
    /// mean b / mean a: 1 when the image is as bright as the reference. Not finite when the reference is black.
    pub mean_ratio: f64,
}

impl Measures {
    /// Compares two images given as luminances, pixel by pixel.
    ///
    /// `None` when the two differ in length or have no pixel. A pixel that is not finite makes the result not finite.
    pub fn between<T: Copy + Into<f64>>(reference: &[T], image: &[T]) -> Option<Self> {
        if reference.len() != image.len() || reference.is_empty() {
            return None;
        }
        let (mut relative_diff, mut rel_mse, mut mape) = (0.0, 0.0, 0.0);
        let (mut sum_a, mut sum_b) = (0.0, 0.0);
        for (&a, &b) in reference.iter().zip(image) {
            let (a, b): (f64, f64) = (a.into(), b.into());
            let squared = (a - b) * (a - b);
            relative_diff += squared / a.max(DARKEST_REFERENCE);
            rel_mse += squared / (a * a + REL_MSE_EPSILON);
            mape += (a - b).abs() / a.max(DARKEST_REFERENCE);
            sum_a += a;
            sum_b += b;
        }
        let pixels = reference.len() as f64;
        Some(Self {
            relative_diff: relative_diff / pixels,
            rel_mse: rel_mse / pixels,
            mape: mape / pixels,
            mean_ratio: sum_b / sum_a,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measures(reference: &[f64], image: &[f64]) -> Measures {
        Measures::between(reference, image).expect("same length, not empty")
    }

    #[test]
    fn equal_images_have_no_error() {
        let image = [0.0, 0.5, 2.0];
        let expected = Measures { relative_diff: 0.0, rel_mse: 0.0, mape: 0.0, mean_ratio: 1.0 };
        assert_eq!(measures(&image, &image), expected);
    }

    /// One pixel with a = 2, b = 3 and one with a = 1, b = 1: each measure worked out by hand.
    #[test]
    fn each_measure_matches_its_formula() {
        let found = measures(&[2.0, 1.0], &[3.0, 1.0]);
        assert_eq!(found.relative_diff, 0.5 / 2.0);
        assert_eq!(found.rel_mse, 1.0 / 4.01 / 2.0);
        assert_eq!(found.mape, 0.5 / 2.0);
        assert_eq!(found.mean_ratio, 4.0 / 3.0);
    }

    #[test]
    fn a_black_reference_pixel_is_floored() {
        let found = measures(&[0.0, 1.0], &[0.1, 1.0]);
        assert!((found.relative_diff - 0.01 / 1e-3 / 2.0).abs() < 1e-12);
        assert!((found.rel_mse - 0.01 / 1e-2 / 2.0).abs() < 1e-12);
        assert!((found.mape - 0.1 / 1e-3 / 2.0).abs() < 1e-12);
    }

    #[test]
    fn single_and_double_precision_agree() {
        let found = Measures::between(&[0.5_f32, 1.0], &[0.25, 1.0]);
        assert_eq!(found, Some(measures(&[0.5, 1.0], &[0.25, 1.0])));
    }

    #[test]
    fn sizes_that_differ_and_empty_images_have_no_measure() {
        assert_eq!(Measures::between(&[1.0, 2.0], &[1.0]), None);
        assert_eq!(Measures::between::<f64>(&[], &[]), None);
    }

    #[test]
    fn a_pixel_that_is_not_a_number_shows() {
        assert!(measures(&[f64::NAN, 1.0], &[1.0, 1.0]).rel_mse.is_nan());
        assert!(measures(&[1.0, 1.0], &[1.0, f64::NAN]).mape.is_nan());
    }
}
