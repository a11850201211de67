//! Description of a scene, which a loader hands to the renderer.

use super::camera::CameraPose;
use super::light::{Environment, PunctualLight};
use super::material::Material;
use super::textures::Texture;
use crate::transport::geometry::{Mesh, Placement};
use glam::{DAffine3, DVec3};

/// Meshes that stand together in several places, and are held in memory once.
#[derive(Clone, Debug, Default)]
pub struct Prototype {
    /// Triangles, in coordinates of their own. None of them may emit light.
    pub meshes: Vec<Mesh>,
    /// From these coordinates to the world, of each copy. One without an inverse shows nothing.
    pub places: Vec<DAffine3>,
}

impl Prototype {
    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }

    /// Whether a place has an inverse, as far as numbers can tell.
    pub fn can_stand_at(place: DAffine3) -> bool {
        Placement::new(place).is_some()
    }

    /// World corners of the boxes around the copies, eight each.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + Clone {
        let points = || self.meshes.iter().flat_map(|mesh| mesh.positions.iter().copied());
        let (low, high) = (points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max));
        let corner =
            move |i: usize| DVec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low } else { high }[axis]));
        let corners = move |place: &DAffine3| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| place.transform_point3(corner(i)));
        self.places.iter().flat_map(corners)
    }
}

/// A scene as its file says it: nothing derived yet.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Triangles, world space.
    pub meshes: Vec<Mesh>,
    /// Meshes that stand in several places.
    pub prototypes: Vec<Prototype>,
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
    /// The meshes in world space, then those of the prototypes.
    pub fn all_meshes(&self) -> impl Iterator<Item = &Mesh> + Clone {
        self.meshes.iter().chain(self.prototypes.iter().flat_map(|prototype| &prototype.meshes))
    }

    /// The same, to be changed.
    pub fn all_meshes_mut(&mut self) -> impl Iterator<Item = &mut Mesh> {
        self.meshes.iter_mut().chain(self.prototypes.iter_mut().flat_map(|prototype| &mut prototype.meshes))
    }

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
