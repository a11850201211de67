//! The file that a render under way is kept in.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use mlt_core::transport::render::Sums;
use tracing::info;

use crate::{
    args::kept::KeptOptions,
    atomic,
    kept::{self, About},
    warn,
};

/// Time between two writes, at least, over that which a write takes: the render stands still for no more than 1 % of its time.
const REST: u32 = 99;

/// Writes the sums of a render to a file, time and again.
pub(super) struct Checkpoint<'a> {
    path: Option<&'a Path>,
    /// The outcome of the render's pilot.
    pilot: Option<&'a [u8]>,
    every: Duration,
    last: Instant,
    /// From the last write to the next.
    wait: Duration,
}

impl<'a> Checkpoint<'a> {
    /// To the file that was asked for, if one was.
    pub(super) fn new(options: &'a KeptOptions, pilot: Option<&'a [u8]>) -> Self {
        let every = options.checkpoint_every;
        Self { path: options.file(), pilot, every, last: Instant::now(), wait: every }
    }

    /// Writes if it is time. One that fails leaves the file as it was and the render going: the next may succeed, and the last is told.
    pub(super) fn offer(&mut self, about: impl FnOnce() -> anyhow::Result<About>, sums: &Sums) {
        let Some(path) = self.path.filter(|_| self.last.elapsed() >= self.wait) else { return };
        let start = Instant::now();
        let written = about().and_then(|about| atomic::write(path, &kept::encode(&about, self.pilot, sums)?));
        match written {
            Ok(()) => info!("{} rounds are kept in {}", sums.film().rounds(), path.display()),
            Err(error) => warn(&format!("{error:#}; the render goes on")),
        }
        self.wait = self.every.max(start.elapsed().saturating_mul(REST));
        self.last = Instant::now();
    }
}
