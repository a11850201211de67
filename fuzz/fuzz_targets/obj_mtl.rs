//! OBJ and MTL: a zero byte ends the first.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_fuzz::{folder, open, put};
use mlt_scene::LoadOptions;
use tempfile::TempDir;

thread_local!(static FOLDER: TempDir = folder());

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        let middle = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        put(folder, "a.mtl", bytes.get(middle + 1..).unwrap_or_default());
        let obj = [b"mtllib a.mtl\n", &bytes[..middle]].concat();
        let _ = open(&put(folder, "a.obj", &obj), &LoadOptions::default());
    });
});
