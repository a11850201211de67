//! Radiance: linear pixels of a shared exponent, 1 % fine, with how the image was made in comments.
//!
//! A file begins with lines of text up to an empty one; those that begin with # are comments. Source: G. Ward, "Real Pixels", Graphics
//! Gems II, 1991.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read},
    path::Path,
};

use ::image::{
    ImageDecoder, Rgb,
    codecs::hdr::{HdrDecoder, HdrEncoder},
};
use anyhow::Context;

use super::{Attributes, decoder, lines};
use crate::image::Image;

/// The first bytes of every Radiance file.
pub const MAGIC: [u8; 2] = *b"#?";
/// Before an attribute, in a line of its own.
const COMMENT: &str = "# ";

/// The file's bytes; what is negative or not finite becomes black. Same image, same bytes.
pub fn encode(image: &Image, attributes: &Attributes) -> anyhow::Result<Vec<u8>> {
    let positive = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
    let pixels: Vec<_> = image.rgb.iter().map(|pixel| Rgb(pixel.map(positive))).collect();
    let mut file = Vec::new();
    HdrEncoder::new(&mut file).encode(&pixels, image.width, image.height)?;
    let start = file.iter().position(|&byte| byte == b'\n').context("the encoder wrote no line")? + 1;
    let comments: String =
        attributes.iter().map(|attribute| format!("{COMMENT}{}\n", lines::line(attribute))).collect();
    file.splice(start..start, comments.into_bytes());
    Ok(file)
}

/// Reads a Radiance file.
pub fn read(path: &Path) -> anyhow::Result<Image> {
    let decode = || {
        let decoder = HdrDecoder::new(BufReader::new(File::open(path)?))?;
        decoder::pixels(decoder)
    };
    decode().with_context(|| format!("{}: cannot be read as Radiance HDR", path.display()))
}

/// Width and height, and what [`encode`] was told of the image.
pub(super) fn attributes(path: &Path) -> anyhow::Result<([usize; 2], Vec<(String, String)>)> {
    let (width, height) = HdrDecoder::new(BufReader::new(File::open(path)?))?.dimensions();
    let header = BufReader::new(File::open(path)?.take(decoder::MOST_BESIDES)).lines();
    let lines: Vec<_> = header.map_while(Result::ok).take_while(|line| !line.is_empty()).collect();
    let pairs = lines.iter().filter_map(|line| lines::pair(line.strip_prefix(COMMENT)?));
    Ok(([width, height].map(|side| side as usize), pairs.collect()))
}
