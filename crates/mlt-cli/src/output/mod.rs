//! Image files: which formats there are, whether a target can be written, and reading any of them.

use std::{
    fs::{self, File, OpenOptions},
    io::{ErrorKind, Read},
    panic::{self, AssertUnwindSafe},
    path::{Path, PathBuf},
    str::FromStr,
};

use anyhow::{Context, bail};

use crate::{atomic, image::Image, kept};

pub mod exr;
pub mod png;

/// Largest width and height of an image, pixels.
pub const MAX_SIDE: usize = 65_536;

/// File format by the extension of a file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: linear, scene-referred, with standard errors and metadata.
    Exr,
    /// PNG: 8 bits, sRGB, exposed.
    Png,
    /// Exact sums of rounds, for `mlt merge` and `--resume`.
    Sums,
    /// What a pilot found, for `--pilot`.
    Pilot,
}

/// A file to write, named by the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Where it goes.
    pub path: PathBuf,
    /// By its extension.
    pub format: Format,
}

impl OutputFile {
    /// Whether it is to hold sums; else an image.
    pub fn holds_sums(&self) -> bool {
        self.format == Format::Sums
    }
}

impl FromStr for OutputFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self { path, format: Format::Exr }),
            Some("png") => Ok(Self { path, format: Format::Png }),
            Some("mltp") => Ok(Self { path, format: Format::Sums }),
            _ => Err("the name has to end in .exr or .png, or in .mltp for 'mlt merge'".into()),
        }
    }
}

/// Finds out before a long run whether a file could be written at `path`; leaves nothing behind.
pub fn check_target(path: &Path) -> anyhow::Result<()> {
    let name = path.display();
    let path = &atomic::followed(path).with_context(|| name.to_string())?;
    let folder = atomic::folder_of(path);
    if !folder.is_dir() {
        bail!("{name}: the folder {} does not exist", folder.display());
    }
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => bail!("{name}: exists and is not a regular file"),
        Ok(_) => {
            OpenOptions::new().write(true).open(path).with_context(|| format!("{name}: cannot be overwritten"))?;
        }
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error).with_context(|| name.to_string()),
        Err(_) => {}
    }
    let temporary = tempfile::tempfile_in(&folder);
    temporary.map(drop).with_context(|| format!("{name}: cannot write in the folder {}", folder.display()))
}

/// Finds out before a long run whether the targets can be written, each to a file of its own.
pub fn check_targets(targets: &[OutputFile]) -> anyhow::Result<()> {
    targets.iter().try_for_each(|target| check_target(&target.path))?;
    check_apart(targets)
}

/// Finds out whether two of the targets are one file, by whatever names.
fn check_apart(targets: &[OutputFile]) -> anyhow::Result<()> {
    for (index, OutputFile { path, .. }) in targets.iter().enumerate() {
        for OutputFile { path: earlier, .. } in &targets[..index] {
            if path == earlier {
                bail!("{} is given twice", path.display());
            }
            if is_same_file(path, earlier).with_context(|| path.display().to_string())? {
                bail!(
                    "{} and {} are the same file; give each output a file of its own",
                    earlier.display(),
                    path.display()
                );
            }
        }
    }
    Ok(())
}

/// Whether two names lead to the same file, which need not exist yet.
fn is_same_file(a: &Path, b: &Path) -> std::io::Result<bool> {
    let [a, b] = [atomic::followed(a)?, atomic::followed(b)?];
    if a.exists() && b.exists() {
        return same_file::is_same_file(a, b);
    }
    Ok(a.file_name() == b.file_name() && same_file::is_same_file(atomic::folder_of(&a), atomic::folder_of(&b))?)
}

