//! Signals: Ctrl-C, and a limit on the size of files.

use std::{
    ops::ControlFlow,
    sync::{
        Arc, LazyLock,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use anyhow::Context;

use crate::atomic;

/// Makes a file that grows beyond the limit that the system sets (`ulimit -f`) an error like a full disk: by default its signal ends the
/// program, with what it had begun to write left behind.
pub fn outlive_file_limits() {
    #[cfg(unix)]
    // Without the signal's handler the program still works within the limit.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Number of the last signal that asked the program to stop; 0 where the system has none.
static SIGNAL: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);
/// The signal of Ctrl-C.
const SIGINT: usize = 2;

/// Exit code of a program that a signal stops: 128 and its number, as shells have it.
pub fn exit_code() -> u8 {
    let signal = match SIGNAL.load(Ordering::Relaxed) {
        0 => SIGINT,
        signal => signal,
    };
    128 + signal as u8
}

/// Tells whether the user (Ctrl-C) or the system (SIGTERM, SIGHUP) asked the program to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    stop: Arc<AtomicBool>,
    files: Arc<AtomicBool>,
}

impl Interrupt {
    /// From here on the first signal is only noted, to be polled; the second ends the program at once with its
    /// [`exit_code`]. Can be installed once in a process.
    pub fn install() -> anyhow::Result<Self> {
        let interrupt = Self::default();
        let noted = interrupt.clone();
        ctrlc::set_handler(move || {
            if noted.stop.swap(true, Ordering::Relaxed) {
                atomic::exit(exit_code().into());
            }
        })
        .context("cannot install the handler for Ctrl-C")?;
        #[cfg(unix)]
        note_numbers().context("cannot install the handlers of signals")?;
        Ok(interrupt)
    }

    /// From here on a signal SIGUSR1, where the system has it, is noted, too.
    pub fn heeding_requests(self) -> anyhow::Result<Self> {
        #[cfg(unix)]
        signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&self.files))
            .context("cannot install the handler of SIGUSR1")?;
        Ok(self)
    }

    /// Whether the files so far were asked for since the last time.
    pub fn files_are_wanted(&self) -> bool {
        self.files.swap(false, Ordering::Relaxed)
    }

    /// Breaks once the program was asked to stop.
    pub fn go_on(&self) -> ControlFlow<()> {
        if self.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// True once the program was asked to stop.
    pub fn requested(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Has the numbers of signals noted, beside what else they do.
#[cfg(unix)]
fn note_numbers() -> std::io::Result<()> {
    use signal_hook::{consts, flag};
    [consts::SIGINT, consts::SIGTERM, consts::SIGHUP]
        .into_iter()
        .try_for_each(|signal| flag::register_usize(signal, Arc::clone(&SIGNAL), signal as usize).map(drop))
}
