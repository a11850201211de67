//! Where a render's image comes from.

mod camera;

use serde::{Deserialize, Serialize};

pub use camera::CameraUsed;

/// The scene and the camera of a render, in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The scene as named on the command line.
    pub scene: String,
    /// The camera.
    pub camera: CameraUsed,
    /// Warnings that the scene gives, such as of parts of its file that are left out.
    pub warnings: Vec<String>,
}
