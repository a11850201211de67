//! Which meshes are held in memory once, wherever they stand.
//!
//! A copy that shares its mesh costs some hundred bytes, whatever the mesh; but rays find the triangles sooner where all lie in world
//! space, and neighbours that are held there have their common edges in the same place. So meshes are shared only where that saves much,
//! and small meshes never.

use super::{graph::Placed, instance, primitive::triangle_count, unsupported};
use crate::{Copies, SceneError, geometry::is_usable};
use glam::{DAffine3, DMat4};
use gltf::{Document, Mesh, Node, Primitive};
use mlt_core::transport::geometry;
use mlt_core::transport::scene::Prototype;
use std::collections::{HashMap, HashSet};

/// Triangles that sharing has to save.
const LEAST_SAVED: usize = 1 << 20;
/// Triangles of a mesh from which on it is shared.
const LEAST_MESH: usize = 64;

/// Which meshes of a document are held once.
pub(super) struct Sharing {
    /// Their indices.
    shared: HashSet<usize>,
}

impl Sharing {
    /// For the meshes at these nodes.
    pub(super) fn new(document: &Document, nodes: &[Placed], copies: Copies) -> Self {
        let least = if copies == Copies::Shared { 1 } else { LEAST_MESH };
        // Of each mesh its triangles, and how often it stands somewhere.
        let mut meshes = HashMap::new();
        for (node, mesh) in nodes.iter().filter_map(|(node, _)| Some((node, node.mesh()?))) {
            if is_rigid(document, node, &mesh) {
                meshes.entry(mesh.index()).or_insert((triangles(&mesh), 0usize)).1 += instance::count(document, node);
            }
        }
        meshes.retain(|_, (triangles, count)| *triangles >= least && *count > 1);
        let saved = |(triangles, count): &(usize, usize)| triangles.saturating_mul(count - 1);
        let shares = match copies {
            Copies::Auto => meshes.values().map(saved).fold(0, usize::saturating_add) >= LEAST_SAVED,
            Copies::Shared => true,
            Copies::Baked => false,
        };
        Self { shared: if shares { meshes.into_keys().collect() } else { HashSet::new() } }
    }

    /// Whether a primitive of a node's mesh is held once; lights are not.
    pub(super) fn holds(&self, document: &Document, (node, mesh): (&Node, &Mesh), primitive: &Primitive) -> bool {
        self.shared.contains(&mesh.index())
            && is_rigid(document, node, mesh)
            && !unsupported::emits(&primitive.material())
    }
}

/// The prototypes of the meshes that are held once, in the order of their first nodes.
#[derive(Default)]
pub(super) struct Prototypes {
    prototypes: Vec<Prototype>,
    /// Of each mesh of the document.
    numbers: HashMap<usize, usize>,
}

impl Prototypes {
    /// Adds places where a mesh stands; `read` makes its surfaces when it is met first.
    pub(super) fn add(
        &mut self,
        mesh: usize,
        places: &[DMat4],
        read: impl FnOnce() -> Result<Vec<Option<geometry::Mesh>>, SceneError>,
    ) -> Result<(), SceneError> {
        let number = match self.numbers.get(&mesh) {
            Some(&number) => number,
            None => {
                let meshes = read()?.into_iter().flatten().collect();
                self.prototypes.push(Prototype { meshes, places: Vec::new() });
                *self.numbers.entry(mesh).or_insert(self.prototypes.len() - 1)
            }
        };
        self.prototypes[number].places.extend(places.iter().map(|place| DAffine3::from_mat4(*place)));
        Ok(())
    }

    /// Those that have triangles, at the places where they can be rendered.
    pub(super) fn usable(mut self, warnings: &mut Vec<String>) -> Vec<Prototype> {
        self.prototypes.retain(|prototype| prototype.triangles() > 0);
        for prototype in &mut self.prototypes {
            let corners: Vec<_> = prototype.corners().collect();
            let mut in_range = corners.chunks(8).map(|corners| corners.iter().all(|corner| is_usable(*corner)));
            let before = prototype.places.len();
            prototype.places.retain(|place| in_range.next().unwrap_or(false) && Prototype::can_stand_at(*place));
            let lost = before - prototype.places.len();
            if lost > 0 {
                warnings.push(format!(
                    "mesh `{}`: {lost} of its {before} copies have no extent or are too far away; they are left out",
                    prototype.meshes[0].name
                ));
            }
        }
        self.prototypes.retain(|prototype| !prototype.places.is_empty());
        self.prototypes
    }
}

/// Triangles of a mesh at most, known without its data; those of lights do not count.
fn triangles(mesh: &Mesh) -> usize {
    let dark = mesh.primitives().filter(|primitive| !unsupported::emits(&primitive.material()));
    dark.map(|primitive| triangle_count(&primitive)).fold(0, usize::saturating_add)
}

/// Whether a mesh has the same shape wherever it stands.
fn is_rigid(document: &Document, node: &Node, mesh: &Mesh) -> bool {
    let has_skin = document.as_json().nodes[node.index()].skin.is_some();
    !has_skin && mesh.primitives().all(|primitive| primitive.morph_targets().len() == 0)
}
