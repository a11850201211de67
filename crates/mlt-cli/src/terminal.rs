//! Writing to standard output and standard error without panics.

use std::io::{self, ErrorKind, Write};

use anyhow::Context;
use mlt_scene::{MOST_OF_A_MESSAGE, printable};

/// The most warnings that are shown.
const MOST_WARNINGS: usize = 20;

/// Writes to standard output. A reader that has gone (`mlt … | head`) is not an error.
pub fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// Writes a warning to standard error.
pub fn warn(text: &str) {
    complain("warning", text);
}

/// Writes warnings to standard error, and of very many only how many more there are.
pub fn warn_all(warnings: &[String]) {
    let (shown, rest) = warnings.split_at(warnings.len().min(MOST_WARNINGS));
    shown.iter().for_each(|warning| warn(warning));
    if !rest.is_empty() {
        warn(&format!("{} further warnings are left out; a render with --json lists all", rest.len()));
    }
}

/// One line on standard error, fit for a terminal whatever the text is. Nobody is left to tell when that fails.
pub(crate) fn complain(kind: &str, text: &str) {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let _ = writeln!(io::stderr(), "{kind}: {}", printable(&line, MOST_OF_A_MESSAGE));
}
