//! Description of a scene, which a loader hands to the renderer.

use super::camera::CameraPose;
use super::light::{Environment, PunctualLight};
use super::material::Material;
use super::textures::Texture;
use crate::transport::geometry::Mesh;

/// A scene as its file says it: nothing derived yet.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Triangles, world space.
    pub meshes: Vec<Mesh>,
    /// Referred to by the meshes.
    pub materials: Vec<Material>,
    /// Referred to by the materials.
    pub textures: Vec<Texture>,
    /// The first one is the default; empty: the caller has to choose one.
    pub cameras: Vec<CameraPose>,
    /// Lights without a surface.
    pub punctual: Vec<PunctualLight>,
    /// Light that comes from all around.
    pub environment: Option<Environment>,
}

/// Name of a surface in the scene's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurfaceName {
    /// Name of the mesh.
    pub mesh: String,
    /// Name of its material.
    pub material: String,
}

impl SceneDescription {
    /// Whether anything gives light.
    pub fn is_lit(&self) -> bool {
        let emits = |mesh: &Mesh| self.materials[mesh.material as usize].emission.max_element() > 0.0;
        self.environment.as_ref().is_some_and(Environment::is_lit)
            || self.punctual.iter().any(PunctualLight::is_lit)
            || self.meshes.iter().any(emits)
    }

    /// Name in the file of a mesh's surface, the mesh given by its number.
    pub fn surface_name(&self, mesh: u32) -> SurfaceName {
        let Mesh { name, material, .. } = &self.meshes[mesh as usize];
        SurfaceName { mesh: name.clone(), material: self.materials[*material as usize].name.clone() }
    }
}