/// Reads an OpenEXR or PNG file, whichever its first bytes say, as linear Rec. 709.
pub fn read_image(path: &Path) -> anyhow::Result<(Image, Format)> {
    let format = format_of(path).with_context(|| path.display().to_string())?;
    let read = || match format {
        Format::Exr => Ok(exr::read(path)?.image),
        Format::Png => png::read(path),
        Format::Pilot => bail!("{}: what a pilot found, no image", path.display()),
        Format::Sums => bail!("{}: sums of rounds, no image; 'mlt merge' makes one of them", path.display()),
    };
    let image = without_panic(read).with_context(|| format!("{}: damaged", path.display()))??;
    Ok((image, format))
}

/// Runs a decoder; `None` when it panicked, which exr 1.74 does on some damaged B44 data. Says nothing on the terminal.
pub(crate) fn without_panic<T>(decode: impl FnOnce() -> T) -> Option<T> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    panic::set_hook(hook);
    result.ok()
}

/// The format that a file's first bytes say.
pub fn format_of(path: &Path) -> anyhow::Result<Format> {
    let mut start = Vec::new();
    File::open(path)?.take(8).read_to_end(&mut start)?;
    if start.starts_with(&exr::MAGIC) {
        Ok(Format::Exr)
    } else if start.starts_with(&png::MAGIC) {
        Ok(Format::Png)
    } else if start.starts_with(&kept::MAGIC) {
        Ok(Format::Sums)
    } else if start.starts_with(&kept::pilot::MAGIC) {
        Ok(Format::Pilot)
    } else {
        bail!("neither an OpenEXR nor a PNG file")
    }
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

    #[test]
    fn the_extension_names_the_format() {
        let format = |text: &str| text.parse::<OutputFile>().map(|file| file.format);
        assert_eq!(format("a.exr"), Ok(Format::Exr));
        assert_eq!(format("some.folder/A.PNG"), Ok(Format::Png));
        for bad in ["a", "a.jpg", "exr", ".png", "", "a.exr.gz"] {
            assert!(format(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_decoder_that_panics_is_survived() {
        assert_eq!(without_panic(|| 1), Some(1));
        assert_eq!(without_panic(|| [1, 2][std::hint::black_box(2)]), None);
    }

    #[test]
    fn a_target_is_checked_without_a_trace() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("a.exr");
        assert!(check_target(&target).is_ok());
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);

        fs::write(&target, "old").expect("written");
        assert!(check_target(&target).is_ok());
        assert_eq!(fs::read(&target).expect("kept"), b"old");
    }

    #[cfg(unix)]
    #[test]
    fn two_names_of_one_file_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| OutputFile { path: folder.path().join(name), format: Format::Exr };
        let refused = |a: &str, b: &str| check_apart(&[file(a), file(b)]).err().map(|error| error.to_string());
        fs::create_dir(folder.path().join("sub")).expect("made");
        assert_eq!(refused("a.exr", "b.exr"), None);
        assert!(refused("a.exr", "a.exr").is_some_and(|message| message.ends_with("a.exr is given twice")));
        assert!(refused("a.exr", "sub/../a.exr").is_some_and(|message| message.contains("are the same file")));

        std::os::unix::fs::symlink("a.exr", folder.path().join("link.exr")).expect("linked");
        assert!(refused("a.exr", "link.exr").is_some());
        fs::write(folder.path().join("a.exr"), "").expect("written");
        assert!(refused("a.exr", "link.exr").is_some());
        fs::hard_link(folder.path().join("a.exr"), folder.path().join("hard.exr")).expect("linked");
        assert!(refused("a.exr", "hard.exr").is_some());
        assert_eq!(refused("a.exr", "b.exr"), None);
    }

    #[test]
    fn a_target_that_cannot_be_written_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |path: PathBuf| format!("{:#}", check_target(&path).expect_err("refused"));
        assert!(message(folder.path().join("none/a.exr")).ends_with("none does not exist"));
        assert!(message(folder.path().to_path_buf()).ends_with("is not a regular file"));
        assert!(message(folder.path().join("a".repeat(300) + ".exr")).contains("too long"));
        fs::write(folder.path().join("file"), "").expect("written");
        assert!(message(folder.path().join("file/a.exr")).ends_with("file does not exist"));
    }
}
