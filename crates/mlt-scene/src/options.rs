//! How a scene is read.

use crate::Glass;
use crate::environment::EnvironmentOptions;

/// Choices that a file leaves open, or that its user makes otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Scene of a glTF file to show, by its name; `None`: the file's default one.
    pub scene: Option<String>,
    /// What transmissive surfaces of a glTF file are taken for.
    pub glass: Glass,
    /// Light from all around.
    pub environment: EnvironmentOptions,
}
