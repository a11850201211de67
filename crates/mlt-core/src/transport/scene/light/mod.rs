//! Lights: what and where they are, and what they emit.

mod area;
mod emission;

pub(crate) use area::Piece;
#[cfg(test)]
pub(crate) use area::Shape;
pub use area::{Light, LightPoint};
