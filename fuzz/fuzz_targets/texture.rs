//! A texture of a lamp: PNG or JPEG, as its first bytes say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_fuzz::{lamp, open, put};
use mlt_scene::LoadOptions;
use tempfile::TempDir;

thread_local!(static FOLDER: TempDir = lamp());

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        put(folder, "a.png", bytes);
        let _ = open(&folder.path().join("a.obj"), &LoadOptions::default());
    });
});
