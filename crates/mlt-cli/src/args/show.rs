//! Options of what a render shows beside its image.

use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::heading;
use crate::output::OutputFile;

/// Where tev listens unless it is told otherwise.
const TEV: &str = "127.0.0.1:14158";

/// Options for what is seen beside the image, none of which changes it.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct ShowOptions {
    /// Further channels in OpenEXR files
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST", hide_short_help = true, help_heading = heading::OUTPUT)]
    pub aov: Vec<Aov>,
    /// Write a denoised image, FILE.denoised.EXT, beside each image
    ///
    /// By Open Image Denoise, if that is installed. It is biased, and marked so; the image itself stays as it is.
    #[arg(long, help_heading = heading::OUTPUT)]
    pub denoise: bool,
    /// Show the image so far in an image FILE or in the viewer tev
    ///
    /// FILE is replaced every few seconds; tev may be at another address, as in tev:HOST:PORT. May be given several times. The signal SIGUSR1
    /// has the files of --output written as they are so far.
    #[arg(long = "preview", value_name = "FILE|tev", help_heading = heading::OUTPUT)]
    pub previews: Vec<Preview>,
}

/// A quantity of a pixel that a further channel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Aov {
    /// albedo.R, .G, .B: reflectance, followed through mirrors and smooth glass
    Albedo,
    /// N.X, .Y, .Z: mean shading normal in world space, turned to the camera
    Normal,
    /// Z: distance of the first surface along the viewing direction, at the pixel's centre; 1e10 where there is none
    Depth,
    /// P.X, .Y, .Z: its world position; 0 where there is none
    Position,
    /// stratum: number of the stratum of --strata that most direct light comes from; -1 where none comes
    Stratum,
    /// stderr.R, .G, .B: standard error, which is always there
    Stderr,
    /// All of them
    All,
}

/// Where the image so far is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Preview {
    /// In a file.
    File(OutputFile),
    /// In a viewer at this address.
    Tev(String),
}

impl Preview {
    /// Its file, if it is one.
    pub fn file(&self) -> Option<&OutputFile> {
        match self {
            Self::File(file) => Some(file),
            Self::Tev(_) => None,
        }
    }
}

impl FromStr for Preview {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.strip_prefix("tev:")) {
            ("tev", _) => return Ok(Self::Tev(TEV.into())),
            (_, Some(address)) if address.contains(':') => return Ok(Self::Tev(address.into())),
            (_, Some(_)) => return Err("give tev's address with its port, as in tev:localhost:14158".into()),
            _ => {}
        }
        let file = text.parse::<OutputFile>().ok().filter(|file| !file.holds_sums() && !file.is_stdout());
        let help = "give a file name that ends in .png, .jpg, .hdr or .exr, or tev";
        file.map(Self::File).ok_or_else(|| help.into())
    }
}

impl ShowOptions {
    /// The channels that were asked for, each once.
    pub fn channels(&self) -> Vec<Aov> {
        let all = || Aov::value_variants().iter().copied().filter(|&aov| aov != Aov::All);
        let asked = |aov: &Aov| self.aov.contains(aov) || self.aov.contains(&Aov::All);
        all().filter(asked).collect()
    }

    /// Whether something is asked for that camera rays find.
    pub fn features(&self) -> bool {
        self.channels().iter().any(|&aov| aov != Aov::Stderr)
    }

    /// Files that previews go to.
    pub fn files(&self) -> impl Iterator<Item = &OutputFile> {
        self.previews.iter().filter_map(Preview::file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Format;

    #[test]
    fn channels_come_once_in_their_order() {
        let channels = |aov: &[Aov]| ShowOptions { aov: aov.to_vec(), ..ShowOptions::default() }.channels();
        assert_eq!(channels(&[Aov::Depth, Aov::Albedo, Aov::Depth]), [Aov::Albedo, Aov::Depth]);
        assert_eq!(channels(&[Aov::All]).len(), 6);
        assert_eq!(channels(&[]), []);
    }

    #[test]
    fn previews_are_files_or_tev() {
        let preview = |text: &str| text.parse::<Preview>();
        assert_eq!(preview("a.png"), Ok(Preview::File(OutputFile { path: "a.png".into(), format: Format::Png })));
        assert_eq!(preview("tev"), Ok(Preview::Tev(TEV.into())));
        assert_eq!(preview("tev:desk:7000"), Ok(Preview::Tev("desk:7000".into())));
        for bad in ["tev:desk", "a.mltp", "-", "png:-", "teve", ""] {
            assert!(preview(bad).is_err(), "{bad}");
        }
    }
}
