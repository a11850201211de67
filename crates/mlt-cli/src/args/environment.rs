//! Light from all around.

use std::{fmt, path::PathBuf, str::FromStr};

use clap::{Args, ValueEnum};
use mlt_core::transport::Rgb;
use mlt_scene::{EnvironmentOptions as Environment, EnvironmentSource};
use serde::{Serialize, Serializer};

use super::{
    heading,
    values::{finite, not_negative, point},
};

/// Light from all around.
#[derive(Args, Clone, Debug, Default, PartialEq, Serialize)]
pub struct EnvironmentOptions {
    /// Light from all around: an .hdr or .exr image, sky, none, or R,G,B
    ///
    /// An image is equirectangular; 'sky' is neutral, and brighter from above; R,G,B is the same radiance from everywhere. If not
    /// given, a neutral sky where nothing in the file gives light.
    #[arg(long, value_name = "LIGHT", help_heading = heading::SCENE)]
    pub environment: Option<Source>,
    /// Angle by which it is turned about the vertical, anticlockwise seen from above
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true, help_heading = heading::SCENE)]
    #[arg(hide_short_help = true)]
    pub environment_rotation: Option<f64>,
    /// Factor of its radiance
    #[arg(long, value_name = "FACTOR", value_parser = factor, help_heading = heading::SCENE)]
    #[arg(hide_short_help = true)]
    pub environment_strength: Option<f64>,
    /// Whether the camera sees the environment behind all surfaces
    ///
    /// The environment lights the scene in either case.
    #[arg(long, value_enum, help_heading = heading::SCENE)]
    #[arg(hide_short_help = true)]
    pub background: Option<Background>,
}

/// Largest radiance, and factor of it: products of a few stay finite in f32.
const MOST: f64 = 1e30;

/// A factor of radiance.
fn factor(text: &str) -> Result<f64, String> {
    let factor = not_negative(text)?;
    if factor <= MOST { Ok(factor) } else { Err(format!("give a number that is at most {MOST:e}")) }
}

/// The background of the image, behind all surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// The camera sees the environment
    Visible,
    /// The camera sees black
    Black,
}

impl EnvironmentOptions {
    /// For the loaders.
    pub fn of_loader(&self) -> Environment {
        let usual = Environment::default();
        Environment {
            source: self.environment.clone().map_or(usual.source, |source| source.0),
            rotation: self.environment_rotation.unwrap_or(usual.rotation),
            strength: self.environment_strength.map_or(usual.strength, |strength| strength as f32),
            visible: self.background != Some(Background::Black),
        }
    }
}

/// Where light from all around comes from, and how that is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Source(pub EnvironmentSource);

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const HELP: &str = "give an .hdr or .exr image, sky, none, or a radiance as in 1,1,1";
        let path = PathBuf::from(text);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let source = match (text, extension.as_deref()) {
            ("none", _) => EnvironmentSource::None,
            ("sky", _) => EnvironmentSource::Sky,
            (_, Some("hdr" | "exr")) => EnvironmentSource::Image(path),
            _ => {
                let radiance = point(text).map_err(|_| HELP)?;
                if radiance.iter().any(|x| !(0.0..=MOST).contains(x)) {
                    return Err(format!("radiance is not negative and at most {MOST:e}, as in 1,1,1"));
                }
                EnvironmentSource::Constant(Rgb::from_array(radiance.map(|x| x as f32)))
            }
        };
        Ok(Self(source))
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Serialize for Source {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources() {
        for text in ["none", "sky", "a b/Sunset.HDR", "x.exr", "1,0.5,0"] {
            assert_eq!(text.parse::<Source>().map(|source| source.to_string()), Ok(text.into()));
        }
        for bad in ["", "Sky", "dawn", "photo.jpg", "1,1", "-1,0,0", "1,nan,1", "1e300,0,0", "1,1,1,1"] {
            assert!(bad.parse::<Source>().is_err(), "{bad}");
        }
        assert_eq!(factor("1e30"), Ok(1e30));
        assert!(factor("1e31").is_err() && factor("-1").is_err());
    }
}
