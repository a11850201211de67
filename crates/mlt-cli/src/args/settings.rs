//! Options of a render from a file: `--config render.toml`, and `--like out.exr`.
//!
//! They are put before those of the command line, without what that says itself or contradicts.

use std::{ffi::OsString, fs, path::Path};

use anyhow::{Context, anyhow, bail};
use clap::{Arg, ArgAction, ArgMatches, Command, CommandFactory, Parser, error::ErrorKind, parser::ValueSource};
use mlt_scene::meant;
use toml::Value;

use super::Cli;
use crate::{Failure, output::exr, usage::sentence};

/// The name in a file of what has none on the command line.
const SCENE: &str = "file";
/// Options that only a command line has.
const OF_THE_LINE: [&str; 4] = ["config", "like", "help", "verbose"];
/// Options that say when a render ends, and those that go with them in an image's record.
const LIMITS: [&str; 4] = ["samples-per-pixel", "mutations-per-pixel", "time", "error"];
const ROUNDS: [&str; 2] = ["rounds", "first-round"];

/// An option and its values; none for a flag.
type Setting = (String, Vec<String>);

/// The words of a command line of `mlt render` with those of the files that it names.
pub(super) fn with_files(words: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    let Some(at) = words.iter().position(|word| word == "render") else { return Ok(words) };
    // What is wrong with the line is told by whoever parses it in the end.
    let matches = Cli::command().ignore_errors(true).try_get_matches_from(&words);
    let Some(given) = matches.as_ref().ok().and_then(|matches| matches.subcommand_matches("render")) else {
        return Ok(words);
    };
    let file = |name: &str| given.get_one::<std::path::PathBuf>(name);
    let mut program = Cli::command();
    program.build();
    let render = program.find_subcommand("render").context("there is no render")?;
    let mut taken = given_on_line(render, given);
    let mut more = Vec::new();
    for (name, settings) in [("config", of_config as fn(&Path) -> _), ("like", of_image)] {
        let Some(path) = file(name) else { continue };
        let named = || path.display().to_string();
        let mut settings: Vec<Setting> = settings(path).with_context(named).map_err(Failure::Usage)?;
        if name == "like" && taken.iter().any(|argument| argument.get_long().is_some_and(|long| LIMITS.contains(&long)))
        {
            // The rounds of a record are those of its budget.
            settings.retain(|(name, _)| !ROUNDS.contains(&name.as_str()));
        }
        more.extend(chosen(render, settings, &mut taken).with_context(named).map_err(Failure::Usage)?);
    }
    let (before, after) = words.split_at(at + 1);
    Ok([before, &more, after].concat())
}

/// The options that a command line gives.
fn given_on_line<'a>(render: &'a Command, given: &ArgMatches) -> Vec<&'a Arg> {
    let is_given = |argument: &&Arg| given.value_source(argument.get_id().as_str()) == Some(ValueSource::CommandLine);
    // Whether an option is there can only be asked of those that a parse knows.
    let known: Vec<_> = given.ids().map(|id| id.as_str().to_owned()).collect();
    render.get_arguments().filter(|a| known.iter().any(|id| id == a.get_id().as_str())).filter(is_given).collect()
}

/// The words of those settings that nothing before them gives or contradicts.
fn chosen<'a>(render: &'a Command, settings: Vec<Setting>, taken: &mut Vec<&'a Arg>) -> anyhow::Result<Vec<OsString>> {
    let mut own = Vec::new();
    let mut all = vec![OsString::from("mlt"), "render".into()];
    let mut words = Vec::new();
    for (name, values) in settings {
        let argument = argument(render, &name)?;
        let of_setting = as_words(argument, &name, values)?;
        all.extend(of_setting.clone());
        if !taken.iter().any(|other| excludes(render, argument, other)) {
            words.extend(of_setting);
            own.push(argument);
        }
    }
    taken.extend(own);
    match Cli::try_parse_from(all) {
        // What is missing may come from the command line.
        Err(error) if error.kind() != ErrorKind::MissingRequiredArgument => bail!(sentence(&error)),
        _ => Ok(words),
    }
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

/// The settings of a TOML file.
fn of_config(path: &Path) -> anyhow::Result<Vec<Setting>> {
    let text = fs::read_to_string(path).context("cannot be read")?;
    let table: toml::Table = toml::from_str(&text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        anyhow!("line {}: {}", before.matches('\n').count() + 1, error.message().replace('\n', ", "))
    })?;
    let setting = |(name, value): (String, Value)| match value {
        Value::Boolean(false) => Ok(None),
        Value::Boolean(true) => Ok(Some((name, Vec::new()))),
        Value::Array(values) => {
            let values = values.iter().map(|value| scalar(&name, value)).collect::<anyhow::Result<_>>()?;
            Ok(Some((name, values)))
        }
        value => scalar(&name, &value).map(|value| Some((name, vec![value]))),
    };
    table.into_iter().map(setting).filter_map(Result::transpose).collect()
}

fn scalar(name: &str, value: &Value) -> anyhow::Result<String> {
    match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        _ => bail!("{name}: give a text, a number, or a list of them"),
    }
}

/// The settings that an image of ours records.
fn of_image(path: &Path) -> anyhow::Result<Vec<Setting>> {
    let file = crate::output::without_panic(|| exr::read(path)).context("damaged")??;
    let command = file.attributes.into_iter().find(|(name, _)| name == "mlt.command").map(|(_, command)| command);
    let words = command
        .as_deref()
        .and_then(shlex::split)
        .context("it holds no options of a render; name an EXR that mlt has made")?;
    let [_, _, scene, options @ ..] = &words[..] else { bail!("the options in it are not understood") };
    let option = |word: &String| {
        let (name, value) = word.strip_prefix("--")?.split_once('=')?;
        Some((name.to_owned(), vec![value.to_owned()]))
    };
    let options = options.iter().map(option).collect::<Option<Vec<_>>>();
    Ok([vec![(SCENE.to_owned(), vec![scene.clone()])], options.context("the options in it are not understood")?]
        .concat())
}
