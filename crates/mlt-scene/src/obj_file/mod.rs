//! Wavefront OBJ with its material libraries.

mod material;
mod text;

use crate::{
    Loaded, SceneError,
    geometry::{MAX_ELEMENTS, RawMesh},
    source::Source,
};
use glam::{DVec3, Vec3};
use mlt_core::transport::{description::SceneDescription, mesh::Mesh};
use std::{collections::HashMap, io::Read, path::Path};
use text::{Numbered, Reduced};

/// Materials in the order of their libraries, and where each name is found.
type Library = (Vec<tobj::Material>, HashMap<String, usize>);

/// A line for the parser to ask for the materials at, before all others: all libraries at once.
const MTLLIB: &[u8] = b"mtllib all\n";

/// Loads every object of the file; OBJ has no cameras.
pub(crate) fn load(source: &Source) -> Result<Loaded, SceneError> {
    let bytes = source.read()?;
    let reduced = Reduced::new(&String::from_utf8_lossy(&bytes));
    let mut warnings = reduced.warnings();
    let (materials, places) = libraries(source, &reduced, &mut warnings)?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let parse = |numbered: &mut Numbered| {
        let library = |_: &Path| Ok((materials.clone(), places.clone().into_iter().collect()));
        tobj::load_obj_buf(&mut MTLLIB.chain(numbered), &options, library).map_err(|e| e.to_string())
    };
    let (models, _) = text::parse(&source.path, "OBJ", &reduced.text, parse)?;
    let description = describe(source, models, &materials, &mut warnings)?;
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Loaded { name, description, warnings })
}

/// All material libraries that the file names; one that cannot be read is a warning.
fn libraries(source: &Source, reduced: &Reduced, warnings: &mut Vec<String>) -> Result<Library, SceneError> {
    let (mut materials, mut places, mut complete) = (Vec::new(), HashMap::new(), true);
    for name in &reduced.libraries {
        let bytes = match source.read_beside(name) {
            Ok(bytes) => bytes,
            Err(error) => {
                complete = false;
                warnings.push(format!("{error}; until then grey stands in for its materials"));
                continue;
            }
        };
        let text = text::library(&String::from_utf8_lossy(&bytes));
        let path = source.path.with_file_name(name);
        let parse = |numbered: &mut Numbered| tobj::load_mtl_buf(numbered).map_err(|e| e.to_string());
        let (found, _) = text::parse(&path, "MTL", &text, parse)?;
        places.extend(found.iter().enumerate().map(|(i, m)| (m.name.clone(), materials.len() + i)));
        materials.extend(found);
    }
    let unknown: Vec<_> = reduced.used.iter().filter(|name| !places.contains_key(*name)).cloned().collect();
    if complete && !unknown.is_empty() {
        let names = unknown.join("`, `");
        warnings.push(format!("no material library defines `{names}`; grey stands in"));
    }
    Ok((materials, places))
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
    let mut total = 0;
    for model in models {
        total += model.mesh.indices.len() / 3;
        if total > MAX_ELEMENTS {
            return Err(source.too_large(format!("object `{}`", model.name), "triangles so far", MAX_ELEMENTS));
        }
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
    let (positions, _) = mesh.positions.as_chunks::<3>();
    let (normals, _) = mesh.normals.as_chunks::<3>();
    let smooth = !normals.is_empty() && normals.len() == positions.len();
    if !smooth && !normals.is_empty() {
        warnings.push(format!("mesh `{name}`: some vertices have normals and some have none; all are left out"));
    }
    let raw = RawMesh {
        name,
        triangles: mesh.indices.as_chunks::<3>().0.to_vec(),
        position: |i| DVec3::from_array(positions[i as usize]),
        normal: smooth
            .then_some(|i: u32| -> Vec3 { DVec3::from_array(normals[i as usize]).normalize_or_zero().as_vec3() }),
    };
    raw.finish(warnings)
}
