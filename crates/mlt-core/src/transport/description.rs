//! What a scene loader hands to the renderer.

use super::{camera::CameraPose, material::Material, mesh::Mesh};

/// A scene as its file says it: nothing derived yet.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Triangles, world space.
    pub meshes: Vec<Mesh>,
    /// Referred to by the meshes.
    pub materials: Vec<Material>,
    /// The first one is the default; empty: the caller has to choose one.
    pub cameras: Vec<CameraPose>,
}
