//! Wavefront OBJ with its material libraries.

mod gloss;
mod library;
mod maps;
mod material;
mod polygon;
mod text;
mod texture;

use crate::{
    LoadOptions, Loaded, SceneError,
    geometry::{Attributes, GeometrySize, RawMesh},
    outline::{self, Entry},
    source::Source,
    text::shown,
};
use glam::{DVec3, Vec2, Vec3};
use library::Library;
use maps::Statements;
use material::Textures;
use mlt_core::transport::Rgb;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{SceneDescription, srgb_to_linear};
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
    let text = text::decode(bytes);
    let reduced = Reduced::new(&text);
    let mut warnings = reduced.warnings();
    let library = library::read(source, &reduced, &mut warnings)?;
    let models = parse(source, &reduced, &library).or_else(|error| {
        let models = parse(source, &reduced.without_coordinates(&text), &library).map_err(|_| error)?;
        warnings.push("faces name texture coordinates that are not there; all are left out".to_owned());
        Ok::<_, SceneError>(models)
    })?;
    let description = describe(source, models, &library, &mut warnings)?;
    let name = source.path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let outline = outline(&description);
    Ok(Loaded { name, description, outline, warnings, digest: source.digest(), neutral_sky: false })
}

/// Its meshes.
fn outline(scene: &SceneDescription) -> Vec<Entry> {
    let entry = |mesh: &Mesh| {
        let material = shown(&scene.materials[mesh.material as usize].name);
        Entry { depth: 0, name: mesh.name.clone(), parts: vec![outline::mesh(mesh.triangles.len(), &[material], 1)] }
    };
    scene.meshes.iter().map(entry).collect()
}

fn parse(source: &Source, reduced: &Reduced, library: &Library) -> Result<Vec<tobj::Model>, SceneError> {
    let options = tobj::LoadOptions { single_index: true, ignore_points: true, ignore_lines: true, triangulate: false };
    let parse = |numbered: &mut Numbered| {
        let read = |_: &Path| Ok((library.materials.clone(), library.places.clone().into_iter().collect()));
        tobj::load_obj_buf(&mut MTLLIB.chain(numbered), &options, read).map_err(|e| e.to_string())
    };
    Ok(text::parse(&source.path, "OBJ", &reduced.text, parse)?.0)
}

fn describe(
    source: &Source,
    models: Vec<tobj::Model>,
    library: &Library,
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    let mut scene = materials(source, &models, library, warnings)?;
    let grey = library.materials.len();
    let material_of = |mesh: &tobj::Mesh| mesh.material_id.unwrap_or(grey);
    let mut size = GeometrySize::default();
    for tobj::Model { mesh, .. } in &models {
        let material = &scene.materials[material_of(mesh)];
        size.add(triangle_count(mesh), material.emission != Rgb::ZERO, material.textured.is_some());
    }
    size.take(source)?;
    for model in models {
        let material = material_of(&model.mesh);
        let textured = scene.materials[material].textured.is_some();
        scene.meshes.extend(mesh(model, textured, warnings).map(|m| Mesh { material: material as u32, ..m }));
    }
    if scene.meshes.is_empty() {
        warnings.push("the scene has no triangles".to_owned());
    }
    Ok(scene)
}

/// All materials, behind them grey for what has none, and the textures of those in use.
fn materials(
    source: &Source,
    models: &[tobj::Model],
    library: &Library,
    warnings: &mut Vec<String>,
) -> Result<SceneDescription, SceneError> {
    let grey = library.materials.len();
    let used = |i: usize| models.iter().any(|m| m.mesh.material_id.unwrap_or(grey) == i);
    let coloured =
        |i: usize| models.iter().any(|m| m.mesh.material_id.unwrap_or(grey) == i && !m.mesh.vertex_color.is_empty());
    let statements = |i: usize| Statements::of(&library.materials[i], &library.folders[i]);
    let mut images = maps::decode(source, (0..grey).filter(|&i| used(i)).map(statements), warnings)?;
    let mut scene = SceneDescription::default();
    for (i, material) in library.materials.iter().enumerate() {
        let statements = statements(i);
        let textures = Textures { statements: &statements, images: &mut images, coloured: coloured(i) };
        scene.materials.push(material::material(material, textures, warnings));
    }
    if used(grey) {
        scene.materials.push(material::grey(coloured(grey)));
    }
    scene.textures = images.into_textures();
    Ok(scene)
}

fn mesh(model: tobj::Model, textured: bool, warnings: &mut Vec<String>) -> Option<Mesh> {
    let tobj::Model { mesh, name } = model;
    let name = shown(&name);
    let (positions, _) = mesh.positions.as_chunks::<3>();
    let (normals, _) = mesh.normals.as_chunks::<3>();
    let smooth = !normals.is_empty() && normals.len() == positions.len();
    if !smooth && !normals.is_empty() {
        warnings.push(format!("mesh `{name}`: some vertices have normals and some have none; all are left out"));
    }
    let (coordinates, _) = mesh.texcoords.as_chunks::<2>();
    let (colours, _) = mesh.vertex_color.as_chunks::<3>();
    // v grows upwards in OBJ.
    let uv = |i: u32| Vec2::new(coordinates[i as usize][0] as f32, 1.0 - coordinates[i as usize][1] as f32);
    let colour = |i: u32| Vec3::from_array(colours[i as usize].map(|c| srgb_to_linear(c as f32))).extend(1.0);
    let (has_uv, has_colours) = [coordinates.len(), colours.len()].map(|n| textured && n == positions.len()).into();
    let triangles = triangles(&mesh, positions, &name, warnings);
    let raw = RawMesh {
        name,
        triangles,
        position: |i| DVec3::from_array(positions[i as usize]),
        normal: smooth
            .then_some(|i: u32| -> Vec3 { DVec3::from_array(normals[i as usize]).normalize_or_zero().as_vec3() }),
        attributes: Attributes {
            uv: [has_uv.then_some(&uv), None],
            colour: has_colours.then_some(&colour),
            tangent: None,
        },
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
