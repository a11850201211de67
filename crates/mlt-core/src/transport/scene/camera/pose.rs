//! The description of a camera.

use glam::{DVec3, Vec3};
use std::fmt;

/// Where the camera stands and what it takes in; the image's aspect ratio comes with its size.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPose {
    /// Name in the scene file.
    pub name: String,
    /// World position: of the pinhole, of the lens's centre, or of the middle of an orthographic image.
    pub position: DVec3,
    /// Unit vector into the scene.
    pub forward: Vec3,
    /// Unit vector up in the image, at a right angle to `forward`.
    pub up: Vec3,
    /// How it sees.
    pub lens: Lens,
    /// Width over height that the scene's author meant, if given.
    pub aspect_ratio: Option<f32>,
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Lens {
    /// Through a point: everything is sharp.
    Pinhole {
        /// Full vertical opening angle, radians.
        vertical_fov: f32,
    },
    /// Through a disc: what is in focus is sharp.
    Thin {
        /// Full vertical opening angle, radians.
        vertical_fov: f32,
        /// Radius of the disc, world units.
        radius: f64,
        /// Distance of the plane in focus, along the viewing direction, world units.
        focus: f64,
    },
    /// By parallel rays.
    Orthographic {
        /// Height of the image, world units.
        height: f64,
    },
}

impl CameraPose {
    /// A pinhole at `from` that looks at `to` with +y up; `vertical_fov` in radians.
    ///
    /// Where the two points coincide it looks along -z, and where +y is the line of sight, -z is up.
    pub fn look_at(from: DVec3, to: DVec3, vertical_fov: f32) -> Self {
        let forward = (to - from).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(DVec3::Y).normalize_or(DVec3::X);
        Self {
            name: "look-at".to_owned(),
            position: from,
            forward: forward.as_vec3().normalize_or(Vec3::NEG_Z),
            up: right.cross(forward).as_vec3().normalize_or(Vec3::Y),
            lens: Lens::Pinhole { vertical_fov },
            aspect_ratio: None,
        }
    }
}

impl Lens {
    /// Full vertical opening angle, radians; `None` for parallel rays.
    pub fn vertical_fov(&self) -> Option<f32> {
        match *self {
            Self::Pinhole { vertical_fov } | Self::Thin { vertical_fov, .. } => Some(vertical_fov),
            Self::Orthographic { .. } => None,
        }
    }
}

/// In words, for a report.
impl fmt::Display for Lens {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let degrees = |radians: f32| format!("{:.1} degrees high", radians.to_degrees());
        match *self {
            Self::Pinhole { vertical_fov } => write!(f, "pinhole, {}", degrees(vertical_fov)),
            Self::Thin { vertical_fov, radius, focus } => {
                let diameter = 2.0 * radius;
                write!(f, "lens of diameter {diameter:.4} in focus at {focus:.4}, {}", degrees(vertical_fov))
            }
            Self::Orthographic { height } => write!(f, "orthographic, {height:.4} high"),
        }
    }
}
