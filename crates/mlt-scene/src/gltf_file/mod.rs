//! glTF 2.0, text and binary.
//!
//! The `gltf` crate parses the JSON and checks its indices; buffers are found, bounded and read here.

mod accessor;
mod animation;
mod buffer;
mod camera;
mod glb;
mod graph;
mod image_light;
mod instance;
mod light;
mod material;
mod meshopt;
mod parse;
mod primitive;
mod shape;
mod texture;
mod unsupported;

use crate::{LoadOptions, Loaded, SceneError, geometry::GeometrySize, source::Source};
use accessor::Reader;
use animation::Pose;
use buffer::Buffers;
use glam::DMat4;
use gltf::{Document, Primitive, Semantic};
use graph::{Graph, Placed};
use material::Used;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::SceneDescription;
use shape::Standing;
use std::collections::HashMap;
use texture::Files;

/// The remedy for a file that contradicts itself.
const CHECK: &str = "export the scene again or check it with a glTF validator";

/// Loads the scene that is asked for, or that the file shows by default.
pub(crate) fn load(source: &Source, options: &LoadOptions) -> Result<Loaded, SceneError> {
    let parsed = parse::parse(source)?;
    let document = &parsed.document;
    let buffers = Buffers::new(source, &parsed);
    let files = Files { source, parsed: &parsed, buffers: &buffers };
    let mut reader = Reader::new(source, &parsed, &buffers);
    let mut warnings = unsupported::in_document(document, options.time_in_animation.is_some());
    let pose = match options.time_in_animation {
        Some(time) => Pose::at(&mut reader, document, time, &mut warnings)?,
        None => Pose::default(),
    };
    let mut graph = Graph::new(document, &pose);
    let nodes = graph.shown(source, options.scene.as_deref())?;
    let others = graph.others();
    let cameras = camera::poses(&nodes, &others, &mut warnings);
    let lights = light::lights(document, &nodes, options.light_units, &mut warnings);
    let worlds = nodes.iter().chain(&others).map(|(node, to_world)| (node.index(), *to_world)).collect();
    let surfaces = surfaces(&files, &mut reader, &nodes, (&pose, &worlds), &mut warnings)?;
    let mut description = SceneDescription { cameras, ..surfaces };
    light::add(lights, source, &mut description)?;
    let scene = graph.chosen(source, options.scene.as_deref())?;
    description.environment = image_light::environment(&files, scene.as_ref(), &mut warnings)?;
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Loaded { name, description, warnings, digest: source.digest(), neutral_sky: false })
}

/// The meshes at these nodes, and all materials; `worlds`: where all nodes of the file stand.
fn surfaces(
    files: &Files,
    reader: &mut Reader,
    nodes: &[Placed],
    (pose, worlds): (&Pose, &HashMap<usize, DMat4>),
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    let document = &files.parsed.document;
    take_memory(files.source, document, nodes)?;
    let (materials, textures) = material::materials(files, &used(document, nodes), warnings)?;
    let mut scene = SceneDescription { materials, textures, ..SceneDescription::default() };
    for placed @ (node, _) in nodes {
        warnings.extend(unsupported::in_node(node));
        let Some(mesh) = node.mesh() else { continue };
        let (weights, joints) = (pose.weights(node), shape::joints(reader, document, node, worlds, warnings)?);
        let mut standing = Standing { to_world: DMat4::IDENTITY, joints, weights };
        for to_world in instance::places(reader, document, placed, warnings)? {
            standing.to_world = to_world;
            for primitive in mesh.primitives() {
                let material = material_of(document, &primitive);
                let textured = scene.materials[material].textured.is_some();
                let mesh = primitive::mesh(reader, (node, &standing), &primitive, textured, warnings)?;
                scene.meshes.extend(mesh.map(|m| Mesh { material: material as u32, ..m }));
            }
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

/// Takes the memory for the primitives, counted at each node that shows them, as often as it does.
fn take_memory(source: &Source, document: &Document, nodes: &[Placed]) -> Result<(), SceneError> {
    let mut size = GeometrySize::default();
    let meshes = nodes.iter().filter_map(|(node, _)| Some((instance::count(document, node), node.mesh()?)));
    for (copies, primitive) in meshes.flat_map(|(copies, mesh)| mesh.primitives().map(move |p| (copies, p))) {
        let textured = [Semantic::TexCoords(0), Semantic::Colors(0)].iter().any(|s| primitive.get(s).is_some());
        let material = primitive.material();
        let emits = material.emissive_factor() != [0.0; 3] || unsupported::is_unlit(&material);
        size.add(primitive::triangle_count(&primitive).saturating_mul(copies), emits, textured);
    }
    size.take(source)
}
