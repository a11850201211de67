//! Wavefront OBJ with its material libraries.

mod library;
mod material;
mod polygon;
mod text;

use crate::{
    LoadOptions, Loaded, SceneError,
    geometry::{Attributes, GeometrySize, RawMesh},
    source::Source,
    text::shown,
};
use glam::{DVec3, Vec3};
use library::Library;
use mlt_core::transport::Rgb;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::SceneDescription;
use std::{io::Read, path::Path};
use text::{Numbered, Reduced};

/// A line for the parser to ask for the materials at, before all others: all libraries at once.
const MTLLIB: &[u8] = b"mtllib all\n";

/// Memory that the parser needs for each byte of a text: 6 to 9 were measured.
const BYTES_PER_BYTE: u64 = 8;

/// Loads every object of the file; OBJ has no cameras, and one scene.
pub(crate) fn load(source: &Source, options: &LoadOptions) -> Result<Loaded, SceneError> {
    if let Some(name) = &options.scene {
        return Err(source.no_scene(name, &[]));
    }
    let bytes = source.read()?;
    source.take(bytes.len() as u64 * BYTES_PER_BYTE, "the text")?;
    let reduced = Reduced::new(&text::decode(bytes));
    let mut warnings = reduced.warnings();
    let Library { materials, places } = library::read(source, &reduced, &mut warnings)?;
    let options = tobj::LoadOptions { single_index: true, ignore_points: true, ignore_lines: true, triangulate: false };
    let parse = |numbered: &mut Numbered| {
        let library = |_: &Path| Ok((materials.clone(), places.clone().into_iter().collect()));
        tobj::load_obj_buf(&mut MTLLIB.chain(numbered), &options, library).map_err(|e| e.to_string())
    };
    let (models, _) = text::parse(&source.path, "OBJ", &reduced.text, parse)?;
    let description = describe(source, models, &materials, &mut warnings)?;
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Loaded { name, description, warnings, lights_left_out: 0 })
}

fn describe(
    source: &Source,
    models: Vec<tobj::Model>,
    materials: &[tobj::Material],
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    let materials = materials.iter().map(|m| material::material(m, warnings)).collect();
    let mut scene = SceneDescription { materials, ..SceneDescription::default() };
    let grey = scene.materials.len();
    if models.iter().any(|m| m.mesh.material_id.is_none()) {
        scene.materials.push(material::grey());
    }
    let mut size = GeometrySize::default();
    let emits = |m: &tobj::Mesh| m.material_id.is_some_and(|i| scene.materials[i].emission != Rgb::ZERO);
    models.iter().for_each(|m| size.add(triangle_count(&m.mesh), emits(&m.mesh), false));
    size.take(source)?;
    for model in models {
        let material = model.mesh.material_id.unwrap_or(grey) as u32;
        scene.meshes.extend(mesh(model, warnings).map(|m| Mesh { material, ..m }));
    }
    if scene.meshes.is_empty() {
        warnings.push("the scene has no triangles".to_owned());
    }
    Ok(scene)
}

fn mesh(model: tobj::Model, warnings: &mut Vec<String>) -> Option<Mesh> {
    let tobj::Model { mesh, name } = model;
    let name = shown(&name);
    let (positions, _) = mesh.positions.as_chunks::<3>();
    let (normals, _) = mesh.normals.as_chunks::<3>();
    let smooth = !normals.is_empty() && normals.len() == positions.len();
    if !smooth && !normals.is_empty() {
        warnings.push(format!("mesh `{name}`: some vertices have normals and some have none; all are left out"));
    }
    let triangles = triangles(&mesh, positions, &name, warnings);
    let raw = RawMesh {
        name,
        triangles,
        position: |i| DVec3::from_array(positions[i as usize]),
        normal: smooth
            .then_some(|i: u32| -> Vec3 { DVec3::from_array(normals[i as usize]).normalize_or_zero().as_vec3() }),
        attributes: Attributes::default(),
    };
    raw.finish(warnings)
}

/// How many triangles the faces give; the parser lists no arities where all are triangles.
fn triangle_count(mesh: &tobj::Mesh) -> usize {
    match mesh.face_arities.len() {
        0 => mesh.indices.len() / 3,
        faces => mesh.indices.len().saturating_sub(2 * faces),
    }
}

/// The faces as triangles.
fn triangles(mesh: &tobj::Mesh, positions: &[[f64; 3]], name: &str, warnings: &mut Vec<String>) -> Vec<[u32; 3]> {
    if mesh.face_arities.is_empty() {
        return mesh.indices.as_chunks::<3>().0.to_vec();
    }
    let (mut rest, mut triangles, mut crossing) = (&mesh.indices[..], Vec::new(), 0usize);
    for &corners in &mesh.face_arities {
        let (face, others) = rest.split_at(corners as usize);
        rest = others;
        let points: Vec<_> = face.iter().map(|&i| DVec3::from_array(positions[i as usize])).collect();
        let polygon::Cut { triangles: cut, crosses } = polygon::cut(&points);
        triangles.extend(cut.iter().map(|triangle| triangle.map(|i| face[i])));
        crossing += usize::from(crosses);
    }
    if crossing > 0 {
        warnings.push(format!("mesh `{name}`: the outlines of {crossing} polygons cross themselves; fans stand in"));
    }
    triangles
}
