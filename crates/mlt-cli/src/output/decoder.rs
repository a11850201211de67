//! Pixels of files that the image crate decodes.

use ::image::{DynamicImage, ImageDecoder};

use super::check_size;
use crate::image::Image;

/// Numbers of all pixels as the file has them, integers scaled to 0…1; alpha is left out.
pub(super) fn pixels(decoder: impl ImageDecoder) -> anyhow::Result<Image> {
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    // As decoded (12 bytes at most), as float, as image.
    check_size(width, height, 12 + 12 + 12)?;
    let pixels = DynamicImage::from_decoder(decoder)?.into_rgb32f();
    Image::new(width, height, pixels.pixels().map(|pixel| pixel.0).collect())
}
