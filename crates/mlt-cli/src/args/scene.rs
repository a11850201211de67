//! How a scene is read from its file.
//!
//! [`SceneOptions`] stands in every command that loads scenes: a new option is a field here and a line in
//! [`SceneOptions::load_options`].

use clap::{Args, Command, ValueEnum};
use mlt_scene::{Glass, LoadOptions};
use serde::Serialize;

use super::{
    environment::EnvironmentOptions,
    heading,
    written::{words, written},
};

/// How to take surfaces that transmit light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum GlassKind {
    /// Solids where their meshes are closed, else thin walls
    #[default]
    Auto,
    /// Thin walls
    Thin,
    /// Solids
    Solid,
}

impl From<GlassKind> for Glass {
    fn from(kind: GlassKind) -> Self {
        match kind {
            GlassKind::Auto => Self::Auto,
            GlassKind::Thin => Self::Thin,
            GlassKind::Solid => Self::Solid,
        }
    }
}

/// Units of lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LightUnits {
    /// Candela and lux that stand for Blender's watts, at 683 lumens a watt
    Blender,
    /// Candela and lux as they are, or Blender's unitless ones
    Photometric,
    /// Watts, of suns W/m², that Blender did not convert
    Raw,
}

impl From<LightUnits> for mlt_scene::LightUnits {
    fn from(units: LightUnits) -> Self {
        match units {
            LightUnits::Blender => Self::Blender,
            LightUnits::Photometric => Self::Photometric,
            LightUnits::Raw => Self::Raw,
        }
    }
}

/// A time in an animation.
fn moment(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds >= 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("give seconds from the animation's beginning, as in 1.5".into()),
    }
}

/// How a scene is read from its file.
#[derive(Args, Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneOptions {
    /// Light from all around.
    #[command(flatten)]
    #[serde(flatten)]
    pub environment: EnvironmentOptions,
    /// The scene of a glTF file to show, by its name; the file's default one if not given
    #[arg(long = "scene", value_name = "NAME", help_heading = heading::FILES, hide_short_help = true)]
    #[serde(rename = "scene")]
    pub scene_name: Option<String>,
    /// Glass of a glTF file without KHR_materials_volume: a solid where its mesh is closed (auto), a thin wall, or a solid
    #[arg(long, value_enum, value_name = "KIND", help_heading = heading::FILES, hide_short_help = true)]
    pub glass: Option<GlassKind>,
    /// Time in a glTF file's animations, in seconds; without it the file is shown as it stands at rest
    #[arg(long, value_name = "SECONDS", value_parser = moment, help_heading = heading::FILES, hide_short_help = true)]
    pub time_in_animation: Option<f64>,
    /// Units of point, spot and directional lights in a glTF file
    ///
    /// If not given, they are those of the program that wrote the file. A file that Blender did not write has photometric ones.
    #[arg(long, value_enum, value_name = "UNITS", help_heading = heading::FILES, hide_short_help = true)]
    pub light_units: Option<LightUnits>,
}

impl SceneOptions {
    /// Options of the loaders.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions {
            scene: self.scene_name.clone(),
            environment: self.environment.of_loader(),
            time_in_animation: self.time_in_animation,
            light_units: self.light_units.map(LightUnits::into),
            glass: self.glass.unwrap_or_default().into(),
            ..LoadOptions::default()
        }
    }

    /// As words of a command line.
    pub fn words(&self) -> anyhow::Result<Vec<String>> {
        Ok(words(&written(self)?))
    }

    /// Whether an option has this name.
    pub fn have(name: &str) -> bool {
        let command = Self::augment_args(Command::new("scene"));
        command.get_arguments().any(|argument| argument.get_long() == Some(name))
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: SceneOptions,
    }

    #[test]
    fn options_become_words_and_back() {
        let parse = |words: Vec<String>| Line::parse_from([vec!["mlt".to_owned()], words].concat()).options;
        let words = [
            "--scene=a room, 'lit'",
            "--time-in-animation=1.5",
            "--light-units=raw",
            "--environment=1,0.5,0",
            "--environment-rotation=-30",
            "--environment-strength=2.5",
            "--background=black",
        ];
        let options = parse(words.map(str::to_owned).to_vec());
        assert_eq!(options.words().expect("written").len(), words.len());
        assert_eq!(parse(options.words().expect("written")), options);
        assert_eq!(options.load_options().scene.as_deref(), Some("a room, 'lit'"));
        assert!(SceneOptions::default().words().expect("written").is_empty());
        assert!(SceneOptions::have("scene") && !SceneOptions::have("size"));
    }
}
