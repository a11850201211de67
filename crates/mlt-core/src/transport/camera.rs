//! The pinhole camera.

use glam::{DVec3, Vec3};

/// Where the camera stands and what it takes in; the image's aspect ratio comes with its size.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPose {
    /// Name in the scene file.
    pub name: String,
    /// World position.
    pub position: DVec3,
    /// Unit vector into the scene.
    pub forward: Vec3,
    /// Unit vector up in the image, at a right angle to `forward`.
    pub up: Vec3,
    /// Full vertical opening angle, radians.
    pub vertical_fov: f32,
    /// Width over height that the scene's author meant, if given.
    pub aspect_ratio: Option<f32>,
}
