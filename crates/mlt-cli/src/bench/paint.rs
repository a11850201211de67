//! Images for the page.

use base64::{Engine, prelude::BASE64_STANDARD};
use mlt_core::measure::REL_MSE_EPSILON;

use super::subject::Reference;
use crate::{
    image::Image,
    output::{png, srgb},
};

/// Colours of an error map from none to [`LARGEST`]: dark to light at an even rate, so that it reads in grey as well.
const MAP: [[f32; 3]; 6] = [
    [0.04, 0.05, 0.16],
    [0.18, 0.17, 0.48],
    [0.35, 0.36, 0.68],
    [0.78, 0.45, 0.42],
    [0.96, 0.70, 0.30],
    [1.00, 0.98, 0.80],
];

/// The error at the end of the map's colours.
pub(super) const LARGEST: f64 = 0.5;

/// An image as `data:` address of a PNG. `exposure` in stops.
pub(super) fn data_uri(image: &Image, exposure: f64) -> anyhow::Result<String> {
    Ok(format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png::encode(image, exposure, &[])?)))
}

/// |a − b| / √(a² + 10⁻²) of the luminances, the root of a pixel's part of relMSE, in false colour.
pub(super) fn error_map(reference: &Reference, image: &Image) -> anyhow::Result<Image> {
    let colour = |(&a, b): (&f32, f32)| {
        let (a, b) = (f64::from(a), f64::from(b));
        map((a - b).abs() / (a * a + REL_MSE_EPSILON).sqrt() / LARGEST).map(srgb::linear_from_srgb)
    };
    let rgb = reference.luminance.iter().zip(image.luminance()).map(colour).collect();
    Image::new(image.width, image.height, rgb)
}

/// The map's colours as CSS, from left to right.
pub(super) fn map_css() -> String {
    let stop = |colour: &[f32; 3]| {
        let [r, g, b] = colour.map(|value| (value * 255.0).round());
        format!("rgb({r} {g} {b})")
    };
    MAP.iter().map(stop).collect::<Vec<_>>().join(", ")
}

/// sRGB colour of 0 (none) to 1 (the largest, and beyond).
fn map(share: f64) -> [f32; 3] {
    let at = share.clamp(0.0, 1.0) as f32 * (MAP.len() - 1) as f32;
    let cell = (at as usize).min(MAP.len() - 2);
    let inside = at - cell as f32;
    std::array::from_fn(|c| MAP[cell][c] + inside * (MAP[cell + 1][c] - MAP[cell][c]))
}

#[cfg(test)]
mod tests {
    use mlt_core::transport::{Rgb, luminance};

    use super::*;

    #[test]
    fn the_map_grows_lighter_throughout() {
        let lightness: Vec<f32> = (0..=50)
            .map(|i| luminance(Rgb::from_array(map(f64::from(i) / 50.0).map(srgb::linear_from_srgb))))
            .collect();
        assert!(lightness.windows(2).all(|pair| pair[0] < pair[1]), "{lightness:?}");
        assert_eq!((map(0.0), map(7.0), map(-1.0)), (MAP[0], MAP[5], MAP[0]));
    }

    #[test]
    fn a_data_uri_holds_a_png() {
        let image = Image::new(1, 1, vec![[1.0; 3]]).expect("one pixel");
        // The first six bytes of a PNG file fill eight letters.
        assert!(data_uri(&image, 0.0).expect("encoded").starts_with("data:image/png;base64,iVBORw0K"));
    }
}
