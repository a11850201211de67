//! glTF 2.0, text and binary.
//!
//! The `gltf` crate parses the JSON and checks its indices; buffers are found, bounded and read here.

mod accessor;
mod buffer;
mod camera;
mod graph;
mod material;
mod parse;
mod primitive;
mod unsupported;

use crate::{Loaded, SceneError, geometry::MAX_ELEMENTS, source::Source};
use accessor::Reader;
use glam::DMat4;
use gltf::{Document, Node, Semantic};
use mlt_core::transport::{description::SceneDescription, mesh::Mesh};
use std::collections::BTreeSet;

/// The remedy for a file that contradicts itself.
const CHECK: &str = "export the scene again or check it with a glTF validator";

/// Loads the scene that the file shows by default.
pub(crate) fn load(source: &Source) -> Result<Loaded, SceneError> {
    let (document, blob) = parse::parse(source)?;
    let buffers = buffer::resolve(source, &document, blob)?;
    let mut warnings = unsupported::in_document(&document);
    let description = describe(source, &document, &buffers, &mut warnings)?;
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Loaded { name, description, warnings })
}

fn describe(
    source: &Source,
    document: &Document,
    buffers: &[Vec<u8>],
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    let mut scene = SceneDescription::default();
    let mut reader = Reader::new(source, buffers);
    let mut used = BTreeSet::new();
    let nodes = graph::nodes(source, document)?;
    check_size(source, &nodes)?;
    for (node, to_world) in nodes {
        if let Some(camera) = node.camera() {
            scene.cameras.extend(camera::pose(&camera, &node, &to_world, warnings));
        }
        warnings.extend(unsupported::in_node(&node));
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            let material = primitive.material().index().unwrap_or(document.materials().len());
            used.insert(material);
            let mesh = primitive::mesh(&mut reader, &node, &primitive, &to_world, warnings)?;
            scene.meshes.extend(mesh.map(|m| Mesh { material: material as u32, ..m }));
        }
    }
    scene.materials = material::materials(document, &used, warnings);
    if scene.meshes.is_empty() {
        warnings.push("the scene has no triangles".to_owned());
    }
    Ok(scene)
}

/// Refuses a scene whose primitives, counted at each node that shows them, have too many corners.
fn check_size(source: &Source, nodes: &[(Node, DMat4)]) -> Result<(), SceneError> {
    const MAX_CORNERS: usize = 3 * MAX_ELEMENTS;
    let mut corners = 0usize;
    for (node, _) in nodes {
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            let accessor = primitive.indices().or_else(|| primitive.get(&Semantic::Positions));
            corners = corners.saturating_add(accessor.map_or(0, |a| a.count()));
        }
        if corners > MAX_CORNERS {
            return Err(source.too_large(graph::place(node), "corners of the scene so far", MAX_CORNERS));
        }
    }
    Ok(())
}
