//! The renderer: scenes of triangles, bidirectional path tracing, path-space mutations.
//!
//! # Rooms
//!
//! Each depends on those below it alone.
//!
//! | room | what it holds |
//! |---|---|
//! | [`render`] | A whole render: a method and what it counts. |
//! | [`methods`] | How light transport is computed: path tracing, bidirectional path tracing, Metropolis, and what chooses between them. |
//! | [`image`] | Arrays over pixels: errors, weights, the importance of a pixel. |
//! | [`paths`] | Light paths, their vertices, the densities of every way of making them, their classes. |
//! | [`lights`] | Parts of the lights: regions, cuts, strata, and the sampler that chooses a light for a vertex. |
//! | [`scene`] | Surfaces, materials, lights and cameras. |
//! | [`bsdf`] | Scattering functions. |
//! | [`accel`] | What a ray meets first. |
//! | [`geometry`] | Vertices, rays, meshes. |
//! | [`colour`] | Radiance and reflectance. |

pub mod accel;
pub mod bsdf;
pub mod colour;
pub mod geometry;
pub mod image;
pub mod lights;
pub mod methods;
pub mod paths;
pub mod render;
pub mod scene;
#[cfg(test)]
mod tests;

pub use colour::{Rgb, luminance};
