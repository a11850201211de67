//! An environment's image around a built-in scene: Radiance HDR or OpenEXR, as its first bytes say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_fuzz::{folder, open, put};
use mlt_scene::{EnvironmentOptions, EnvironmentSource, LoadOptions};
use std::path::Path;
use tempfile::TempDir;

thread_local!(static FOLDER: TempDir = folder());

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        let name = if bytes.starts_with(b"#?") { "a.hdr" } else { "a.exr" };
        let source = EnvironmentSource::Image(put(folder, name, bytes));
        let environment = EnvironmentOptions { source, ..EnvironmentOptions::default() };
        let _ = open(Path::new("cornell"), &LoadOptions { environment, ..LoadOptions::default() });
    });
});
