//! Signals: Ctrl-C, and a limit on the size of files.

use std::{
    ops::ControlFlow,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::Context;

/// Makes a file that grows beyond the limit that the system sets (`ulimit -f`) an error like a full disk: by default its signal ends the
/// program, with what it had begun to write left behind.
pub fn outlive_file_limits() {
    #[cfg(unix)]
    // Without the signal's handler the program still works within the limit.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Tells whether the user (Ctrl-C) or the system (SIGTERM, SIGHUP) asked the program to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From here on the first signal is only noted, to be polled; the second ends the program at once with exit code
    /// 130. Can be installed once in a process.
    pub fn install() -> anyhow::Result<Self> {
        let interrupt = Self::default();
        let noted = interrupt.clone();
        ctrlc::set_handler(move || {
            if noted.0.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        })
        .context("cannot install the handler for Ctrl-C")?;
        Ok(interrupt)
    }

    /// Breaks once the program was asked to stop.
    pub fn go_on(&self) -> ControlFlow<()> {
        if self.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// True once the program was asked to stop.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
