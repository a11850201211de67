//! The file that a render under way is kept in.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use mlt_core::transport::render::Sums;
use tracing::info;

use crate::{
    args::kept::KeptOptions,
    kept::{self, About},
    output::atomic,
    warn,
};

/// Writes the sums of a render to a file, time and again.
pub(super) struct Checkpoint<'a> {
    path: Option<&'a Path>,
    every: Duration,
    last: Instant,
}

impl<'a> Checkpoint<'a> {
    /// To the file that was asked for, if one was.
    pub(super) fn new(options: &'a KeptOptions) -> Self {
        Self { path: options.file(), every: options.checkpoint_every, last: Instant::now() }
    }

    /// Writes if it is time. One that fails leaves the file as it was and the render going: the next may succeed, and the last is told.
    pub(super) fn offer(&mut self, about: impl FnOnce() -> anyhow::Result<About>, sums: &Sums) {
        let Some(path) = self.path.filter(|_| self.last.elapsed() >= self.every) else { return };
        let written = about().and_then(|about| atomic::write(path, &kept::encode(&about, sums)?));
        match written {
            Ok(()) => info!("{} rounds are kept in {}", sums.film().rounds(), path.display()),
            Err(error) => warn(&format!("{error:#}; the render goes on")),
        }
        self.last = Instant::now();
    }
}
