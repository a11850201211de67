//! An image in memory.

use anyhow::{Context, bail};
use mlt_core::transport::{Rgb, luminance};

/// Linear Rec. 709 pixels, rows from the top, pixels from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width · height` pixels; radiance in W·sr⁻¹·m⁻² when rendered.
    pub rgb: Vec<[f32; 3]>,
}

impl Image {
    /// An image from its pixels; an error when their number is not `width · height` or that is zero.
    pub fn new(width: usize, height: usize, rgb: Vec<[f32; 3]>) -> anyhow::Result<Self> {
        let pixels = width.checked_mul(height).context("the image is too large")?;
        if pixels == 0 || pixels != rgb.len() {
            bail!("{} pixels do not make an image of {width}x{height}", rgb.len());
        }
        Ok(Self { width, height, rgb })
    }

    /// Luminance of each pixel (ITU-R BT.709).
    pub fn luminance(&self) -> Vec<f32> {
        self.rgb.iter().map(|&pixel| luminance(Rgb::from_array(pixel))).collect()
    }

    /// Column and row of the first pixel with a value that is NaN or infinite.
    pub fn first_non_finite(&self) -> Option<(usize, usize)> {
        let index = self.rgb.iter().position(|pixel| pixel.iter().any(|value| !value.is_finite()))?;
        Some((index % self.width, index / self.width))
    }

    /// True when both images have the same size and the same bits in every value.
    pub fn same_bits(&self, other: &Self) -> bool {
        (self.width, self.height) == (other.width, other.height) && bits(self).eq(bits(other))
    }
}

fn bits(image: &Image) -> impl Iterator<Item = u32> {
    image.rgb.as_flattened().iter().map(|value| value.to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_pixels_has_to_fit() {
        assert!(Image::new(2, 1, vec![[0.0; 3]; 2]).is_ok());
        assert!(Image::new(2, 2, vec![[0.0; 3]; 2]).is_err());
        assert!(Image::new(0, 0, vec![]).is_err());
        assert!(Image::new(usize::MAX, 2, vec![]).is_err());
    }

    #[test]
    fn equality_of_bits_tells_zeros_apart() {
        let image = |value| Image::new(1, 1, vec![[value; 3]]).expect("one pixel");
        assert!(image(0.0).same_bits(&image(0.0)));
        assert!(!image(0.0).same_bits(&image(-0.0)));
        assert!(image(f32::NAN).same_bits(&image(f32::NAN)));
    }

    #[test]
    fn the_first_bad_pixel_is_found() {
        let mut image = Image::new(3, 2, vec![[1.0; 3]; 6]).expect("six pixels");
        assert_eq!(image.first_non_finite(), None);
        image.rgb[4][2] = f32::INFINITY;
        assert_eq!(image.first_non_finite(), Some((1, 1)));
    }
}
