//! An environment's image around a lamp: Radiance HDR or OpenEXR, as its first bytes say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_fuzz::{lamp, open, put};
use mlt_scene::{EnvironmentOptions, EnvironmentSource, LoadOptions};
use tempfile::TempDir;

thread_local!(static FOLDER: TempDir = lamp());

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        let name = if bytes.starts_with(b"#?") { "a.hdr" } else { "a.exr" };
        let source = EnvironmentSource::Image(put(folder, name, bytes));
        let environment = EnvironmentOptions { source, ..EnvironmentOptions::default() };
        let _ = open(&folder.path().join("a.obj"), &LoadOptions { environment, ..LoadOptions::default() });
    });
});
