//! glTF's mesh primitives.

use super::{
    CHECK,
    accessor::{Reader, Vectors},
    graph::place,
    parse::DRACO,
    shape::{Standing, Vertices},
    texture::Slots,
};
use crate::{
    SceneError,
    geometry::{Attributes, RawMesh},
    tangents,
};
use glam::{DMat3, DVec3, Vec2, Vec4};
use gltf::{Accessor, Node, Primitive, Semantic, mesh::Mode};
use mlt_core::transport::geometry::Mesh;
use std::rc::Rc;

/// Attributes of a primitive's vertices that its material's textures need.
#[derive(Default)]
struct TextureData<'a> {
    uv: [Option<Rc<Vectors<'a>>>; 2],
    colours: Option<Rc<Vectors<'a>>>,
    tangents: Option<Rc<Vectors<'a>>>,
}

impl<'a> TextureData<'a> {
    /// Of as many vertices as there are; what has another number of them is left out.
    fn read(reader: &mut Reader<'a>, primitive: &Primitive, count: usize) -> Result<Self, SceneError> {
        let mut read = |semantic: Semantic, components: &[usize]| -> Result<_, SceneError> {
            let found = primitive.get(&semantic).map(|accessor| reader.any_vectors(&accessor)).transpose()?;
            Ok(found.filter(|v| v.count() == count && components.contains(&v.components())))
        };
        Ok(Self {
            uv: [read(Semantic::TexCoords(0), &[2])?, read(Semantic::TexCoords(1), &[2])?],
            colours: read(Semantic::Colors(0), &[3, 4])?,
            tangents: read(Semantic::Tangents, &[4])?,
        })
    }
}

/// The triangles of a primitive in world space.
struct Surface<'a, 's> {
    vertices: Vertices<'a, 's>,
    /// Counter-clockwise from the front.
    triangles: Vec<[u32; 3]>,
    /// The linear map of the first corner.
    linear: DMat3,
}

impl<'a, 's> Surface<'a, 's> {
    /// `None`: there are none.
    fn read(
        reader: &mut Reader<'a>,
        primitive: &Primitive,
        standing: &'s Standing,
        (place, warnings): (&str, &mut Vec<String>),
    ) -> Result<Option<Self>, SceneError> {
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            warnings.push(format!("{place}: there are no positions; it is left out: export the mesh again"));
            return Ok(None);
        };
        check_compression(reader, primitive, &positions)?;
        let positions = reader.vectors(&positions)?;
        let vertices = Vertices::read(reader, primitive, positions, standing, (place, warnings))?;
        let corners = corners(reader, primitive, vertices.count(), place)?;
        let Some(mut triangles) = triangles(primitive.mode(), &corners) else {
            warnings.push(format!("{place}: points and lines are not supported; they are left out: make meshes of them (Blender: Object > Convert > Mesh)"));
            return Ok(None);
        };
        let linear = corners.first().map_or(DMat3::IDENTITY, |&first| vertices.linear(first));
        if is_mirrored(linear) {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(Some(Self { vertices, triangles, linear }))
    }

    /// A mesh of them; `None`: all are degenerate.
    fn mesh(self, name: String, data: &TextureData, warnings: &mut Vec<String>) -> Option<Mesh> {
        let Self { vertices, triangles, linear } = self;
        let vertices = &vertices;
        let uv = data.uv.each_ref().map(|set| set.as_deref().map(|set| move |i: u32| Vec2::from(set.at::<2>(i))));
        let colour = data.colours.as_deref().map(|colours| move |i: u32| rgba(colours, i));
        let handedness = if is_mirrored(linear) { -1.0 } else { 1.0 };
        let tangent = data.tangents.as_deref().map(|tangents| {
            move |i: u32| {
                let [x, y, z, w] = tangents.at::<4>(i);
                let tangent = vertices.linear(i) * DVec3::from_array([x, y, z].map(f64::from));
                tangent.normalize_or_zero().as_vec3().extend(w * handedness)
            }
        });
        let raw = RawMesh {
            name,
            triangles,
            position: |i| vertices.position(i),
            normal: vertices.have_normals().then_some(|i| vertices.normal(i).as_vec3()),
            attributes: Attributes {
                uv: uv.each_ref().map(|set| set.as_ref().map(|set| set as &dyn Fn(u32) -> Vec2)),
                colour: colour.as_ref().map(|colour| colour as &dyn Fn(u32) -> Vec4),
                tangent: tangent.as_ref().map(|tangent| tangent as &dyn Fn(u32) -> Vec4),
            },
        };
        raw.finish(warnings)
    }
}

