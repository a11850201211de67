//! The camera of a render.

use std::fmt;

use mlt_core::transport::scene::CameraPose;
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
        Self { name: printable(&pose.name, SHOWN), origin: origin.into(), lens: pose.lens.to_string() }
    }
}

impl fmt::Display for CameraUsed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\", {}; {}", self.name, self.origin, self.lens)
    }
}
