//! Why the program ends, and with which code.

use std::{fmt, process::ExitCode};

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

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(error) | Self::Run(error) | Self::InterruptedEarly(error) => write!(f, "{error:#}"),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl Failure {
    /// A run that failed, with a sentence that says why.
    pub(crate) fn run(message: String) -> Self {
        Self::Run(anyhow::anyhow!(message))
    }

    /// A render that is stopped before anything is worth keeping.
    pub(crate) fn too_early() -> Self {
        Self::InterruptedEarly(anyhow::anyhow!("interrupted before the first round was finished; nothing is written"))
    }

    /// Says on standard error what is wrong and gives the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        let code = match self {
            Self::Usage(_) => 2,
            Self::Run(_) => 1,
            Self::InterruptedEarly(_) => interrupt::exit_code(),
            Self::Interrupted => return ExitCode::from(interrupt::exit_code()),
        };
        terminal::complain("error", &self.to_string());
        ExitCode::from(code)
    }
}
