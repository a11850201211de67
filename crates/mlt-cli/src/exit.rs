//! Why the program ends, and with which code.

use std::process::ExitCode;

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
}
