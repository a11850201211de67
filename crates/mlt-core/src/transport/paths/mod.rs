//! Light paths, and the densities of every way of making them.

mod classes;
mod edge;
mod kind;
pub(crate) mod mis;
mod path;
pub(crate) mod path_vertex;
pub(crate) mod subpath;

pub use classes::{Classes, PathClass};
pub(crate) use edge::Edge;
pub use kind::{KINDS, Kind, Kinds, LightEnd, PathEnd};
pub use path::{LightPath, Luminance};
pub use path_vertex::PathVertex;
pub(crate) use path_vertex::{copy_vertices, emission, reference, scattering, sensitivity, set_scattering};
