//! A command line, completed before it is parsed.

use std::{
    ffi::{OsStr, OsString},
    path::Path,
};

use clap::ValueEnum;
use mlt_scene::{BUILTIN, is_scene_file};

use super::{Colour, settings};
use crate::Failure;

/// The command line that is meant: a scene without a command is rendered, with the options of the files that it names.
pub fn completed(mut words: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    let is_option = |word: &OsString| word.as_encoded_bytes().starts_with(b"-");
    if words.iter().skip(1).find(|word| !is_option(word)).is_some_and(|word| is_scene(word)) {
        words.insert(1, "render".into());
    }
    settings::with_files(words)
}

fn is_scene(word: &OsStr) -> bool {
    is_scene_file(Path::new(word)) || BUILTIN.iter().any(|scene| word == scene.name)
}

/// The choice of colours, whatever is wrong with the rest.
pub fn colour(words: &[OsString]) -> Colour {
    let value = |index: usize| match words[index].to_str()? {
        "--color" => words.get(index + 1)?.to_str(),
        word => word.strip_prefix("--color="),
    };
    let given = (0..words.len()).find_map(value);
    given.and_then(|value| Colour::from_str(value, false).ok()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split_whitespace().map(OsString::from).collect()
    }

    #[test]
    fn a_scene_alone_is_rendered() {
        for (line, completed_line) in [
            ("mlt room.glb", "mlt render room.glb"),
            ("mlt some/Room.GLTF -o a.png", "mlt render some/Room.GLTF -o a.png"),
            ("mlt -v --json cornell", "mlt render -v --json cornell"),
            ("mlt verify room.glb", "mlt verify room.glb"),
            ("mlt -o a.png", "mlt -o a.png"),
            ("mlt rendr room.glb", "mlt rendr room.glb"),
            ("mlt", "mlt"),
        ] {
            assert_eq!(completed(words(line)).expect("completed"), words(completed_line));
        }
    }

    #[test]
    fn colours_are_chosen_in_either_form() {
        assert_eq!(colour(&words("mlt rendr --color never")), Colour::Never);
        assert_eq!(colour(&words("mlt --color=always --help")), Colour::Always);
        assert_eq!(colour(&words("mlt render --color")), Colour::Auto);
        assert_eq!(colour(&words("mlt --color=sometimes")), Colour::Auto);
    }
}
