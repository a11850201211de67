//! Options of `mlt inspect`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::{scene::SceneOptions, view::ViewOptions};

/// Options of `mlt inspect`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub struct InspectOptions {
    /// A glTF or OBJ file, or a built-in scene
    #[arg(value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Where it would be seen from.
    #[command(flatten)]
    pub view: ViewOptions,
    /// How the scene is read.
    #[command(flatten)]
    pub reading: SceneOptions,
}
