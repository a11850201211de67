//! Why the program ends, and with which code.

use std::process::ExitCode;

use clap::error::ErrorKind;

use crate::{interrupt, terminal};

/// A run that did not succeed.
#[derive(Debug)]
pub enum Failure {
    /// Wrong arguments: exit code 2.
    Usage(anyhow::Error),
    /// Right arguments, but the run failed: exit code 1.
    Run(anyhow::Error),
    /// Stopped by a signal; what was done so far is written and already reported: exit code 128 + the signal.
    Interrupted,
    /// Stopped by a signal with nothing to show: the same.
    InterruptedEarly(anyhow::Error),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Run(error)
    }
}

impl Failure {
    /// A run that failed, with a sentence that says why.
    pub(crate) fn run(message: String) -> Self {
        Self::Run(anyhow::anyhow!(message))
    }

    /// Says on standard error what is wrong and gives the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        let (error, code) = match self {
            Self::Usage(error) => (error, 2),
            Self::Run(error) => (error, 1),
            Self::InterruptedEarly(error) => (error, interrupt::exit_code()),
            Self::Interrupted => return ExitCode::from(interrupt::exit_code()),
        };
        terminal::complain("error", &format!("{error:#}"));
        ExitCode::from(code)
    }

    /// Prints what clap shows on request (help, version); what it objects to becomes one sentence.
    pub(crate) fn from_clap(error: &clap::Error) -> Result<(), Self> {
        let text = error.render().to_string();
        match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Ok(terminal::print(&text)?),
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                Err(Self::Usage(anyhow::anyhow!("no command given; see 'mlt --help'")))
            }
            _ => Err(Self::Usage(anyhow::anyhow!(one_sentence(&text)))),
        }
    }
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

    #[test]
    fn clap_messages_become_one_sentence() {
        let text = "error: unexpected argument '--sise' found\n\n  tip: a similar argument exists: '--size'\n\n\
                    Usage: mlt render --size <WxH>\n\nFor more information, try '--help'.\n";
        assert_eq!(one_sentence(text), "unexpected argument '--sise' found; tip: a similar argument exists: '--size'");
    }
}
