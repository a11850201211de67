//! Formats of files, by their names and by their first bytes.

use std::{fs::File, io::Read, path::Path};

use anyhow::bail;

use super::{exr, hdr, jpg, png};
use crate::kept;

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: linear, scene-referred, with standard errors and metadata.
    Exr,
    /// Radiance: linear, scene-referred, a byte a channel and one for their exponent.
    Hdr,
    /// PNG: 8 bits, sRGB, exposed.
    Png,
    /// JPEG: 8 bits, sRGB, exposed, lossy.
    Jpg,
    /// Exact sums of rounds, for `mlt merge` and `--resume`.
    Sums,
    /// A pilot's findings, for `--pilot`.
    Pilot,
}

impl Format {
    /// The format that files with this extension have.
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension.to_lowercase().as_str() {
            "exr" => Some(Self::Exr),
            "hdr" => Some(Self::Hdr),
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpg),
            "mltp" => Some(Self::Sums),
            _ => None,
        }
    }

    /// The format that a file's first bytes say.
    pub fn of_file(path: &Path) -> anyhow::Result<Self> {
        let mut start = Vec::new();
        File::open(path)?.take(8).read_to_end(&mut start)?;
        match Self::of_start(&start) {
            Some(format) => Ok(format),
            None => bail!("neither an OpenEXR nor a Radiance HDR, PNG or JPEG file"),
        }
    }

    /// The format of a file that begins with these bytes.
    pub(super) fn of_start(start: &[u8]) -> Option<Self> {
        let all = [
            (&exr::MAGIC[..], Self::Exr),
            (&hdr::MAGIC, Self::Hdr),
            (&png::MAGIC, Self::Png),
            (&jpg::MAGIC, Self::Jpg),
            (&kept::MAGIC, Self::Sums),
            (&kept::pilot::MAGIC, Self::Pilot),
        ];
        all.iter().find(|(magic, _)| start.starts_with(magic)).map(|&(_, format)| format)
    }

    /// A file of it, in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Exr => "an OpenEXR",
            Self::Hdr => "a Radiance HDR",
            Self::Png => "a PNG",
            Self::Jpg => "a JPEG",
            Self::Sums | Self::Pilot => "no",
        }
    }

    /// Whether its pixels are encoded for a screen; else they are linear, if there are any.
    pub fn is_for_screens(self) -> bool {
        matches!(self, Self::Png | Self::Jpg)
    }
}
