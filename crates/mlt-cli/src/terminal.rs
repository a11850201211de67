//! Writing to standard output and standard error without panics.

use std::io::{ErrorKind, Write, stdout};

use anstream::{AutoStream, ColorChoice};
use anstyle::{AnsiColor, Style};
use anyhow::Context;
use mlt_scene::{MOST_OF_A_MESSAGE, printable};

/// The most warnings that are shown.
const MOST_WARNINGS: usize = 20;

/// Decides whether messages and help have colours from here on; by itself where the terminal shows them, unless NO_COLOR is set.
pub(crate) fn choose_colour(choice: ColorChoice) {
    choice.write_global();
}

/// Writes text with escape sequences for colours to standard output, without them where they are not wanted.
pub(crate) fn print_styled(text: &str) -> anyhow::Result<()> {
    let mut plain = AutoStream::new(Vec::new(), AutoStream::choice(&stdout()));
    plain.write_all(text.as_bytes()).context("cannot make the text plain")?;
    print(&String::from_utf8_lossy(&plain.into_inner()))
}

/// Writes to standard output. A reader that has gone (`mlt … | head`) is not an error.
pub fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// Writes to standard error. Nobody is left to tell when that fails.
pub fn tell(text: &str) {
    let _ = anstream::stderr().write_all(text.as_bytes());
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

/// One line on standard error, fit for a terminal whatever the text is.
pub(crate) fn complain(kind: &str, text: &str) {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let colour = if kind == "error" { AnsiColor::Red } else { AnsiColor::Yellow };
    let style = Style::new().fg_color(Some(colour.into())).bold();
    let _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {}", printable(&line, MOST_OF_A_MESSAGE));
}
