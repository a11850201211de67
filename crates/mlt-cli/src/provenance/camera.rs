//! The camera of a render.

use std::fmt;

use mlt_core::transport::scene::{CameraPose, Lens};
use mlt_scene::printable;
use serde::{Deserialize, Serialize};

/// Characters of a camera's name that are shown.
const SHOWN: usize = 60;

/// The camera of a render, for its report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraUsed {
    /// Its name in the file; of others, what they do.
    pub name: String,
    /// Where it comes from.
    pub origin: String,
    /// How it sees.
    pub lens: String,
}

impl CameraUsed {
    /// Of a camera that comes from somewhere.
    pub fn new(pose: &CameraPose, origin: &str) -> Self {
        Self { name: printable(&pose.name, SHOWN), origin: origin.into(), lens: words(&pose.lens) }
    }
}

impl fmt::Display for CameraUsed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\", {}; {}", self.name, self.origin, self.lens)
    }
}

fn words(lens: &Lens) -> String {
    let degrees = |radians: f32| format!("{:.1} degrees high", radians.to_degrees());
    match *lens {
        Lens::Pinhole { vertical_fov } => format!("pinhole, {}", degrees(vertical_fov)),
        Lens::Thin { vertical_fov, radius, focus } => {
            let lens = format!("lens of diameter {:.4} in focus at {focus:.4}", 2.0 * radius);
            format!("{lens}, {}", degrees(vertical_fov))
        }
        Lens::Orthographic { height } => format!("orthographic, {height:.4} high"),
    }
}
