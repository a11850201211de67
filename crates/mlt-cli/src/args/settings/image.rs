//! Options of a render from an image of it.

use std::path::Path;

use anyhow::{Context, anyhow};

use super::{SCENE, Setting};
use crate::output::{self, Format};

/// The settings that an image of ours records.
pub(super) fn settings(path: &Path) -> anyhow::Result<Vec<Setting>> {
    let read = Format::of_file(path).and_then(|format| output::read_attributes(path, format));
    // The file is named by whoever asks.
    let (_, attributes) = read.map_err(|error| anyhow!(error.root_cause().to_string()))?;
    let command = attributes.into_iter().find(|(name, _)| name == "mlt.command").map(|(_, command)| command);
    let words = command
        .as_deref()
        .and_then(shlex::split)
        .context("it holds no options of a render; name an image that mlt has made")?;
    settings_of(&words).context("the options in it are not understood")
}

/// The settings of a command line of `mlt render SCENE`.
fn settings_of(words: &[String]) -> Option<Vec<Setting>> {
    let [_, _, scene, options @ ..] = words else { return None };
    let mut settings = vec![(SCENE.to_owned(), vec![scene.clone()])];
    let mut options = options.iter();
    while let Some(word) = options.next() {
        let option = word.strip_prefix("--")?;
        let (name, value) = match option.split_once('=') {
            Some((name, value)) => (name, value.to_owned()),
            None => (option, options.next()?.clone()),
        };
        settings.push((name.to_owned(), vec![value]));
    }
    Some(settings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_as_a_shell_would() {
        let words = shlex::split("mlt render 'my room.glb' --method=pt --samples-per-pixel 64 --scene='it'\\''s'");
        let settings = settings_of(&words.expect("words")).expect("settings");
        let expected = [("file", "my room.glb"), ("method", "pt"), ("samples-per-pixel", "64"), ("scene", "it's")];
        assert_eq!(settings, expected.map(|(name, value)| (name.to_owned(), vec![value.to_owned()])));
        for bad in ["mlt render", "mlt render a.glb -o", "mlt render a.glb --seed"] {
            assert_eq!(settings_of(&shlex::split(bad).expect("words")), None, "{bad}");
        }
    }
}
