//! Scenes that are part of the program.

use crate::{
    LoadOptions, Loaded, SceneError, gltf_file,
    source::{Embedded, Source},
};
use mlt_core::memory::Memory;

/// Names of the built-in scenes.
pub const BUILTIN: &[&str] = &["cornell", "ring", "suzanne"];

macro_rules! embed {
    ($name:literal) => {
        &[
            (concat!($name, ".gltf"), include_bytes!(concat!("../scenes/", $name, "/", $name, ".gltf"))),
            (concat!($name, ".bin"), include_bytes!(concat!("../scenes/", $name, "/", $name, ".bin"))),
        ]
    };
}

/// The built-in scene of that name; `None`: there is no such scene.
pub fn builtin(name: &str) -> Option<Result<Loaded, SceneError>> {
    read(name, &LoadOptions::default())
}

/// The same as `options` say.
pub(crate) fn read(name: &str, options: &LoadOptions) -> Option<Result<Loaded, SceneError>> {
    let files: Embedded = match name {
        "cornell" => embed!("cornell"),
        "ring" => embed!("ring"),
        "suzanne" => embed!("suzanne"),
        _ => return None,
    };
    Some(gltf_file::load(&Source::embedded(files, &Memory::unlimited()), options))
}
