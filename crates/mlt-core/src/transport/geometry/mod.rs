//! Points, rays and meshes in space.

pub(crate) mod hilbert;
pub mod math;
mod mesh;
mod placement;
mod ray;
mod space;
mod sphere;
mod vertex;

pub use mesh::Mesh;
pub(crate) use mesh::points;
pub(crate) use placement::Placement;
pub use ray::{Hit, Ray};
pub(crate) use space::Space;
pub(crate) use sphere::Sphere;
pub use vertex::{CAMERA, Place, Vertex};
pub(crate) use vertex::{ERROR_FACTOR, LIGHT};
