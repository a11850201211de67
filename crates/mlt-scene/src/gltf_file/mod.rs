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
mod outline;
mod parse;
mod primitive;
mod rotation;
mod shape;
mod sharing;
mod texture;
mod unsupported;

use crate::{
    LoadOptions, Loaded, SceneError,
    geometry::GeometrySize,
    source::{Hashes, Source},
};
use accessor::Reader;
use animation::Pose;
use buffer::Buffers;
use glam::DMat4;
use gltf::{Document, Primitive, Semantic};
use graph::{Graph, Placed};
use material::Used;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{Material, SceneDescription, Texture};
use parse::Parsed;
use shape::Standing;
use sharing::{Prototypes, Sharing};
use std::collections::{HashMap, HashSet};
use texture::Files;

/// The remedy for a file that contradicts itself.
const CHECK: &str = "export the scene again or check it with a glTF validator";

/// Data that a file has at any time of its animations, to be read once.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    parsed: Option<Parsed>,
    surfaces: Option<Surfaces>,
    hashes: Hashes,
}

/// Materials and textures, and what could not be taken over of them.
type Surfaces = (Vec<Material>, Vec<Texture>, Vec<String>);

/// Loads the scene that is asked for, or that the file shows by default, and keeps what stays the same at other times; the
/// other options have to be the same then.
pub(crate) fn load(source: &Source, options: &LoadOptions, kept: &mut Kept) -> Result<Loaded, SceneError> {
    let Kept { parsed, surfaces: kept_surfaces, hashes } = kept;
    source.note(hashes);
    let parsed = match parsed {
        Some(parsed) => &*parsed,
        none => none.insert(parse::parse(source)?),
    };
    let document = &parsed.document;
    let buffers = Buffers::new(source, parsed);
    let files = Files { source, parsed, buffers: &buffers };
    let mut reader = Reader::new(source, parsed, &buffers);
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
    let sharing = Sharing::new(document, &nodes, options.copies);
    take_memory(source, document, &nodes, &sharing)?;
    let (materials, textures, left_out) = match kept_surfaces {
        Some(kept) => kept.clone(),
        none => none.insert(surfaces(&files, &nodes)?).clone(),
    };
    warnings.extend(left_out);
    let surfaces = SceneDescription { cameras, materials, textures, ..SceneDescription::default() };
    let mut description = with_meshes(surfaces, &mut reader, (&nodes, &sharing), (&pose, &worlds), &mut warnings)?;
    light::add(lights, source, &mut description)?;
    let scene = graph.chosen(source, options.scene.as_deref())?;
    description.environment = image_light::environment(&files, scene.as_ref(), &mut warnings)?;
    *hashes = source.hashes();
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let outline = outline::outline(document, &nodes);
    Ok(Loaded { name, description, outline, warnings, digest: source.digest(), neutral_sky: false })
}

/// The materials that some nodes show.
fn surfaces(files: &Files, nodes: &[Placed]) -> Result<Surfaces, SceneError> {
    let mut warnings = Vec::new();
    let (materials, textures) = material::materials(files, &used(&files.parsed.document, nodes), &mut warnings)?;
    Ok((materials, textures, warnings))
}

/// Adds the meshes at these nodes to a scene that has their materials; `worlds`: where all nodes of the file stand.
fn with_meshes(
    mut scene: SceneDescription,
    reader: &mut Reader,
    (nodes, sharing): (&[Placed], &Sharing),
    (pose, worlds): (&Pose, &HashMap<usize, DMat4>),
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    let (document, mut prototypes) = (reader.document(), Prototypes::default());
    for placed @ (node, _) in nodes {
        warnings.extend(unsupported::in_node(node));
        let Some(mesh) = node.mesh() else { continue };
        let (weights, joints) = (pose.weights(node), shape::joints(reader, document, node, worlds, warnings)?);
        let mut standing = Standing { to_world: DMat4::IDENTITY, joints, weights };
        let places = instance::places(reader, document, placed, warnings)?;
        let mut surface = |standing: &Standing, primitive: &Primitive| -> Result<_, SceneError> {
            let material = material_of(document, primitive);
            let textured = scene.materials[material].textured.is_some();
            let mesh = primitive::mesh(reader, (node, standing), primitive, textured, warnings)?;
            Ok(mesh.map(|m| Mesh { material: material as u32, ..m }))
        };
        let (held, baked): (Vec<_>, Vec<_>) =
            mesh.primitives().partition(|p| sharing.holds(document, (node, &mesh), p));
        if !held.is_empty() {
            prototypes.add(mesh.index(), &places, || held.iter().map(|p| surface(&standing, p)).collect())?;
        }
        for to_world in places {
            standing.to_world = to_world;
            for primitive in &baked {
                scene.meshes.extend(surface(&standing, primitive)?);
            }
        }
    }
    scene.prototypes = prototypes.usable(warnings);
    if scene.meshes.is_empty() && scene.prototypes.is_empty() {
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

/// Takes the memory for the primitives, counted at each node that shows them, as often as it does, if they are not held once.
fn take_memory(source: &Source, document: &Document, nodes: &[Placed], sharing: &Sharing) -> Result<(), SceneError> {
    let (mut size, mut known) = (GeometrySize::default(), HashSet::new());
    for (node, mesh) in nodes.iter().filter_map(|(node, _)| Some((node, node.mesh()?))) {
        let copies = instance::count(document, node);
        for primitive in mesh.primitives() {
            let textured = [Semantic::TexCoords(0), Semantic::Colors(0)].iter().any(|s| primitive.get(s).is_some());
            let times = match sharing.holds(document, (node, &mesh), &primitive) {
                true => {
                    size.add_copies(copies);
                    usize::from(known.insert((mesh.index(), primitive.index())))
                }
                false => copies,
            };
            let triangles = primitive::triangle_count(&primitive).saturating_mul(times);
            size.add(triangles, unsupported::emits(&primitive.material()), textured);
        }
    }
    size.take(source)
}
