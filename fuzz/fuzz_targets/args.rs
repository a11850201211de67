//! Command lines, a word a line: understood or refused in one sentence, without a panic.
#![no_main]

use clap::Parser;
use libfuzzer_sys::fuzz_target;
use mlt_cli::args::{Cli, Command, line};
use std::ffi::OsString;

fuzz_target!(|text: &str| {
    let words = std::iter::once("mlt").chain(text.lines()).map(OsString::from).collect();
    let Ok(words) = line::completed(words) else { return };
    if let Ok(Command::Render(options)) = Cli::try_parse_from(words).map(|cli| cli.command) {
        let _ = (options.method(), options.check_together().is_ok(), options.images());
    }
});
