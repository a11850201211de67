//! A method as named on the command line: `METHOD[:STRATA][:OPTION=VALUE]…`.

use std::{ffi::OsString, fmt, path::Path, str::FromStr};

use clap::{Arg, Args, Command, FromArgMatches};

use super::{render::RenderOptions, scene::SceneOptions, usage::sentence};

/// Options that all runs of a study share beside [`SceneOptions`], and that a method can therefore not have for itself.
const SHARED: [&str; 26] = [
    "output",
    "force",
    "config",
    "like",
    "max-length",
    "mutations-per-pixel",
    "samples-per-pixel",
    "time",
    "error",
    "first-round",
    "checkpoint",
    "checkpoint-every",
    "resume",
    "shard",
    "seed",
    "threads",
    "size",
    "width",
    "height",
    "camera",
    "camera-from",
    "camera-to",
    "fov",
    "aperture",
    "focus",
    "exposure",
];

/// One of the things to compare: a command line of `mlt render` without what the study decides.
///
/// `mlt:4x4:importance=luminance` stands for `--method mlt --strata 4x4 --importance luminance`. What is valid is decided
/// by the parser of `mlt render` alone, so that every method and option of it can be compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contestant {
    text: String,
    words: Vec<String>,
}

impl Contestant {
    /// The options of a render of `scene`, with `more` words of its command line.
    pub fn render_options(&self, scene: &Path, more: &[String]) -> Result<RenderOptions, String> {
        let words = self.words.iter().chain(more).map(OsString::from);
        parse(words.chain([OsString::from("--quiet"), OsString::from("--"), scene.into()]))
    }
}

impl Default for Contestant {
    /// The default of `mlt render SCENE`, under the name of its method.
    fn default() -> Self {
        let unnamed = Self { text: String::new(), words: Vec::new() };
        let method = unnamed.render_options(Path::new("cornell"), &[]).ok().map(|options| options.method().to_string());
        Self { text: method.unwrap_or_default(), ..unnamed }
    }
}

impl FromStr for Contestant {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let mut words = vec![format!("--method={}", parts.next().unwrap_or_default())];
        for (index, part) in parts.enumerate() {
            match part.split_once('=') {
                Some((name, _)) if is_shared(name) => {
                    return Err(format!("'{name}' is the same for all methods; give it as an option of 'mlt bench'"));
                }
                Some((name, value)) => words.push(format!("--{name}={value}")),
                None if index == 0 => words.push(format!("--strata={part}")),
                None => return Err("give METHOD, METHOD:STRATA or METHOD:STRATA:OPTION=VALUE, as in mlt:4x4".into()),
            }
        }
        let contestant = Self { text: text.to_owned(), words };
        contestant.render_options(Path::new("cornell"), &[])?;
        Ok(contestant)
    }
}

impl fmt::Display for Contestant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Whether all runs of a study have the same value of an option, by whichever of its names.
fn is_shared(name: &str) -> bool {
    let command = RenderOptions::augment_args(Command::new("render"));
    let has_name = |argument: &&Arg| {
        argument.get_long() == Some(name) || argument.get_all_aliases().is_some_and(|names| names.contains(&name))
    };
    let long = command.get_arguments().find(has_name).and_then(Arg::get_long).unwrap_or(name);
    SHARED.contains(&long) || SceneOptions::have(long)
}

fn parse(words: impl Iterator<Item = OsString>) -> Result<RenderOptions, String> {
    let command = RenderOptions::augment_args(Command::new("mlt render").no_binary_name(true));
    let matches = command.try_get_matches_from(words);
    let options = matches.and_then(|matches| RenderOptions::from_arg_matches(&matches));
    options.map_err(|error| sentence(&error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::transport::Method;

    fn options(text: &str) -> Result<RenderOptions, String> {
        text.parse::<Contestant>()?.render_options(Path::new("-a scene"), &["--seed=3".into()])
    }

    #[test]
    fn a_contestant_is_a_command_line_of_render() {
        let found = options("bdpt").expect("valid");
        assert_eq!(
            (found.method(), found.transport.seed, found.scene.as_path()),
            (Method::Bdpt, 3, Path::new("-a scene"))
        );
        let found = options("mlt:4x3:importance=luminance:rounds=4").expect("valid");
        assert_eq!((found.transport.strata.to_string(), found.rounds), ("4x3".to_owned(), Some(4)));
        assert_eq!(options("mlt:rounds=4").map(|options| options.rounds), Ok(Some(4)));
    }

    #[test]
    fn by_default_it_is_what_render_does_by_itself() {
        let (found, plain) = (Contestant::default(), "auto".parse::<Contestant>().expect("valid"));
        let options = |contestant: &Contestant| contestant.render_options(Path::new("cornell"), &[]).expect("valid");
        assert_eq!((found.to_string(), options(&found).method), ("auto".into(), None));
        assert_eq!(options(&found).method(), options(&plain).method());
    }

    #[test]
    fn what_render_would_refuse_is_refused_in_its_words() {
        for (text, part) in [
            ("photon", "invalid value 'photon' for '--method"),
            ("", "--method"),
            ("mlt:x9", "as in 4x4"),
            ("mlt:4x4:4x4", "as in mlt:4x4"),
            ("mlt:colour=red", "'--colour'"),
            ("mlt:rounds=0", "--rounds"),
            ("mlt:seed=4", "'seed' is the same for all methods"),
            ("mlt:spp=4", "'spp' is the same for all methods"),
            ("mlt:output=a.exr", "'output' is the same"),
            ("mlt:scene=night", "'scene' is the same"),
            ("mlt:json=1", "--json"),
        ] {
            let message = text.parse::<Contestant>().map(|contestant| contestant.to_string()).expect_err(text);
            assert!(message.contains(part) && !message.contains('\n'), "{text}: {message}");
        }
    }
}
