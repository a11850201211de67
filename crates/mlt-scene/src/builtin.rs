//! Scenes that are part of the program.

use crate::{Loaded, SceneError, gltf_file, source::Source};

/// Names of the built-in scenes.
pub const BUILTIN: &[&str] = &["cornell", "ring", "suzanne"];

macro_rules! embed {
    ($name:literal) => {
        &[
            (concat!($name, ".gltf"), include_bytes!(concat!("../../../scenes/", $name, "/", $name, ".gltf"))),
            (concat!($name, ".bin"), include_bytes!(concat!("../../../scenes/", $name, "/", $name, ".bin"))),
        ]
    };
}

/// The built-in scene of that name; `None`: there is no such scene.
pub fn builtin(name: &str) -> Option<Result<Loaded, SceneError>> {
    let source = Source::embedded(match name {
        "cornell" => embed!("cornell"),
        "ring" => embed!("ring"),
        "suzanne" => embed!("suzanne"),
        _ => return None,
    });
    Some(gltf_file::load(&source))
}
