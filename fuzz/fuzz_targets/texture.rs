//! A texture of a lamp: PNG or JPEG, as its first bytes say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mlt_fuzz::{folder, open, put};
use mlt_scene::LoadOptions;
use tempfile::TempDir;

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl lamp\nf 1/1 2/2 3/3\n";
const MTL: &[u8] = b"newmtl lamp\nKd 1 1 1\nKe 1 1 1\nmap_Kd a.png\n";

thread_local!(static FOLDER: TempDir = {
    let folder = folder();
    put(&folder, "a.obj", OBJ);
    put(&folder, "a.mtl", MTL);
    folder
});

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with(|folder| {
        put(folder, "a.png", bytes);
        let _ = open(&folder.path().join("a.obj"), &LoadOptions::default());
    });
});
