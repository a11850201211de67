//! JPEG: 8 bits a channel, sRGB, lossy; with how the image was made in comments.

use std::{
    fs::{self, File},
    io::BufReader,
    path::Path,
};

use ::image::{
    ExtendedColorType, ImageDecoder, ImageEncoder,
    codecs::jpeg::{JpegDecoder, JpegEncoder},
};
use anyhow::{Context, bail};

use super::{Attributes, SizeAndAttributes, decoder, lines, srgb};
use crate::image::Image;

/// The first bytes of every JPEG file: the marker of its start, and the next marker's first byte.
pub const MAGIC: [u8; 3] = [0xff, 0xd8, 0xff];
/// Quality of 1 to 100: noise and flat walls without visible blocks, in a fifth of PNG's bytes.
const QUALITY: u8 = 95;
/// Marker of a comment.
const COMMENT: u8 = 0xfe;
/// Marker of the picture's data, after which no segment is looked for.
const SCAN: u8 = 0xda;

/// The file's bytes: pixels as in a PNG, and each attribute as a comment. Same image, same bytes.
pub fn encode(image: &Image, exposure: f64, attributes: &Attributes) -> anyhow::Result<Vec<u8>> {
    let (Ok(width), Ok(height)) = (u16::try_from(image.width), u16::try_from(image.height)) else {
        bail!("a JPEG image has at most {} pixels along a side", u16::MAX);
    };
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, QUALITY).write_image(
        &srgb::bytes(&image.rgb, exposure),
        width.into(),
        height.into(),
        ExtendedColorType::Rgb8,
    )?;
    // Behind the first segment, which says that the file is JFIF.
    let start = segments(&file).next().map_or(2, |(_, content)| 2 + 4 + content.len());
    let comments: Vec<u8> =
        attributes.iter().filter_map(|attribute| comment(&lines::line(attribute))).flatten().collect();
    file.splice(start..start, comments);
    Ok(file)
}

/// A segment that holds a text; `None`: the text is too long for one.
fn comment(text: &str) -> Option<Vec<u8>> {
    let length = u16::try_from(text.len() + 2).ok()?;
    Some([&[0xff, COMMENT], &length.to_be_bytes()[..], text.as_bytes()].concat())
}

/// Markers and contents of the segments before the picture's data.
///
/// A segment is: 0xff, marker, length of the rest (2 bytes, big-endian, themselves included), content. Source: ITU-T T.81, B.1.
fn segments(file: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = file.get(2..).unwrap_or_default();
    std::iter::from_fn(move || {
        let ([0xff, marker, high, low], after) = rest.split_first_chunk()? else { return None };
        let length = usize::from(u16::from_be_bytes([*high, *low])).checked_sub(2)?;
        let (content, next) = after.split_at_checked(length).filter(|_| *marker != SCAN)?;
        rest = next;
        Some((*marker, content))
    })
}

/// Reads a JPEG file as linear Rec. 709 in 0…1.
pub fn read(path: &Path) -> anyhow::Result<Image> {
    let decode = || {
        let decoder = JpegDecoder::new(BufReader::new(File::open(path)?))?;
        let mut image = decoder::pixels(decoder)?;
        image.rgb.as_flattened_mut().iter_mut().for_each(|value| *value = srgb::linear_from_srgb(*value));
        anyhow::Ok(image)
    };
    decode().with_context(|| format!("{}: cannot be read as JPEG", path.display()))
}

/// Width and height, and what [`encode`] was told of the image.
pub(super) fn attributes(path: &Path) -> anyhow::Result<SizeAndAttributes> {
    crate::require_memory(fs::metadata(path)?.len(), "what it holds")?;
    let file = fs::read(path)?;
    let (width, height) = JpegDecoder::new(std::io::Cursor::new(&file))?.dimensions();
    let comments = segments(&file).filter(|&(marker, _)| marker == COMMENT);
    let pairs = comments.filter_map(|(_, content)| lines::pair(&String::from_utf8_lossy(content)));
    Ok(([width, height].map(|side| side as usize), pairs.collect()))
}
