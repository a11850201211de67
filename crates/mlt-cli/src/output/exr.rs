//! OpenEXR: linear pixels, their standard errors, and how the image was made.

use std::{
    fs::File,
    io::{BufReader, Cursor, Read, SeekFrom},
    path::Path,
};

use ::exr::{
    block::lines::LineRefMut,
    image::write::samples::{SamplesWriter, WritableSamples},
    math::RoundingMode,
    meta::{
        attribute::{AttributeValue, IntegerBounds, LevelMode, SampleType, Text},
        header::{Header, ImageAttributes, LayerAttributes},
    },
    prelude::{
        AnyChannel, AnyChannels, Blocks, Compression, Encoding, Image as ExrImage, Layer, LineOrder, ReadChannels,
        ReadLayers, ReadSpecificChannel, Vec2, WritableImage, read as exr_read,
    },
};
use anyhow::{Context, bail};

use super::{Attributes, Frame, Medium, check_size, errors::Errors};
use crate::{image::Image, require_memory};

/// The first bytes of every OpenEXR file.
pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Lossless, rows from the top: what every reader of OpenEXR understands. ZIP makes images of Monte Carlo noise 3 % smaller, in
/// fifty times the time.
const ENCODING: Encoding =
    Encoding { compression: Compression::RLE, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// Channels of the standard errors.
pub const STDERR: [&str; 3] = ["stderr.R", "stderr.G", "stderr.B"];

/// Content of an OpenEXR file of this program.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrFile {
    /// Channels R, G, B.
    pub image: Image,
    /// Standard error of each value (channels `stderr.R`, `stderr.G`, `stderr.B`), if there.
    pub stderr: Option<Vec<[f32; 3]>>,
    /// Attributes that hold text, by name; sorted.
    pub attributes: Vec<(String, String)>,
}

/// Where the numbers of a channel are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source<'a> {
    /// One of the three that each pixel has.
    Component(&'a [[f32; 3]], usize),
    /// One for each pixel.
    Values(&'a [f32]),
    /// Standard errors of a channel of a film.
    Errors(&'a Errors<'a>, usize),
}

impl<'a> Source<'a> {
    /// The channels of three numbers a pixel, of these names.
    pub(super) fn of_triples(names: [&'a str; 3], triples: &'a [[f32; 3]]) -> [(&'a str, Self); 3] {
        std::array::from_fn(|i| (names[i], Self::Component(triples, i)))
    }

    /// How many there are, where they are all there.
    fn count(&self) -> Option<usize> {
        match self {
            Self::Component(triples, _) => Some(triples.len()),
            Self::Values(values) => Some(values.len()),
            Self::Errors(..) => None,
        }
    }
}

impl<'a> WritableSamples<'_> for Source<'a> {
    type Writer = Source<'a>;

    fn sample_type(&self) -> SampleType {
        SampleType::F32
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&self, _: &Header) -> Self::Writer {
        *self
    }
}

impl SamplesWriter for Source<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let (row, width) = (line.location.position.y(), line.location.sample_count);
        let written = match *self {
            Self::Component(triples, i) => line.write_samples(|x| triples[row * width + x][i]),
            Self::Values(values) => line.write_samples_from_slice(&values[row * width..][..width]),
            Self::Errors(errors, i) => line.write_samples_from_slice(&errors.line(row, i)),
        };
        written.expect("a line in memory takes its numbers");
    }
}

/// The file's bytes: 32-bit float channels, losslessly compressed. Same input, same bytes.
///
/// `stderr`: as many pixels as the image. `attributes`: names (each once) and UTF-8 texts for the header.
pub fn encode(image: &Image, stderr: Option<&[[f32; 3]]>, attributes: &Attributes) -> anyhow::Result<Vec<u8>> {
    let channels: Vec<_> = stderr.into_iter().flat_map(|stderr| Source::of_triples(STDERR, stderr)).collect();
    let mut file = Cursor::new(Vec::new());
    write(image, &channels, (Frame::whole(image), attributes), &mut file)?;
    Ok(file.into_inner())
}

