//! Scenes that are part of the program.

use crate::{
    LoadOptions, Loaded, SceneError,
    gltf_file::{self, Kept},
    source::{Embedded, Source},
};
use mlt_core::memory::Memory;

/// A scene that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its subject, in a few words.
    pub about: &'static str,
    files: Embedded,
}

macro_rules! scene {
    ($name:literal, $about:literal) => {
        BuiltIn {
            name: $name,
            about: $about,
            files: &[
                (concat!($name, ".gltf"), include_bytes!(concat!("../scenes/", $name, "/", $name, ".gltf"))),
                (concat!($name, ".bin"), include_bytes!(concat!("../scenes/", $name, "/", $name, ".bin"))),
            ],
        }
    };
}

/// The built-in scenes.
pub const BUILTIN: &[BuiltIn] = &[
    scene!("cornell", "a box with a red and a green wall, two blocks and one lamp"),
    scene!("ring", "twelve lamps of unequal power around a torus and a ball"),
    scene!("suzanne", "Blender's monkey under one large and two small lamps"),
];

/// The built-in scene of that name; `None`: there is no such scene.
pub fn builtin(name: &str) -> Option<Result<Loaded, SceneError>> {
    read(name, &LoadOptions::default(), &mut Kept::default())
}

/// The same as `options` say.
pub(crate) fn read(name: &str, options: &LoadOptions, kept: &mut Kept) -> Option<Result<Loaded, SceneError>> {
    let scene = BUILTIN.iter().find(|scene| scene.name == name)?;
    Some(gltf_file::load(&Source::embedded(scene.files, &Memory::unlimited()), options, kept))
}
