//! Pixels of files that the image crate decodes.

use ::image::{DynamicImage, ImageDecoder, Limits};

use super::{MAX_SIDE, check_size};
use crate::image::Image;

/// Most memory for what a file holds besides its pixels: whatever that says, a few bytes can ask for gigabytes. Larger profiles are
/// skipped, as none is used. The pixels' own memory is checked against what the machine has.
pub(super) const MOST_BESIDES: u64 = 4 << 20;

/// What a decoder may take.
pub(super) fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    limits.max_alloc = Some(MOST_BESIDES);
    limits
}

/// Numbers of all pixels as the file has them, integers scaled to 0…1; alpha is left out.
pub(super) fn pixels(decoder: impl ImageDecoder) -> anyhow::Result<Image> {
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    // As decoded (12 bytes at most), as float, as image.
    check_size(width, height, 12 + 12 + 12)?;
    let pixels = DynamicImage::from_decoder(decoder)?.into_rgb32f();
    Image::new(width, height, pixels.pixels().map(|pixel| pixel.0).collect())
}

/// The image with every number changed.
pub(super) fn mapped(mut image: Image, by: impl Fn(f32) -> f32) -> Image {
    image.rgb.as_flattened_mut().iter_mut().for_each(|value| *value = by(*value));
    image
}
