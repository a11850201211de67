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
mod texture;
mod unsupported;

use crate::{LoadOptions, Loaded, SceneError, geometry::GeometrySize, source::Source};
use accessor::Reader;
use buffer::Buffers;
use gltf::{Document, Primitive, Semantic};
use graph::{Graph, Placed};
use material::Used;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::SceneDescription;
use parse::Parsed;
use texture::Files;

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
    Ok(Loaded {
        name,
        description,
        warnings,
        lights_left_out: unsupported::lights(&nodes),
        digest: source.digest(),
        neutral_sky: false,
    })
}

/// The meshes at these nodes, and all materials.
fn surfaces(
    source: &Source,
    parsed: &Parsed,
    nodes: &[Placed],
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    take_memory(source, nodes)?;
    let buffers = Buffers::new(source, parsed);
    let files = Files { source, parsed, buffers: &buffers };
    let (materials, textures) = material::materials(&files, &used(&parsed.document, nodes), warnings)?;
    let mut scene = SceneDescription { materials, textures, ..SceneDescription::default() };
    let mut reader = Reader::new(source, parsed, &buffers);
    for placed @ (node, _) in nodes {
        warnings.extend(unsupported::in_node(node));
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            let material = material_of(&parsed.document, &primitive);
            let textured = scene.materials[material].textured.is_some();
            let mesh = primitive::mesh(&mut reader, placed, &primitive, textured, warnings)?;
            scene.meshes.extend(mesh.map(|m| Mesh { material: material as u32, ..m }));
        }
    }
    if scene.meshes.is_empty() {
        warnings.push("the scene has no triangles".to_owned());
    }
    Ok(scene)
}

/// Index of a primitive's material; that of glTF's default one is one behind the last.
fn material_of(document: &Document, primitive: &Primitive) -> usize {
    primitive.material().index().unwrap_or(document.materials().len())
}

/// The materials that some nodes show.
fn used(document: &Document, nodes: &[Placed]) -> Used {
    let mut used = Used::new();
    for primitive in nodes.iter().filter_map(|(node, _)| node.mesh()).flat_map(|m| m.primitives()) {
        let coloured = primitive.get(&Semantic::Colors(0)).is_some();
        *used.entry(material_of(document, &primitive)).or_default() |= coloured;
    }
    used
}

/// Takes the memory for the primitives, counted at each node that shows them.
fn take_memory(source: &Source, nodes: &[Placed]) -> Result<(), SceneError> {
    let mut size = GeometrySize::default();
    for primitive in nodes.iter().filter_map(|(node, _)| node.mesh()).flat_map(|m| m.primitives()) {
        let textured = [Semantic::TexCoords(0), Semantic::Colors(0)].iter().any(|s| primitive.get(s).is_some());
        let material = primitive.material();
        let emits = material.emissive_factor() != [0.0; 3] || unsupported::is_unlit(&material);
        size.add(primitive::triangle_count(&primitive), emits, textured);
    }
    size.take(source)
}
