//! glTF 2.0, text and binary.
//!
//! The `gltf` crate parses the JSON and checks its indices; buffers are found, bounded and read here.

mod accessor;
mod buffer;
mod camera;
mod glb;
mod graph;
mod material;
mod parse;
mod primitive;
mod unsupported;

use crate::{LoadOptions, Loaded, SceneError, geometry::GeometrySize, source::Source};
use accessor::Reader;
use buffer::Buffers;
use graph::{Graph, Placed};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::SceneDescription;
use parse::Parsed;
use std::collections::BTreeSet;

/// The remedy for a file that contradicts itself.
const CHECK: &str = "export the scene again or check it with a glTF validator";

/// Loads the scene that is asked for, or that the file shows by default.
pub(crate) fn load(source: &Source, options: &LoadOptions) -> Result<Loaded, SceneError> {
    let parsed = parse::parse(source)?;
    let mut graph = Graph::new(&parsed.document);
    let nodes = graph.shown(source, options.scene.as_deref())?;
    let mut warnings = unsupported::in_document(&parsed.document);
    let cameras = camera::poses(&nodes, &graph.others(), &mut warnings);
    let description = SceneDescription { cameras, ..surfaces(source, &parsed, &nodes, &mut warnings)? };
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Loaded { name, description, warnings, lights_left_out: unsupported::lights(&nodes), digest: source.digest() })
}

/// The meshes at these nodes, and all materials.
fn surfaces(
    source: &Source,
    parsed: &Parsed,
    nodes: &[Placed],
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    take_memory(source, nodes)?;
    let document = &parsed.document;
    let buffers = Buffers::new(source, parsed);
    let mut reader = Reader::new(source, parsed, &buffers);
    let (mut scene, mut used) = (SceneDescription::default(), BTreeSet::new());
    for (node, to_world) in nodes {
        warnings.extend(unsupported::in_node(node));
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            let material = primitive.material().index().unwrap_or(document.materials().len());
            used.insert(material);
            let mesh = primitive::mesh(&mut reader, node, &primitive, to_world, warnings)?;
            scene.meshes.extend(mesh.map(|m| Mesh { material: material as u32, ..m }));
        }
    }
    scene.materials = material::materials(document, &used, warnings);
    if scene.meshes.is_empty() {
        warnings.push("the scene has no triangles".to_owned());
    }
    Ok(scene)
}

/// Takes the memory for the primitives, counted at each node that shows them.
fn take_memory(source: &Source, nodes: &[Placed]) -> Result<(), SceneError> {
    let mut size = GeometrySize::default();
    for primitive in nodes.iter().filter_map(|(node, _)| node.mesh()).flat_map(|m| m.primitives()) {
        size.add(primitive::triangle_count(&primitive), primitive.material().emissive_factor() != [0.0; 3]);
    }
    size.take(source)
}