/// Whether a map turns the triangles' front to the back.
fn is_mirrored(linear: DMat3) -> bool {
    linear.determinant() < 0.0
}

/// The primitive in world space; `None`: it has no triangles. `textured`: whether its material reads textures or colours.
pub(super) fn mesh(
    reader: &mut Reader,
    (node, standing): (&Node, &Standing),
    primitive: &Primitive,
    textured: bool,
    warnings: &mut Vec<String>,
) -> Result<Option<Mesh>, SceneError> {
    let place = format!("{}, primitive {}", place(node), primitive.index());
    let Some(surface) = Surface::read(reader, primitive, standing, (&place, warnings))? else { return Ok(None) };
    let data = match textured {
        true => TextureData::read(reader, primitive, surface.vertices.count())?,
        false => TextureData::default(),
    };
    let name = node.name().or_else(|| node.mesh()?.name()).map_or(place, str::to_owned);
    let linear = surface.linear;
    let mut mesh = surface.mesh(name, &data, warnings);
    if let (Some(mesh), Some(set)) = (&mut mesh, Slots::of(&primitive.material()).tangents()) {
        tangents::add(mesh, set, linear);
    }
    Ok(mesh)
}

/// Refuses a primitive whose data is found in its compressed form only.
fn check_compression(reader: &Reader, primitive: &Primitive, positions: &Accessor) -> Result<(), SceneError> {
    match primitive.extension_value(DRACO) {
        Some(_) if positions.view().is_none() => Err(reader.source.compressed(DRACO)),
        _ => Ok(()),
    }
}

/// How many triangles the primitive draws at most, known without its data.
pub(super) fn triangle_count(primitive: &Primitive) -> usize {
    let corners = primitive.indices().or_else(|| primitive.get(&Semantic::Positions)).map_or(0, |a| a.count());
    match primitive.mode() {
        Mode::Triangles => corners / 3,
        Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
    }
}

/// The vertex at each corner, in range.
fn corners(reader: &Reader, primitive: &Primitive, vertices: usize, place: &str) -> Result<Vec<u32>, SceneError> {
    let Some(accessor) = primitive.indices() else {
        return Ok((0..vertices as u32).collect());
    };
    let corners = reader.indices(&accessor)?;
    match corners.iter().find(|&&c| c as usize >= vertices) {
        Some(c) => Err(reader.source.invalid(place, format!("the index {c} is beyond its {vertices} vertices"), CHECK)),
        None => Ok(corners),
    }
}

/// Counter-clockwise triangles; `None`: the mode draws none.
fn triangles(mode: Mode, corners: &[u32]) -> Option<Vec<[u32; 3]>> {
    let windows = corners.windows(3);
    Some(match mode {
        Mode::Triangles => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        Mode::TriangleStrip => {
            windows.enumerate().map(|(i, c)| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] }).collect()
        }
        Mode::TriangleFan => windows.map(|c| [c[1], c[2], corners[0]]).collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return None,
    })
}

/// A colour, opaque where it has no alpha.
fn rgba(colours: &Vectors, i: u32) -> Vec4 {
    let [r, g, b, a] = colours.at::<4>(i);
    Vec4::new(r, g, b, if colours.components() == 4 { a } else { 1.0 })
}
