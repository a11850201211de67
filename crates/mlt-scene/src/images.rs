//! Image files as textures: PNG, JPEG and WebP, each decoded once.
//!
//! An image that is missing or broken is a warning: what it is a factor of stands as it is. Memory for all pixels is taken before
//! any image is decoded.

use crate::{SceneError, guard, source::Source, text::shown};
use image::{DynamicImage, ImageDecoder, ImageReader, Limits};
use mlt_core::transport::scene::{Encoding, Filter, Pixels, Texture, Wrap};
use rayon::prelude::*;
use std::{
    borrow::Cow,
    collections::{BTreeMap, HashMap},
    io::Cursor,
    sync::Arc,
};

/// The longest side of an image.
const MAX_SIDE: u32 = 1 << 15;

/// Most memory for what a file holds besides its pixels: whatever that says, a few bytes can ask for gigabytes.
const MOST_BESIDES: u64 = 4 << 20;

/// How a texture reads its image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Sampler {
    /// Along u and v.
    pub wrap: [Wrap; 2],
    pub filter: Filter,
}

/// The images of a scene by name, and the textures that were made of them.
#[derive(Default)]
pub(crate) struct Images {
    decoded: HashMap<String, Arc<Pixels>>,
    textures: Vec<Texture>,
    known: HashMap<(String, Sampler, Encoding), u32>,
}

impl Images {
    /// Decodes files, each given by its name and its content, or by why there is none.
    pub(crate) fn decode(
        source: &Source,
        files: BTreeMap<String, Result<Cow<[u8]>, String>>,
        warnings: &mut Vec<String>,
    ) -> Result<Self, SceneError> {
        let files: Vec<_> = files
            .into_iter()
            .map(|(name, bytes)| (name, bytes.and_then(|bytes| Ok((bytes_of(&bytes)?, bytes)))))
            .collect();
        let sizes = || files.iter().filter_map(|(_, file)| Some(file.as_ref().ok()?.0));
        if let count @ 1.. = sizes().count() {
            let images = if count == 1 { "image" } else { "images" };
            source.take(sizes().sum(), format!("the pixels of {count} {images}"))?;
        }
        let decode = |(name, file): (_, Result<(_, _), _>)| (name, file.and_then(|(_, bytes)| pixels(bytes)));
        let results: Vec<(String, _)> = files.into_par_iter().map(decode).collect();
        let mut images = Self::default();
        for (name, result) in results {
            match result {
                Ok(pixels) => _ = images.decoded.insert(name, Arc::new(pixels)),
                Err(reason) => warnings.push(format!("the image {} is left out: {reason}", shown(&name))),
            }
        }
        Ok(images)
    }

    /// Number of the texture that reads an image in this way; `None`: the image was left out.
    pub(crate) fn texture(&mut self, name: &str, sampler: Sampler, encoding: Encoding) -> Option<u32> {
        let pixels = self.decoded.get(name)?;
        let next = self.textures.len() as u32;
        let number = *self.known.entry((name.to_owned(), sampler, encoding)).or_insert(next);
        if number == next {
            self.textures.push(Texture::new(pixels.clone(), sampler.wrap, sampler.filter, encoding));
        }
        Some(number)
    }

    /// Name of the image that is made of another, whose kind says how; `None`: that was left out.
    pub(crate) fn derived(
        &mut self,
        name: &str,
        kind: &str,
        make: impl FnOnce(&Pixels) -> Option<Pixels>,
    ) -> Option<String> {
        let pixels = self.decoded.get(name)?;
        let derived = format!("{kind} of {name}");
        if !self.decoded.contains_key(&derived) {
            let made = make(pixels)?;
            self.decoded.insert(derived.clone(), Arc::new(made));
        }
        Some(derived)
    }

    /// An image; `None`: it was left out.
    pub(crate) fn pixels(&self, name: &str) -> Option<&Pixels> {
        self.decoded.get(name).map(Arc::as_ref)
    }

    /// The textures, by number.
    pub(crate) fn into_textures(self) -> Vec<Texture> {
        self.textures
    }
}

/// Bytes of an image's pixels while it is decoded, as its first bytes announce them.
fn bytes_of(file: &[u8]) -> Result<u64, String> {
    let decoder = guard::catch(|| -> Result<_, String> {
        let mut reader = reader(file)?;
        reader.limits(limits(MOST_BESIDES));
        let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
        Ok((decoder.dimensions(), decoder.total_bytes()))
    });
    let ((width, height), bytes) = decoder??;
    if width.max(height) > MAX_SIDE {
        return Err(format!("it has {width}x{height} pixels; at most {MAX_SIDE} a side are read"));
    }
    Ok(bytes)
}

fn reader(file: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, String> {
    if file.starts_with(b"\xabKTX 20") {
        return Err("KTX2 is not supported; convert it to PNG, JPEG or WebP".to_owned());
    }
    let reader = ImageReader::new(Cursor::new(file)).with_guessed_format().map_err(|error| error.to_string())?;
    match reader.format() {
        Some(_) => Ok(reader),
        None => Err("it is neither PNG, JPEG nor WebP".to_owned()),
    }
}

fn limits(bytes: u64) -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(bytes);
    limits
}

/// An image with 8 bits a channel.
fn pixels(file: Cow<[u8]>) -> Result<Pixels, String> {
    let file = &file[..];
    let decoded = guard::catch(|| -> Result<_, String> {
        let mut reader = reader(file)?;
        reader.limits(limits(bytes_of(file)? + MOST_BESIDES));
        reader.decode().map_err(|error| error.to_string())
    });
    let image = decoded??;
    let size = [image.width(), image.height()];
    let (channels, bytes) = match image {
        DynamicImage::ImageLuma8(grey) => (1, grey.into_raw()),
        DynamicImage::ImageLumaA8(grey) => (2, grey.into_raw()),
        DynamicImage::ImageRgb8(rgb) => (3, rgb.into_raw()),
        DynamicImage::ImageRgba8(rgba) => (4, rgba.into_raw()),
        DynamicImage::ImageLuma16(_) => (1, image.into_luma8().into_raw()),
        deep if deep.color().has_alpha() => (4, deep.into_rgba8().into_raw()),
        deep => (3, deep.into_rgb8().into_raw()),
    };
    Pixels::new(size, channels, bytes).ok_or_else(|| "it has no pixels".to_owned())
}