/// Writes the same with any channels beside the image's, of an image that may be a part of a larger one: the data window of the display
/// window. No more than a line is encoded at a time.
pub(super) fn write(
    image: &Image,
    channels: &[(&str, Source)],
    (frame, attributes): (Frame, &Attributes),
    mut to: &mut dyn Medium,
) -> anyhow::Result<()> {
    let differs = |source: &Source| source.count().is_some_and(|count| count != image.rgb.len());
    if let Some((name, _)) = channels.iter().find(|(_, source)| differs(source)) {
        bail!("the channel {name} does not have the image's size");
    }
    let all = Source::of_triples(["R", "G", "B"], &image.rgb).into_iter().chain(channels.iter().copied());
    let all = all.map(|(name, sample_data)| AnyChannel {
        name: name.into(),
        sample_data,
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    });
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let attribute = |(name, value): &(String, String)| (text(name), AttributeValue::Text(text(value)));
    let header = LayerAttributes {
        layer_position: Vec2(frame.corner[0] as i32, frame.corner[1] as i32),
        other: attributes.iter().map(attribute).collect(),
        ..LayerAttributes::default()
    };
    let file = ExrImage {
        attributes: ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(frame.size[0], frame.size[1]))),
        layer_data: Layer {
            channel_data: AnyChannels::sort(all.collect()),
            attributes: header,
            size: Vec2(image.width, image.height),
            encoding: ENCODING,
        },
    };
    file.write().non_parallel().to_unbuffered(&mut to)?;
    let texts: usize = attributes.iter().map(|(name, value)| name.len() + value.len() + MOST_OF_ATTRIBUTE).sum();
    sort_attributes_of(to, texts + MOST_OF_HEADER)
}

/// Most bytes of a header without the texts, and of a text without its name and value.
const MOST_OF_HEADER: usize = 1 << 16;
const MOST_OF_ATTRIBUTE: usize = 16;

/// [`sort_attributes`] in a file whose header has so many bytes at most.
fn sort_attributes_of(file: &mut dyn Medium, most: usize) -> anyhow::Result<()> {
    let mut header = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    Read::take(&mut *file, most as u64).read_to_end(&mut header)?;
    sort_attributes(&mut header).context("the encoder wrote a header of an unknown form")?;
    file.seek(SeekFrom::Start(0))?;
    Ok(file.write_all(&header)?)
}

/// Puts the header's attributes in the order of their names, in place: the encoder keeps them in a hash map, whose
/// order differs from run to run.
///
/// Each attribute is: name, 0, type, 0, length of the value (4 bytes, little-endian), value; an empty name ends the
/// header, which follows the magic number and the version (8 bytes). Source: "OpenEXR File Layout".
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut rest = file.get(START..)?;
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&byte| byte == 0)?;
        let kind = rest.get(name + 1..)?.iter().position(|&byte| byte == 0)?;
        let length = name + 1 + kind + 1;
        let value = u32::from_le_bytes(rest.get(length..length + 4)?.try_into().ok()?) as usize;
        let (attribute, after) = rest.split_at_checked(length + 4 + value)?;
        attributes.push(attribute);
        rest = after;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[START..START + sorted.len()].copy_from_slice(&sorted);
    Some(())
}

/// Reads the first layer that has the channels R, G and B, of any sample type.
pub fn read(path: &Path) -> anyhow::Result<ExrFile> {
    decode(path).with_context(|| format!("{}: cannot be read as OpenEXR", path.display()))
}

type Pixels = (Vec<[f32; 3]>, Option<Vec<[f32; 3]>>, usize);

