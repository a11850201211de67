//! Checks of a scene: what it must have, and what it is better without.

use super::Scene;
use super::description::{Prototype, SceneDescription};
use super::textures::Map;
use crate::transport::geometry::Mesh;
use glam::DAffine3;
use std::collections::HashSet;

/// Fault that makes a scene unusable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnusableScene {
    /// There is nothing to see.
    #[error("the scene has no triangle")]
    NoTriangle,
    /// There is nothing to see it by.
    #[error(
        "the scene has no light: give a material an emission (glTF emissiveFactor, MTL Ke), or the scene an environment"
    )]
    NoLight,
    /// A mesh refers to a vertex or material that does not exist.
    #[error("mesh \"{mesh}\" refers to {what} {index}, which does not exist")]
    BadIndex {
        /// Name of the mesh.
        mesh: String,
        /// "vertex", "material" or "texture".
        what: &'static str,
        /// The index.
        index: usize,
    },
    /// More triangles than a 32-bit index can name.
    #[error("the scene has {0} triangles; at most {max} are supported", max = Scene::MOST_TRIANGLES)]
    TooLarge(usize),
    /// More triangles, those of copies included, than there are numbers for.
    #[error("the scene has {0} triangles, copies included; at most {max} are supported", max = Scene::MOST_WITH_COPIES)]
    TooManyCopies(usize),
    /// A mesh of a prototype emits light.
    #[error("mesh \"{mesh}\" stands in several places and emits light; give each of its copies a mesh of its own")]
    CopiedLight {
        /// Name of the mesh.
        mesh: String,
    },
}

/// Whether all that a description refers to is there.
pub(super) fn check(description: &SceneDescription) -> Result<(), UnusableScene> {
    let held: usize = description.all_meshes().map(|m| m.triangles.len()).sum();
    if held > Scene::MOST_TRIANGLES {
        return Err(UnusableScene::TooLarge(held));
    }
    let copied = |prototype: &Prototype| prototype.triangles().saturating_mul(prototype.places.len());
    let own = description.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let seen = description.prototypes.iter().map(copied).fold(own, usize::saturating_add);
    if seen > Scene::MOST_WITH_COPIES {
        return Err(UnusableScene::TooManyCopies(seen));
    }
    for mesh in description.all_meshes() {
        let bad = |what, index: u32| UnusableScene::BadIndex { mesh: mesh.name.clone(), what, index: index as usize };
        if mesh.material as usize >= description.materials.len() {
            return Err(bad("material", mesh.material));
        }
        let missing = |map: &Map| map.texture as usize >= description.textures.len();
        let textured = &description.materials[mesh.material as usize].textured;
        if let Some(map) = textured.iter().find_map(|textured| textured.maps.all().find(missing)) {
            return Err(bad("texture", map.texture));
        }
        if let Some(&i) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= mesh.positions.len()) {
            return Err(bad("vertex", i));
        }
    }
    let emits = |mesh: &&Mesh| description.materials[mesh.material as usize].emission.max_element() > 0.0;
    match description.prototypes.iter().flat_map(|prototype| &prototype.meshes).find(emits) {
        Some(mesh) => Err(UnusableScene::CopiedLight { mesh: mesh.name.clone() }),
        None => Ok(()),
    }
}

/// Drops meshes of opacity 0, where no surface is, and copies that have no place or stand where another one does.
pub(super) fn drop_invisible(description: &mut SceneDescription) {
    let SceneDescription { meshes, prototypes, materials, .. } = description;
    let is_visible = |mesh: &Mesh| materials[mesh.material as usize].opacity > 0.0;
    meshes.retain(is_visible);
    for Prototype { meshes, places } in &mut *prototypes {
        meshes.retain(is_visible);
        let mut taken = HashSet::new();
        let is_free = |place: &DAffine3| taken.insert(place.to_cols_array().map(f64::to_bits));
        places.retain(|place| Prototype::can_stand_at(*place));
        places.retain(is_free);
    }
    prototypes.retain(|prototype| prototype.triangles() > 0 && !prototype.places.is_empty());
}

/// Drops triangles with a corner that is not finite; returns how many.
pub(super) fn drop_unusable(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let Mesh { positions, triangles, .. } = mesh;
    triangles.retain(|t| t.iter().all(|&i| positions[i as usize].is_finite()));
    before - triangles.len()
}
