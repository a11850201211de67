//! Whether a picture can be looked at as it is exposed.

use mlt_core::transport::{Rgb, luminance};

use crate::image::Image;

/// Luminance that a PNG shows as nearly black, and as white.
const RANGE: [f64; 2] = [0.01, 1.0];
/// Share of the pixels beyond that which is too much: nearly all may be dark, but not white.
const MOST: [f64; 2] = [0.99, 0.6];
/// Mean luminance of a picture that is well exposed.
const MIDDLE: f64 = 0.18;

/// A warning where a picture exposed by `stops` is nearly black or nearly white, with the exposure that shows it: the one that brings
/// the mean luminance to 0.18, in half stops.
pub(super) fn advice(image: &Image, stops: f64) -> Option<String> {
    let pixels = image.rgb.len() as f64;
    let luminances = || image.rgb.iter().map(|&pixel| f64::from(luminance(Rgb::from_array(pixel))));
    let mean = luminances().sum::<f64>() / pixels;
    let share = |is: &dyn Fn(f64) -> bool| luminances().filter(|l| is(l * stops.exp2())).count() as f64 / pixels;
    let [dark, white] = [share(&|l| l < RANGE[0]), share(&|l| l > RANGE[1])];
    let word = match (dark > MOST[0], white > MOST[1]) {
        (true, _) => "black",
        (_, true) => "white",
        _ => return None,
    };
    // A black image has a warning of its own.
    let better = (2.0 * (MIDDLE / mean).log2()).round() / 2.0;
    (mean > 0.0 && mean.is_finite() && better != stops).then(|| {
        format!(
            "the picture is nearly {word} at an exposure of {stops}; --exposure {better} shows more (an EXR holds all)"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(values: [f32; 4]) -> Image {
        Image::new(2, 2, values.map(|value| [value; 3]).to_vec()).expect("an image")
    }

    #[test]
    fn pictures_that_show_nothing_are_told() {
        assert_eq!(advice(&image([0.1, 0.2, 0.3, 5.0]), 0.0), None);
        let dark = advice(&image([0.001; 4]), 0.0).expect("dark");
        assert!(dark.contains("nearly black") && dark.contains("--exposure 7.5 shows"), "{dark}");
        assert_eq!(advice(&image([0.001; 4]), 7.5), None);
        let bright = advice(&image([9.0, 9.0, 9.0, 0.0]), 0.0).expect("white");
        assert!(bright.contains("nearly white") && bright.contains("--exposure -5 shows"), "{bright}");
        assert_eq!(advice(&image([0.0; 4]), 0.0), None);
    }
}
