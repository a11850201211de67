//! PNG: 8 bits a channel, sRGB.

use std::{fs::File, io::BufReader, path::Path};

use ::image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits,
    codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder},
};
use anyhow::Context;

use super::{MAX_SIDE, check_size};
use crate::image::Image;

/// The first bytes of every PNG file.
pub const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Most memory for what a file holds besides its pixels: whatever that says, a few bytes can ask for gigabytes. Larger profiles are
/// skipped, as none is used. The pixels' own memory is checked against what the machine has.
const MOST_BESIDES: u64 = 4 << 20;

/// The file's bytes: pixels times 2^`exposure`, clipped to 0…1, by the sRGB curve; NaN becomes black.
///
/// `exposure`: in stops (EV). Same image, same bytes.
pub fn encode(image: &Image, exposure: f64) -> anyhow::Result<Vec<u8>> {
    let scale = exposure.exp2();
    let bytes: Vec<u8> =
        image.rgb.as_flattened().iter().map(|&value| to_byte(encoded(f64::from(value) * scale))).collect();
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Default, FilterType::Adaptive).write_image(
        &bytes,
        u32::try_from(image.width)?,
        u32::try_from(image.height)?,
        ExtendedColorType::Rgb8,
    )?;
    Ok(file)
}

/// Reads a PNG file of any kind as linear Rec. 709 in 0…1; alpha is left out.
pub fn read(path: &Path) -> anyhow::Result<Image> {
    decode(path).with_context(|| format!("{}: cannot be read as PNG", path.display()))
}

fn decode(path: &Path) -> anyhow::Result<Image> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    limits.max_alloc = Some(MOST_BESIDES);
    let decoder = PngDecoder::with_limits(BufReader::new(File::open(path)?), limits)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    // As decoded (8 bytes at most), as float, as image.
    check_size(width, height, 8 + 12 + 12)?;
    let pixels = DynamicImage::from_decoder(decoder)?.into_rgb32f();
    Image::new(width, height, pixels.pixels().map(|pixel| pixel.0.map(linear_from_srgb)).collect())
}

fn encoded(linear: f64) -> f64 {
    match linear {
        x if x <= 0.0 || x.is_nan() => 0.0,
        x if x <= 0.003_130_8 => 12.92 * x,
        x if x < 1.0 => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        _ => 1.0,
    }
}

/// [`srgb_from_linear`]'s inverse on 0…1.
pub(crate) fn linear_from_srgb(encoded: f32) -> f32 {
    let encoded = f64::from(encoded);
    let linear = if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// sRGB's transfer function, IEC 61966-2-1; clips to 0…1, NaN becomes 0.
pub(crate) fn srgb_from_linear(linear: f32) -> f32 {
    encoded(f64::from(linear)) as f32
}

fn to_byte(encoded: f64) -> u8 {
    (encoded * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of IEC 61966-2-1: middle grey 0.2140 is byte 127 or 128, the linear part has slope 12.92.
    #[test]
    fn the_curve_is_srgb() {
        assert!((encoded(0.214_041_14) - 0.5).abs() < 1e-6);
        assert!((encoded(0.001) - 0.01292).abs() < 1e-12);
        assert_eq!([f64::NAN, -1.0, 0.0].map(encoded), [0.0; 3]);
        assert_eq!([1.0, 7.0, f64::INFINITY].map(encoded), [1.0; 3]);
    }

    #[test]
    fn every_byte_survives_the_curve_both_ways() {
        for byte in 0..=255_u8 {
            assert_eq!(to_byte(encoded(f64::from(linear_from_srgb(f32::from(byte) / 255.0)))), byte);
        }
    }

    #[test]
    fn a_written_image_is_read_back_exposed_and_clipped() {
        let image = Image::new(2, 1, vec![[0.25, f32::NAN, -3.0], [0.5, 4.0, f32::INFINITY]]).expect("two pixels");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        std::fs::write(&path, encode(&image, 1.0).expect("encoded")).expect("written");
        let found = read(&path).expect("read");
        assert!((found.rgb[0][0] - 0.5).abs() < 0.005, "{:?}", found.rgb);
        assert_eq!(found.rgb[0][1..], [0.0, 0.0]);
        assert_eq!(found.rgb[1], [1.0, 1.0, 1.0]);
    }

    #[test]
    fn grey_and_sixteen_bit_files_are_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        ::image::ImageBuffer::from_pixel(1, 1, ::image::Luma([u16::MAX])).save(&path).expect("written");
        assert_eq!(read(&path).expect("read").rgb, [[1.0; 3]]);
    }
}