fn decode(path: &Path) -> anyhow::Result<ExrFile> {
    let chunks = ::exr::block::read(BufReader::new(File::open(path)?), false)?;
    chunks.headers().iter().try_for_each(check_memory)?;
    let file = exr_read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .optional(STDERR[0], f32::NAN)
        .optional(STDERR[1], f32::NAN)
        .optional(STDERR[2], f32::NAN)
        .collect_pixels(
            |size, (_, _, _, r, g, b)| -> Pixels {
                let blank = || vec![[f32::NAN; 3]; size.area()];
                let stderr = r.is_some() && g.is_some() && b.is_some();
                (blank(), stderr.then(blank), size.width())
            },
            |(rgb, stderr, width): &mut Pixels, position, (r, g, b, dr, dg, db)| {
                let index = position.y() * *width + position.x();
                rgb[index] = [r, g, b];
                if let Some(stderr) = stderr {
                    stderr[index] = [dr, dg, db];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_chunks(chunks)?;
    let layer = file.layer_data;
    let mut attributes: Vec<_> =
        file.attributes.other.iter().chain(&layer.attributes.other).filter_map(text_attribute).collect();
    attributes.sort_unstable();
    let (rgb, stderr, _) = layer.channel_data.pixels;
    Ok(ExrFile { image: Image::new(layer.size.width(), layer.size.height(), rgb)?, stderr, attributes })
}

/// Refuses a layer that there is no memory for.
fn check_memory(header: &Header) -> anyhow::Result<()> {
    // The image and its standard error, 12 bytes each.
    check_size(header.layer_size.width(), header.layer_size.height(), 24)?;
    // What is decoded at once, all channels of it.
    let Vec2(width, height) = header.max_block_pixel_size();
    let bytes = (width as u64).saturating_mul(height as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
    require_memory(bytes, &format!("a block of {width}x{height} pixels"))
}

fn text_attribute((name, value): (&Text, &AttributeValue)) -> Option<(String, String)> {
    let string = |text: &Text| String::from_utf8_lossy(text.as_slice()).into_owned();
    match value {
        AttributeValue::Text(text) => Some((string(name), string(text))),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Image {
        let pixel = |i: usize| [i as f32 * 0.25, 1.0 / (i as f32 + 1.0), f32::MAX / (i as f32 + 1.0)];
        Image::new(7, 40, (0..280).map(pixel).collect()).expect("280 pixels")
    }

    fn attributes() -> Vec<(String, String)> {
        let pair = |(name, value): (&str, &str)| (name.to_owned(), value.to_owned());
        let mut list: Vec<_> = (0..20).map(|i| pair((&format!("mlt.b{i:02}"), "0.5"))).collect();
        list.extend([("mlt.note", ""), ("mlt.scene", "Szene/größe 門.gltf"), ("mlt.version", "0.1.0")].map(pair));
        list
    }

    fn read_back(bytes: &[u8]) -> anyhow::Result<ExrFile> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("a.exr");
        std::fs::write(&path, bytes)?;
        read(&path)
    }

    #[test]
    fn everything_is_read_back_bit_for_bit() {
        let image = gradient();
        let stderr: Vec<_> = image.rgb.iter().map(|pixel| pixel.map(|value| value * 0.01)).collect();
        let bytes = encode(&image, Some(&stderr), &attributes()).expect("encoded");
        let file = read_back(&bytes).expect("read");
        assert!(file.image.same_bits(&image));
        assert_eq!(file.stderr, Some(stderr));
        assert_eq!(file.attributes, attributes());
    }

    #[test]
    fn an_image_without_standard_errors_has_none() {
        let file = read_back(&encode(&gradient(), None, &[]).expect("encoded")).expect("read");
        assert_eq!(file, ExrFile { image: gradient(), stderr: None, attributes: vec![] });
    }

    #[test]
    fn the_same_image_has_the_same_bytes() {
        let bytes = || encode(&gradient(), None, &attributes()).expect("encoded");
        let first = bytes();
        assert!((0..20).all(|_| bytes() == first));
    }

    #[test]
    fn standard_errors_of_another_size_are_refused() {
        assert!(encode(&gradient(), Some(&[[0.0; 3]]), &[]).is_err());
    }

    #[test]
    fn a_truncated_file_is_refused() {
        let bytes = encode(&gradient(), None, &attributes()).expect("encoded");
        for length in [5, 20, 300, bytes.len() / 2, bytes.len() - 1] {
            assert!(read_back(&bytes[..length]).is_err(), "{length} of {} bytes", bytes.len());
        }
    }

    /// Any byte of the header or of the offset table changed: an error or an image, no panic and no huge allocation.
    #[test]
    fn a_damaged_file_does_not_panic() {
        let bytes = encode(&gradient(), None, &attributes()[..1]).expect("encoded");
        for index in 0..bytes.len().min(700) {
            for value in [0, 1, 0x7f, 0xff] {
                let mut damaged = bytes.clone();
                damaged[index] = value;
                let _ = read_back(&damaged);
            }
        }
    }
}
