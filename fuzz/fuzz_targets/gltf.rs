//! glTF and GLB: bytes that begin like GLB are one, all others are the JSON of a glTF file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_fuzz::{folder, open, put};
use mlt_scene::LoadOptions;
use tempfile::TempDir;

thread_local!(static FOLDER: TempDir = folder());

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        let name = if bytes.starts_with(b"glTF") { "a.glb" } else { "a.gltf" };
        let _ = open(&put(folder, name, bytes), &LoadOptions::default());
    });
});
