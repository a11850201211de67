//! Options of a render from a file: `--config render.toml`, and `--like out.exr`.
//!
//! They are put before those of the command line, without what that says itself or contradicts.

mod config;
mod image;

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

use anyhow::{Context, anyhow, bail};
use clap::{Arg, ArgAction, ArgMatches, Command, CommandFactory, Parser, error::ErrorKind, parser::ValueSource};
use mlt_scene::meant;

use super::{Cli, heading, usage::sentence};
use crate::Failure;

/// The name in a file of what has none on the command line.
const SCENE: &str = "file";
/// The options that name a file of options.
const FILES: [&str; 2] = ["--config", "--like"];
/// Options that only a command line has.
const OF_THE_LINE: [&str; 4] = ["config", "like", "help", "verbose"];
/// Options that say when a render ends, and those that go with them in an image's record.
const LIMITS: [&str; 4] = ["samples-per-pixel", "mutations-per-pixel", "time", "error"];
const ROUNDS: [&str; 2] = ["rounds", "first-round"];

/// An option and its values; none for a flag.
type Setting = (String, Vec<String>);

/// The words of a command line of `mlt render` with those of the files that it names.
pub(super) fn with_files(words: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    let names_a_file = |word: &OsString| FILES.iter().any(|name| word.as_encoded_bytes().starts_with(name.as_bytes()));
    let Some(at) = words.iter().position(|word| word == "render") else { return Ok(words) };
    // Most lines name no file, and the grammar takes longer to build than to use.
    if !words.iter().any(names_a_file) {
        return Ok(words);
    }
    // What is wrong with the line is told by whoever parses it in the end.
    let matches = Cli::command().ignore_errors(true).try_get_matches_from(&words);
    let Some(given) = matches.as_ref().ok().and_then(|matches| matches.subcommand_matches("render")) else {
        return Ok(words);
    };
    let mut program = Cli::command();
    program.build();
    let render = program.find_subcommand("render").context("there is no render")?;
    let mut line = Line { render, taken: given_on_line(render, given), more: Vec::new() };
    let file = |name: &str| given.get_one::<PathBuf>(name);
    if let Some(path) = file("config") {
        line.add(path, config::settings)?;
    }
    if let Some(path) = file("like") {
        // The rounds of a record are those of its budget.
        let limited = line.taken.iter().any(|argument| argument.get_long().is_some_and(|long| LIMITS.contains(&long)));
        line.add(path, |path| {
            let mut settings = image::settings(path)?;
            settings.retain(|(name, _)| !limited || !ROUNDS.contains(&name.as_str()));
            settings.retain(|(name, _)| may_be_recorded(render, name));
            Ok(settings)
        })?;
    }
    let (before, after) = words.split_at(at + 1);
    Ok([before, &line.more, after].concat())
}

/// A command line of `mlt render` that options are added to.
struct Line<'a> {
    render: &'a Command,
    /// The options that it has.
    taken: Vec<&'a Arg>,
    /// The words that are added.
    more: Vec<OsString>,
}

impl Line<'_> {
    /// Adds those settings of a file that nothing before them gives or contradicts.
    fn add(
        &mut self,
        path: &Path,
        settings: impl FnOnce(&Path) -> anyhow::Result<Vec<Setting>>,
    ) -> Result<(), Failure> {
        let added = settings(path).and_then(|settings| self.add_settings(settings));
        added.with_context(|| path.display().to_string()).map_err(Failure::Usage)
    }

    fn add_settings(&mut self, settings: Vec<Setting>) -> anyhow::Result<()> {
        let (mut own, mut all) = (Vec::new(), vec![OsString::from("mlt"), "render".into()]);
        for (name, values) in settings {
            let argument = argument(self.render, &name)?;
            let words = as_words(argument, &name, values)?;
            all.extend(words.clone());
            if !self.taken.iter().any(|other| excludes(self.render, argument, other)) {
                self.more.extend(words);
                own.push(argument);
            }
        }
        self.taken.extend(own);
        match Cli::try_parse_from(all) {
            // What is missing may come from the command line.
            Err(error) if error.kind() != ErrorKind::MissingRequiredArgument => bail!(sentence(&error)),
            _ => Ok(()),
        }
    }
}

/// The options that a command line gives.
fn given_on_line<'a>(render: &'a Command, given: &ArgMatches) -> Vec<&'a Arg> {
    let is_given = |argument: &&Arg| given.value_source(argument.get_id().as_str()) == Some(ValueSource::CommandLine);
    // Whether an option is there can only be asked of those that a parse knows.
    let known: Vec<_> = given.ids().map(|id| id.as_str().to_owned()).collect();
    render.get_arguments().filter(|a| known.iter().any(|id| id == a.get_id().as_str())).filter(is_given).collect()
}

/// Whether an image may say an option: none of those that name files to write or to read options from, which is not for whoever made it
/// to decide.
fn may_be_recorded(render: &Command, name: &str) -> bool {
    let heading = argument(render, name).ok().and_then(Arg::get_help_heading);
    heading.is_none_or(|under| ![heading::OUTPUT, heading::OPTIONS, heading::PARTS].contains(&under))
}

/// The option of this name, as on the command line, with `_` for `-` as well.
fn argument<'a>(render: &'a Command, name: &str) -> anyhow::Result<&'a Arg> {
    let long = name.replace('_', "-");
    let has_name = |a: &&Arg| match a.get_long() {
        None => a.is_positional() && long == SCENE,
        Some(own) => own == long || a.get_all_aliases().is_some_and(|names| names.contains(&&*long)),
    };
    if OF_THE_LINE.contains(&&*long) {
        bail!("{name} belongs on the command line; leave it out of the file");
    }
    render.get_arguments().find(has_name).ok_or_else(|| {
        let names: Vec<_> = render.get_arguments().filter_map(Arg::get_long).chain([SCENE]).collect();
        let question = meant(&long, &names).map_or_else(
            || "its names are the long options of 'mlt render --help', and file for the scene".to_owned(),
            |other| format!("did you mean {other}?"),
        );
        anyhow!("there is no option {name}; {question}")
    })
}

fn as_words(argument: &Arg, name: &str, values: Vec<String>) -> anyhow::Result<Vec<OsString>> {
    let Some(long) = argument.get_long() else {
        // A name like an option's is still a name.
        let scene = values.concat();
        return Ok(vec![if scene.starts_with('-') { format!("./{scene}") } else { scene }.into()]);
    };
    match (argument.get_action(), &values[..]) {
        (ArgAction::SetTrue, []) => Ok(vec![format!("--{long}").into()]),
        (ArgAction::SetTrue, _) => bail!("{name} is true or false"),
        (_, []) => bail!("{name} needs a value"),
        (ArgAction::Append, values) => Ok(values.iter().map(|value| format!("--{long}={value}").into()).collect()),
        (_, values) => Ok(vec![format!("--{long}={}", values.join(",")).into()]),
    }
}

/// Whether an option has no place beside another one.
fn excludes(render: &Command, a: &Arg, b: &Arg) -> bool {
    let (ids, conflicts) = ([a.get_id(), b.get_id()], |x, y: &Arg| {
        render.get_arg_conflicts_with(x).iter().any(|other| other.get_id() == y.get_id())
    });
    let of_one_group = render.get_groups().any(|group| {
        let members: Vec<_> = group.get_args().collect();
        !group.clone().is_multiple() && ids.iter().all(|id| members.contains(id))
    });
    ids[0] == ids[1] || of_one_group || conflicts(a, b) || conflicts(b, a)
}
