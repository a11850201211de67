//! Images of environments: Radiance HDR and OpenEXR, with linear Rec. 709 colours.

use crate::{SceneError, guard};
use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};
use image::{ImageDecoder, codecs::hdr::HdrDecoder};
use mlt_core::memory::{Memory, Shortage};
use mlt_core::transport::Rgb;
use mlt_core::transport::scene::Environment;
use std::{fs, io::Cursor, path::Path};

/// Most pixels of an image: 16,384 × 8,192.
const MOST_PIXELS: u64 = 1 << 27;
/// Most pixels along one side.
const LONGEST_SIDE: u64 = 1 << 16;
/// Memory for a pixel, bytes: those of the decoder, the scene's, and the sums that directions are drawn by.
const BYTES_PER_PIXEL: u64 = 48;

/// The environment in a file, whose size is looked at before it is decoded, and the hash of the file.
pub(super) fn load(
    path: &Path,
    memory: &Memory,
    warnings: &mut Vec<String>,
) -> Result<(Environment, blake3::Hash), SceneError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let (format, decode): (_, Decode) = match extension.as_deref() {
        Some("hdr") => ("Radiance HDR", radiance),
        Some("exr") => ("OpenEXR", open_exr),
        _ => return Err(SceneError::NoEnvironment { path: path.to_owned() }),
    };
    let file = Named { path, format, memory };
    let content = file.content()?;
    let decoded = guard::catch(|| decode(&file, &content)).map_err(|reason| file.error(reason))?;
    let (size, pixels) = decoded?;
    let Some((environment, repaired)) = Environment::image(size, pixels) else {
        return Err(file.error("it has no pixels"));
    };
    let name = path.display();
    if repaired > 0 {
        warnings.push(format!("{name}: {repaired} pixels have a value that is negative or no number; 0 stands in"));
    }
    if size[0] != 2 * size[1] {
        let [width, height] = size;
        warnings.push(format!(
            "{name}: {width}x{height} pixels, while an image of all directions is twice as wide as high; it is stretched"
        ));
    }
    if !environment.is_lit() {
        warnings.push(format!("{name}: the image is black, and lights nothing"));
    }
    Ok((environment, blake3::hash(&content)))
}

type Decode = fn(&Named, &[u8]) -> Result<([u32; 2], Vec<Rgb>), SceneError>;

/// A file that is being read.
struct Named<'a> {
    path: &'a Path,
    format: &'static str,
    memory: &'a Memory,
}

impl Named<'_> {
    fn error(&self, reason: impl ToString) -> SceneError {
        SceneError::Image { path: self.path.to_owned(), format: self.format, reason: reason.to_string() }
    }

    fn content(&self) -> Result<Vec<u8>, SceneError> {
        let failed = |cause| SceneError::Read { path: self.path.to_owned(), cause };
        let metadata = self.path.metadata().map_err(failed)?;
        if !metadata.is_file() {
            return Err(SceneError::NotAFile { path: self.path.to_owned() });
        }
        self.memory.check(metadata.len()).map_err(|shortage| self.refused(shortage))?;
        fs::read(self.path).map_err(failed)
    }

    fn refused(&self, shortage: Shortage) -> SceneError {
        SceneError::Memory { path: self.path.to_owned(), what: "the environment".into(), shortage }
    }

    /// Takes the memory for an image of a size that is not too large.
    fn take(&self, [width, height]: [u64; 2]) -> Result<(), SceneError> {
        let pixels = width.saturating_mul(height);
        if width.max(height) > LONGEST_SIDE || pixels > MOST_PIXELS {
            return Err(self.error(format!("{width}x{height} pixels are more than {MOST_PIXELS}; scale it down")));
        }
        self.memory.take(pixels * BYTES_PER_PIXEL).map_err(|shortage| self.refused(shortage))
    }
}

fn radiance(file: &Named, content: &[u8]) -> Result<([u32; 2], Vec<Rgb>), SceneError> {
    let decoder = HdrDecoder::new(Cursor::new(content)).map_err(|error| file.error(error))?;
    let (width, height) = decoder.dimensions();
    file.take([u64::from(width), u64::from(height)])?;
    let mut bytes = vec![0; width as usize * height as usize * size_of::<Rgb>()];
    decoder.read_image(&mut bytes).map_err(|error| file.error(error))?;
    let channel = |bytes: &[u8; 4]| f32::from_ne_bytes(*bytes);
    let pixels = bytes.as_chunks::<12>().0.iter().map(|pixel| {
        let (channels, _) = pixel.as_chunks::<4>();
        Rgb::new(channel(&channels[0]), channel(&channels[1]), channel(&channels[2]))
    });
    Ok(([width, height], pixels.collect()))
}

fn open_exr(file: &Named, content: &[u8]) -> Result<([u32; 2], Vec<Rgb>), SceneError> {
    let failed = |error: exr::error::Error| file.error(error);
    let headers = MetaData::read_from_buffered(Cursor::new(content), true).map_err(failed)?.headers;
    for header in &headers {
        file.take([header.layer_size.width() as u64, header.layer_size.height() as u64])?;
    }
    let create = |size: exr::math::Vec2<usize>, _: &_| {
        ([size.width() as u32, size.height() as u32], vec![Rgb::ZERO; size.area()])
    };
    let set = |image: &mut ([u32; 2], Vec<Rgb>), at: exr::math::Vec2<usize>, (r, g, b, _): (f32, f32, f32, f32)| {
        image.1[at.y() * image.0[0] as usize + at.x()] = Rgb::new(r, g, b);
    };
    let layer = read().no_deep_data().largest_resolution_level().rgba_channels(create, set).first_valid_layer();
    let image = layer.all_attributes().from_buffered(Cursor::new(content)).map_err(failed)?;
    Ok(image.layer_data.channel_data.pixels)
}
