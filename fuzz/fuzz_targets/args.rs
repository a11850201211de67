//! Command lines, a word a line: understood or refused in one sentence, without a panic.
#![no_main]

use clap::{CommandFactory, FromArgMatches};
use libfuzzer_sys::fuzz_target;
use mlt_cli::args::{Cli, Command, line};
use std::cell::RefCell;
use std::ffi::OsString;

/// Builds all of the command line's grammar, which takes far longer than to read one line by it.
fn grammar() -> clap::Command {
    let mut grammar = Cli::command();
    grammar.build();
    grammar
}

thread_local!(static GRAMMAR: RefCell<clap::Command> = RefCell::new(grammar()));

fuzz_target!(|text: &str| {
    let words = std::iter::once("mlt").chain(text.lines()).map(OsString::from).collect();
    let Ok(words) = line::completed(words) else { return };
    let matches = GRAMMAR.with_borrow_mut(|grammar| grammar.try_get_matches_from_mut(words));
    if let Ok(Command::Render(options)) = matches.and_then(|matches| Cli::from_arg_matches(&matches)).map(|cli| cli.command) {
        let _ = (options.method(), options.check_together().is_ok(), options.images());
    }
});
