//! Ctrl-C.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use anyhow::Context;

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

    /// True once the program was asked to stop.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
