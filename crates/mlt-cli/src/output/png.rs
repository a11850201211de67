//! PNG: 8 bits a channel, sRGB, with how the image was made.

use std::{
    fs::File,
    io::{BufReader, BufWriter, Write},
    path::Path,
};

use ::png::{
    BitDepth, ColorType, Decoder, Encoder, Limits, OutputInfo, ScaledFloat, SourceChromaticities, SrgbRenderingIntent,
    Transformations,
};
use anyhow::Context;

use super::{Attributes, SizeAndAttributes, check_size, srgb};
use crate::image::Image;

/// 1/2.2 in parts of 10⁻⁵, and x and y of white, red, green and blue: what the PNG specification (section 11.3.2.5) has beside the
/// chunk sRGB for readers that do not know it.
const GAMMA: u32 = 45_455;
const CHROMATICITIES: [(f32, f32); 4] = [(0.3127, 0.329), (0.64, 0.33), (0.3, 0.6), (0.15, 0.06)];

/// Most memory for what a file holds besides its pixels: whatever that says, a few bytes can ask for gigabytes. The pixels' own memory is
/// checked against what the machine has.
const MOST_BESIDES: usize = 4 << 20;

/// The first bytes of every PNG file.
pub const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// The file's bytes: pixels times 2^`exposure`, clipped to 0…1, by the sRGB curve; NaN becomes black. The chunk sRGB says so, gAMA
/// and cHRM say it to older readers, and each attribute is a chunk iTXt.
///
/// `exposure`: in stops (EV). Same image, same bytes.
pub fn encode(image: &Image, exposure: f64, attributes: &Attributes) -> anyhow::Result<Vec<u8>> {
    let mut file = Vec::new();
    write(image, exposure, attributes, &mut file)?;
    Ok(file)
}

/// Writes the same, a row at a time.
pub(super) fn write(image: &Image, exposure: f64, attributes: &Attributes, to: impl Write) -> anyhow::Result<()> {
    let mut encoder = Encoder::new(BufWriter::new(to), u32::try_from(image.width)?, u32::try_from(image.height)?);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_source_gamma(ScaledFloat::from_scaled(GAMMA));
    let [white, red, green, blue] = CHROMATICITIES;
    encoder.set_source_chromaticities(SourceChromaticities::new(white, red, green, blue));
    for (name, value) in attributes {
        encoder.add_itxt_chunk(name.clone(), value.clone())?;
    }
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer()?;
    image.rgb.chunks(image.width).try_for_each(|row| rows.write_all(&srgb::bytes(row, exposure)))?;
    rows.finish()?;
    Ok(writer.finish()?)
}

/// Reads a PNG file of any kind as linear Rec. 709 in 0…1; alpha is left out.
pub fn read(path: &Path) -> anyhow::Result<Image> {
    decode(path).with_context(|| format!("{}: cannot be read as PNG", path.display()))
}

fn decode(path: &Path) -> anyhow::Result<Image> {
    let mut decoder = decoder(path)?;
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info()?;
    let (width, height) = reader.info().size();
    let (width, height) = (width as usize, height as usize);
    // As decoded (8 bytes at most), as float.
    check_size(width, height, 8 + 12)?;
    let mut bytes = vec![0; reader.output_buffer_size().context("the image is too large")?];
    let OutputInfo { color_type, bit_depth, .. } = reader.next_frame(&mut bytes)?;
    let sample = |bytes: &[u8]| match *bytes {
        [high, low] => f32::from(u16::from_be_bytes([high, low])) / f32::from(u16::MAX),
        _ => f32::from(bytes[0]) / f32::from(u8::MAX),
    };
    let (size, samples) = (if bit_depth == BitDepth::Sixteen { 2 } else { 1 }, color_type.samples());
    let grey = samples < 3;
    let channel = |pixel: &[u8], i: usize| sample(&pixel[if grey { 0 } else { i * size }..][..size]);
    let pixel = |pixel: &[u8]| [0, 1, 2].map(|i| srgb::linear_from_srgb(channel(pixel, i)));
    Image::new(width, height, bytes.chunks_exact(size * samples).map(pixel).collect())
}

/// A decoder that skips colour profiles, as none is used.
fn decoder(path: &Path) -> anyhow::Result<Decoder<BufReader<File>>> {
    let limits = Limits { bytes: MOST_BESIDES };
    let mut decoder = Decoder::new_with_limits(BufReader::new(File::open(path)?), limits);
    decoder.set_ignore_iccp_chunk(true);
    Ok(decoder)
}

/// Width and height, and what [`encode`] was told of the image.
pub(super) fn attributes(path: &Path) -> anyhow::Result<SizeAndAttributes> {
    let reader = decoder(path)?.read_info()?;
    let info = reader.info();
    let texts = info.utf8_text.iter().map(|chunk| Ok((chunk.keyword.clone(), chunk.get_text()?)));
    Ok(([info.width, info.height].map(|side| side as usize), texts.collect::<anyhow::Result<_>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_image_is_read_back_exposed_and_clipped() {
        let image = Image::new(2, 1, vec![[0.25, f32::NAN, -3.0], [0.5, 4.0, f32::INFINITY]]).expect("two pixels");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        std::fs::write(&path, encode(&image, 1.0, &[]).expect("encoded")).expect("written");
        let found = read(&path).expect("read");
        assert!((found.rgb[0][0] - 0.5).abs() < 0.005, "{:?}", found.rgb);
        assert_eq!(found.rgb[0][1..], [0.0, 0.0]);
        assert_eq!(found.rgb[1], [1.0, 1.0, 1.0]);
    }

    /// Chunks come in the order that the format asks for: colour before pixels.
    #[test]
    fn the_file_says_that_it_is_srgb() {
        let image = Image::new(1, 1, vec![[0.5; 3]]).expect("a pixel");
        let bytes = encode(&image, 0.0, &[("mlt.scene".into(), "größe".into())]).expect("encoded");
        let place = |chunk: &[u8]| bytes.windows(4).position(|window| window == chunk);
        let places = [b"IHDR", b"sRGB", b"gAMA", b"cHRM", b"iTXt", b"IDAT"].map(|chunk| place(chunk).expect("there"));
        assert!(places[..4].iter().chain(&places[4..]).all(|&place| place <= places[5]), "{places:?}");
    }

    #[test]
    fn grey_and_sixteen_bit_files_are_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        ::image::ImageBuffer::from_pixel(1, 1, ::image::Luma([u16::MAX])).save(&path).expect("written");
        assert_eq!(read(&path).expect("read").rgb, [[1.0; 3]]);
    }
}
