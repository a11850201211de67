//! Lights.

mod area;

pub use area::{Light, LightPoint};
pub(crate) use area::{Piece, Shape};
