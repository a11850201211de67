//! How a scene is read from its file.
//!
//! [`SceneOptions`] stands in every command that loads scenes: a new option is a field here and a line in
//! [`SceneOptions::load_options`].

use clap::{Args, Command};
use mlt_scene::LoadOptions;
use serde::Serialize;

use super::written::written;

/// How a scene is read from its file.
#[derive(Args, Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneOptions {
    /// The scene of a glTF file to show, by its name; the file's default one if not given
    #[arg(long = "scene", value_name = "NAME", help_heading = "Scene")]
    #[serde(rename = "scene")]
    pub scene_name: Option<String>,
}

impl SceneOptions {
    /// Options of the loaders.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions { scene: self.scene_name.clone() }
    }

    /// As words of a command line.
    pub fn words(&self) -> anyhow::Result<Vec<String>> {
        let word = |(name, value): (String, String)| format!("--{}={value}", name.replace('_', "-"));
        Ok(written(self)?.into_iter().map(word).collect())
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
        let options = parse(vec!["--scene=a room, 'lit'".into()]);
        assert_eq!(parse(options.words().expect("written")), options);
        assert_eq!(options.load_options().scene.as_deref(), Some("a room, 'lit'"));
        assert!(SceneOptions::default().words().expect("written").is_empty());
        assert!(SceneOptions::have("scene") && !SceneOptions::have("size"));
    }
}
