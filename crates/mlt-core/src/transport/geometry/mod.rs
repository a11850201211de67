//! Points, rays and meshes in space.

pub(crate) mod hilbert;
pub mod math;
mod mesh;
mod ray;
mod space;
mod vertex;

pub use mesh::Mesh;
pub use ray::{Hit, Ray};
pub(crate) use space::Space;
pub(crate) use vertex::ERROR_FACTOR;
pub use vertex::{CAMERA, Vertex};
