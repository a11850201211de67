//! Image files: which formats there are, whether a target can be written, and reading any of them.

use std::{
    panic::{self, AssertUnwindSafe},
    path::Path,
};

use anyhow::{Context, bail};

use crate::image::Image;

mod decoder;
pub(crate) mod errors;
mod existing;
pub mod exr;
mod format;
pub mod hdr;
pub mod jpg;
mod lines;
mod picture;
pub mod png;
pub(crate) mod srgb;
mod target;

pub use existing::check_existing;
pub use format::Format;
pub use picture::{Channel, Frame, Picture};
pub use target::{Medium, OutputFile, check_target, check_targets};

/// Largest width and height of an image, pixels.
pub const MAX_SIDE: usize = 65_536;

/// Names, each once, and UTF-8 texts that go into an image file beside its pixels.
pub type Attributes = [(String, String)];

/// Reads an image file of any format, whichever its first bytes say, as linear Rec. 709.
pub fn read_image(path: &Path) -> anyhow::Result<(Image, Format)> {
    let format = Format::of_file(path).with_context(|| path.display().to_string())?;
    let read = || match format {
        Format::Exr => Ok(exr::read(path)?.image),
        Format::Hdr => hdr::read(path),
        Format::Png => png::read(path),
        Format::Pilot => bail!("{}: what a pilot found, no image", path.display()),
        Format::Jpg => jpg::read(path),
        Format::Sums => bail!("{}: sums of rounds, no image; 'mlt merge' makes one of them", path.display()),
    };
    let image = without_panic(read).with_context(|| format!("{}: damaged", path.display()))??;
    Ok((image, format))
}

/// Width and height of an image, and the attributes that it was written with.
pub(crate) type SizeAndAttributes = ([usize; 2], Vec<(String, String)>);

/// The same of an image file.
pub(crate) fn read_attributes(path: &Path, format: Format) -> anyhow::Result<SizeAndAttributes> {
    let read = || match format {
        Format::Exr => exr::read(path).map(|file| ([file.image.width, file.image.height], file.attributes)),
        Format::Hdr => hdr::attributes(path),
        Format::Png => png::attributes(path),
        Format::Jpg => jpg::attributes(path),
        Format::Sums | Format::Pilot => bail!("sums of rounds, no image"),
    };
    without_panic(read).context("damaged").and_then(|read| read).with_context(|| path.display().to_string())
}

/// Runs a decoder; `None` when it panicked, which exr 1.74 does on some damaged B44 data. Says nothing on the terminal.
pub(crate) fn without_panic<T>(decode: impl FnOnce() -> T) -> Option<T> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    panic::set_hook(hook);
    result.ok()
}

/// Refuses an image whose sides or memory are out of proportion, before anything is allocated for it.
fn check_size(width: usize, height: usize, bytes_per_pixel: u64) -> anyhow::Result<()> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        bail!("an image of {width}x{height} is outside 1x1 to {MAX_SIDE}x{MAX_SIDE}");
    }
    let bytes = width as u64 * height as u64 * bytes_per_pixel;
    crate::require_memory(bytes, &format!("an image of {width}x{height}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every format gives back the attributes, and pixels as fine as it has them.
    #[test]
    fn all_formats_are_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let pixel = |i: usize| [0.02 + i as f32 / 100.0, 0.5, 0.25];
        let image = Image::new(10, 8, (0..80).map(pixel).collect()).expect("80 pixels");
        let attributes = [("mlt.scene", "größe 門.gltf"), ("mlt.warnings", "one\\\ntwo = 2"), ("mlt.z", "")]
            .map(|(name, value)| (name.to_owned(), value.to_owned()));
        for (name, bytes, tolerance) in [
            ("a.exr", exr::encode(&image, None, &attributes), 0.0),
            ("a.hdr", hdr::encode(&image, &attributes), 0.01),
            ("a.png", png::encode(&image, 0.0, &attributes), 0.01),
            ("a.jpg", jpg::encode(&image, 0.0, &attributes), 0.05),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes.expect("encoded")).expect("written");
            let (found, format) = read_image(&path).expect(name);
            assert_eq!(Some(format), name.parse::<OutputFile>().ok().map(|file| file.format));
            let pairs = found.rgb.as_flattened().iter().zip(image.rgb.as_flattened());
            assert!(pairs.clone().all(|(a, b)| (a - b).abs() <= tolerance), "{name}");
            assert_eq!(read_attributes(&path, format).expect(name), ([10, 8], attributes.to_vec()), "{name}");
        }
    }

    #[test]
    fn damaged_files_are_refused_without_a_panic() {
        let folder = tempfile::tempdir().expect("a folder");
        let image = Image::new(9, 5, vec![[0.3, 0.6, 0.1]; 45]).expect("45 pixels");
        let attributes = [("mlt.note".to_owned(), "text".to_owned())];
        let path = folder.path().join("a");
        for bytes in [
            hdr::encode(&image, &attributes),
            png::encode(&image, 0.0, &attributes),
            jpg::encode(&image, 0.0, &attributes),
        ] {
            let bytes = bytes.expect("encoded");
            for index in 3..bytes.len().min(300) {
                let mut damaged = bytes.clone();
                damaged[index] ^= 0xff;
                for file in [&damaged[..], &bytes[..index]] {
                    std::fs::write(&path, file).expect("written");
                    let _ = read_image(&path);
                    if let Ok(format) = Format::of_file(&path) {
                        let _ = read_attributes(&path, format);
                    }
                }
            }
        }
    }

    #[test]
    fn a_decoder_that_panics_is_survived() {
        assert_eq!(without_panic(|| 1), Some(1));
        assert_eq!(without_panic(|| [1, 2][std::hint::black_box(2)]), None);
    }
}
