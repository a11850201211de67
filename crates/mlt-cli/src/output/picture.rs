//! The content of an image file.

use std::io::Cursor;

use anyhow::bail;
use mlt_core::engine::Film;
use serde::Serialize;

use super::{Format, Medium, errors::Errors, exr, exr::Source, hdr, jpg, png};
use crate::image::Image;

/// A number for each pixel, beside the image's three.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name in a file, such as `stderr.R`; viewers take what stands before the point for a layer.
    pub name: String,
    /// As many as the image has pixels.
    pub values: Vec<f32>,
}

impl Channel {
    /// The channels of three numbers a pixel, of these names.
    pub fn of_triples(names: [&str; 3], triples: &[[f32; 3]]) -> [Self; 3] {
        let component = |i: usize| triples.iter().map(|triple| triple[i]).collect();
        std::array::from_fn(|i| Self { name: names[i].to_owned(), values: component(i) })
    }
}

/// A larger image of which an image is a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Frame {
    /// Its width and height, pixels.
    pub size: [usize; 2],
    /// Column and row of the part's first pixel.
    pub corner: [usize; 2],
}

impl Frame {
    /// Of an image that is no part of another.
    pub fn whole(image: &Image) -> Self {
        Self { size: [image.width, image.height], corner: [0, 0] }
    }
}

/// All that an image file may hold; each format has its share of it.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The pixels.
    pub image: Image,
    /// The film whose pixels' standard errors are further channels, for OpenEXR.
    pub errors: Option<&'a Film<3>>,
    /// Further channels, for OpenEXR.
    pub channels: Vec<Channel>,
    /// Where the image lies, for OpenEXR.
    pub frame: Frame,
    /// How it was made.
    pub attributes: Vec<(String, String)>,
    /// In stops, for PNG and JPEG.
    pub exposure: f64,
}

impl Picture<'_> {
    /// The bytes of a file of it. Same picture, same bytes.
    pub fn encode(&self, format: Format) -> anyhow::Result<Vec<u8>> {
        let mut bytes = Cursor::new(Vec::new());
        self.write(format, &mut bytes)?;
        Ok(bytes.into_inner())
    }

    /// Writes these bytes; OpenEXR and PNG a row at a time.
    pub fn write(&self, format: Format, to: &mut dyn Medium) -> anyhow::Result<()> {
        let Self { image, attributes, exposure, .. } = self;
        match format {
            Format::Exr => self.write_exr(to),
            Format::Hdr => Ok(to.write_all(&hdr::encode(image, attributes)?)?),
            Format::Png => png::write(image, *exposure, attributes, to),
            Format::Jpg => Ok(to.write_all(&jpg::encode(image, *exposure, attributes)?)?),
            Format::Sums | Format::Pilot => bail!("sums of rounds are no image"),
        }
    }

    fn write_exr(&self, to: &mut dyn Medium) -> anyhow::Result<()> {
        let errors = self.errors.map(Errors::new);
        let of_errors = |errors| exr::STDERR.into_iter().zip((0..3).map(move |i| Source::Errors(errors, i)));
        let others = self.channels.iter().map(|channel| (channel.name.as_str(), Source::Values(&channel.values)));
        let channels: Vec<_> = errors.iter().flat_map(of_errors).chain(others).collect();
        exr::write(&self.image, &channels, (self.frame, &self.attributes), to)
    }
}
