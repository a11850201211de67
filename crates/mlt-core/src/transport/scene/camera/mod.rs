//! Cameras.

mod pinhole;

pub use pinhole::{Camera, CameraPose, CameraRay};
