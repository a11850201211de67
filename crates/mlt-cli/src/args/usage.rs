//! Errors of a command line, in one sentence.

use std::num::ParseIntError;

use clap::{
    Arg, Args, Command, Error,
    error::{ContextKind, ContextValue, ErrorKind},
};
use mlt_scene::meant;

use super::render::RenderOptions;
use crate::{Failure, terminal};

/// Prints what clap shows on request (help, version); what it objects to becomes one sentence.
pub(crate) fn answer(error: &Error) -> Result<(), Failure> {
    let usage = |message: String| Err(Failure::Usage(anyhow::anyhow!(message)));
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            Ok(terminal::print_styled(&error.render().ansi().to_string())?)
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            usage("no command given; 'mlt render SCENE' renders, and 'mlt --help' tells of the rest".into())
        }
        _ => usage(sentence(error)),
    }
}

/// Clap's objection; its guess at what was meant is asked for only where that is near.
pub(crate) fn sentence(error: &Error) -> String {
    let named = |kind| match error.get(kind) {
        Some(ContextValue::String(name)) => Some(name.clone()),
        Some(ContextValue::Strings(names)) => names.first().cloned(),
        _ => None,
    };
    let question = |given: &str, offered: Option<String>| {
        let offered = offered.filter(|offered| meant(bare(given), &[bare(offered)]).is_some());
        offered.map(|offered| format!("; did you mean '{offered}'?"))
    };
    match (error.kind(), named(ContextKind::InvalidArg), named(ContextKind::InvalidSubcommand)) {
        (ErrorKind::UnknownArgument, Some(given), _) => {
            let question = question(&given, named(ContextKind::SuggestedArg));
            let otherwise = match command(error) {
                name if name == "mlt" && renders(&given) => {
                    format!("; it belongs to a command, as in 'mlt render {given}'")
                }
                name => format!("; see '{name} --help'"),
            };
            format!("unexpected argument '{given}' found{}", question.unwrap_or(otherwise))
        }
        (ErrorKind::InvalidSubcommand, _, Some(given)) => {
            let question = question(&given, named(ContextKind::SuggestedSubcommand));
            let otherwise = "; 'mlt --help' lists the commands, and 'mlt render SCENE' renders".into();
            format!("there is no command '{given}'{}", question.unwrap_or(otherwise))
        }
        (ErrorKind::ValueValidation, ..) => about_whole_number(error, one_sentence(&error.render().to_string())),
        _ => one_sentence(&error.render().to_string()),
    }
}

/// The same objection with a remedy where a whole number was asked for: clap gives the parser's words and bounds like 1..=64.
fn about_whole_number(error: &Error, sentence: String) -> String {
    let Some((start, reason)) = sentence.rsplit_once(": ") else { return sentence };
    let bounds = reason.split_once(" is not in ").and_then(|(_, bounds)| bounds.split_once("..="));
    let is_none = std::error::Error::source(error).is_some_and(|source| source.is::<ParseIntError>());
    match bounds {
        Some((low, high)) if high.len() < MOST_DIGITS => format!("{start}: give a whole number from {low} to {high}"),
        Some((low, _)) => format!("{start}: give a whole number from {low} on"),
        None if is_none => format!("{start}: give a whole number"),
        None => sentence,
    }
}

/// Digits of a bound that is worth telling; the largest number of a type is no bound to a reader.
const MOST_DIGITS: usize = 10;

/// A name without what marks it as an option.
fn bare(name: &str) -> &str {
    let name = name.trim_start_matches('-');
    name.split([' ', '=']).next().unwrap_or(name)
}

/// Whether `mlt render` has this option.
fn renders(option: &str) -> bool {
    let has_name = |argument: &Arg| {
        let names = argument.get_long_and_visible_aliases().unwrap_or_default();
        names.contains(&bare(option))
    };
    RenderOptions::augment_args(Command::new("render")).get_arguments().any(has_name)
}

/// The command whose usage clap shows, such as `mlt render`.
fn command(error: &Error) -> String {
    let text = error.render().to_string();
    let usage = text.split("Usage: ").nth(1).unwrap_or_default();
    let name = usage.split_whitespace().nth(1).filter(|word| word.starts_with(char::is_alphabetic));
    name.map_or_else(|| "mlt".into(), |name| format!("mlt {name}"))
}

/// The part of clap's message before its usage lines, on one line and without the leading "error: ".
pub(crate) fn one_sentence(text: &str) -> String {
    let end = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|mark| text.find(mark)).min();
    let message = text[..end.unwrap_or(text.len())].trim().trim_start_matches("error: ");
    message
        .split("\n\n")
        .map(|paragraph| paragraph.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect::<Vec<_>>()
        .join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Cli;

    fn said(line: &str) -> String {
        let words = std::iter::once("mlt").chain(line.split_whitespace());
        sentence(&<Cli as clap::Parser>::try_parse_from(words).expect_err(line))
    }

    #[test]
    fn only_near_names_are_asked_for() {
        for (line, sentence) in [
            ("render --sise 4x4", "unexpected argument '--sise' found; did you mean '--size'?"),
            ("render --spq 4", "unexpected argument '--spq' found; did you mean '--spp'?"),
            ("render --heigth=4", "unexpected argument '--heigth' found; did you mean '--height'?"),
            ("render --wdght 4", "unexpected argument '--wdght' found; see 'mlt render --help'"),
            ("diff --width 4", "unexpected argument '--width' found; see 'mlt diff --help'"),
            ("--spp 4", "unexpected argument '--spp' found; it belongs to a command, as in 'mlt render --spp'"),
            ("--zzzz 4", "unexpected argument '--zzzz' found; see 'mlt --help'"),
            ("rendr a.glb", "there is no command 'rendr'; did you mean 'render'?"),
        ] {
            assert_eq!(said(line), sentence);
        }
        for (line, remedy) in [
            ("render --seed x", "'x' for '--seed <N>': give a whole number"),
            ("render --seed=-1", "'-1' for '--seed <N>': give a whole number"),
            ("render --rounds-pilot 1", "'1' for '--rounds-pilot <N>': give a whole number from 2 to 64"),
            ("render --max-length 0", "'0' for '--max-length <EDGES>': give a whole number from 1 on"),
            ("render --rounds 1.5", "'1.5' for '--rounds <N>': give a whole number"),
        ] {
            assert_eq!(said(line), format!("invalid value {remedy}"));
        }
        assert!(said("paint").starts_with("there is no command 'paint'; 'mlt --help' lists"));
    }

    #[test]
    fn clap_messages_become_one_sentence() {
        let text = "error: unexpected argument '--sise' found\n\n  tip: a similar argument exists: '--size'\n\n\
                    Usage: mlt render --size <WxH>\n\nFor more information, try '--help'.\n";
        assert_eq!(one_sentence(text), "unexpected argument '--sise' found; tip: a similar argument exists: '--size'");
    }
}
