//! Checkpoints, parts and pilots: as they are, and with a right checksum around them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_cli::kept::{self, pilot::Pilot};
use mlt_core::engine::sealed;
use mlt_fuzz::{folder, put};
use tempfile::TempDir;

thread_local!(static FOLDER: TempDir = folder());

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        let _ = kept::read(&put(folder, "a.mltp", bytes));
        let forged = sealed(kept::MAGIC, kept::VERSION, |to| to.extend(bytes));
        let _ = kept::read(&put(folder, "a.mltp", &forged));
        let forged = sealed(kept::pilot::MAGIC, kept::pilot::VERSION, |to| to.extend(bytes));
        let _ = Pilot::read(&put(folder, "a.pilot", &forged));
    });
});
