//! What a scene loader hands to the renderer.

use super::{camera::CameraPose, material::Material, mesh::Mesh, scene::SurfaceName};

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

impl SceneDescription {
    /// What the file calls the surface of a mesh, given by its number.
    pub fn surface_name(&self, mesh: u32) -> SurfaceName {
        let Mesh { name, material, .. } = &self.meshes[mesh as usize];
        SurfaceName { mesh: name.clone(), material: self.materials[*material as usize].name.clone() }
    }
}
