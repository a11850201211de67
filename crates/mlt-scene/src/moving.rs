//! A scene at several times of its animations.

use crate::{LoadOptions, Loaded, SceneError, gltf_file::Kept, open_keeping};
use mlt_core::memory::Memory;
use std::path::{Path, PathBuf};

/// A scene that is read at several times of its animations. Of a glTF file the JSON is parsed once, and images are decoded once;
/// geometry is made anew for each time.
#[derive(Debug)]
pub struct MovingScene {
    name_or_path: PathBuf,
    options: LoadOptions,
    kept: Kept,
}

impl MovingScene {
    /// A file, or else the built-in scene of that name; nothing is read yet.
    pub fn new(name_or_path: &Path, options: LoadOptions) -> Self {
        Self { name_or_path: name_or_path.to_owned(), options, kept: Kept::default() }
    }

    /// The scene at a time, in seconds, within a budget of memory of its own.
    pub fn at(&mut self, seconds: f64, memory: &Memory) -> Result<Loaded, SceneError> {
        self.options.time_in_animation = Some(seconds);
        open_keeping(&self.name_or_path, &self.options, memory, &mut self.kept)
    }
}
