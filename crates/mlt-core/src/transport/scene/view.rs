//! A scene with a camera in it.

use super::Scene;
use super::camera::Camera;

/// A scene seen through a camera: what a path lives in.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Surfaces and lights.
    pub scene: &'a Scene,
    /// Lens and image.
    pub camera: &'a Camera,
}
