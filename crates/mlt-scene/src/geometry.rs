//! From a file's vertices to a mesh that the renderer can rely on.

use crate::{SceneError, source::Source, text::shown};
use glam::{DVec3, Vec2, Vec3, Vec4};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::Scene;
use std::collections::HashSet;

/// Attributes of vertices besides positions and normals, by their numbers in the file.
#[derive(Clone, Copy, Default)]
pub(crate) struct Attributes<'a> {
    /// Texture coordinates of two sets.
    pub uv: [Option<&'a dyn Fn(u32) -> Vec2>; 2],
    /// Linear RGBA.
    pub colour: Option<&'a dyn Fn(u32) -> Vec4>,
    /// World direction in which u grows, of any length, and the sign of the bitangent.
    pub tangent: Option<&'a dyn Fn(u32) -> Vec4>,
}

impl Attributes<'_> {
    /// Of the vertices that a mesh keeps; what is no number becomes 0.
    fn add_to(&self, mesh: &mut Mesh, kept: &[u32]) {
        let finite = |v: Vec2| if v.is_finite() { v } else { Vec2::ZERO };
        let sets = self.uv.map(|set| set.map(|uv| kept.iter().map(|&i| finite(uv(i))).collect()));
        mesh.uv = sets.map(Option::unwrap_or_default);
        let four = |of: &dyn Fn(u32) -> Vec4| -> Vec<_> {
            kept.iter().map(|&i| of(i)).map(|v| if v.is_finite() { v } else { Vec4::ZERO }).collect()
        };
        mesh.colours = self.colour.map(four).unwrap_or_default();
        mesh.tangents = self.tangent.map(four).unwrap_or_default();
    }
}

/// How many triangles a scene has, counted before they are made.
#[derive(Default)]
pub(crate) struct GeometrySize {
    triangles: usize,
    emitters: usize,
    textured: usize,
    copies: usize,
}

impl GeometrySize {
    /// Counts the triangles of a mesh.
    pub(crate) fn add(&mut self, triangles: usize, emit: bool, textured: bool) {
        self.triangles = self.triangles.saturating_add(triangles);
        self.emitters = self.emitters.saturating_add(if emit { triangles } else { 0 });
        self.textured = self.textured.saturating_add(if textured { triangles } else { 0 });
    }

    /// Counts copies of a mesh that is held once.
    pub(crate) fn add_copies(&mut self, count: usize) {
        self.copies = self.copies.saturating_add(count);
    }

    /// Takes the memory for them, or refuses the scene. The renderer's needs are greater than those of the mesh in the
    /// making, at most 200 bytes a triangle, and come later.
    pub(crate) fn take(&self, source: &Source) -> Result<(), SceneError> {
        if self.triangles > Scene::MOST_TRIANGLES {
            return Err(source.too_large("the scene", "triangles", Scene::MOST_TRIANGLES));
        }
        let bytes = [
            (self.triangles, Scene::BYTES_PER_TRIANGLE),
            (self.emitters, Scene::BYTES_PER_EMITTER),
            (self.textured, Scene::BYTES_PER_TEXTURED_TRIANGLE),
            (self.copies, Scene::BYTES_PER_COPY),
        ];
        let bytes = bytes.iter().map(|&(count, each)| (count as u64).saturating_mul(each)).fold(0, u64::saturating_add);
        source.take(bytes, format!("the geometry of {} triangles", self.triangles))
    }
}

/// The largest coordinate: areas and squared distances still fit f32.
const MAX_COORDINATE: f64 = 1e9;

/// Triangles of one material as a file gives them, before anything is checked.
pub(crate) struct RawMesh<'a, P, N> {
    /// Name in the file.
    pub name: String,
    /// Corners, each a vertex that `position` knows.
    pub triangles: Vec<[u32; 3]>,
    /// World position of a vertex.
    pub position: P,
    /// World normal of a vertex, of any length; `None`: flat.
    pub normal: Option<N>,
    /// Attributes that textures need.
    pub attributes: Attributes<'a>,
}

impl<P: Fn(u32) -> DVec3, N: Fn(u32) -> Vec3> RawMesh<'_, P, N> {
    /// Keeps the triangles that have an area and the vertices that they use; `None`: nothing is left.
    ///
    /// The material is left at 0 for the caller to set.
    pub(crate) fn finish(self, warnings: &mut Vec<String>) -> Option<Mesh> {
        let mut mesh = Mesh { name: shown(&self.name), ..Mesh::default() };
        let (mut bad, mut lost) = (HashSet::new(), 0usize);
        for &corners in &self.triangles {
            let points = corners.map(&self.position);
            let usable = points.map(is_usable);
            if usable.contains(&false) {
                lost += 1;
                bad.extend((0..3).filter(|&k| !usable[k]).map(|k| corners[k]));
            } else if (points[1] - points[0]).cross(points[2] - points[0]) != DVec3::ZERO {
                mesh.triangles.push(corners);
            }
        }
        if lost > 0 {
            let (name, count) = (&mesh.name, bad.len());
            warnings.push(format!(
                "mesh `{name}`: {count} vertices have coordinates that are not numbers or beyond {MAX_COORDINATE:e}; \
                 the {lost} triangles that use them are dropped: look for vertices that are far away, and delete them"
            ));
        }
        let used = renumber(&mut mesh.triangles);
        mesh.positions = used.iter().map(|&i| (self.position)(i)).collect();
        if let Some(normal) = &self.normal {
            mesh.normals = used.iter().map(|&i| normal(i).normalize_or_zero()).collect();
        }
        self.attributes.add_to(&mut mesh, &used);
        repair_normals(&mut mesh, warnings);
        (!mesh.triangles.is_empty()).then_some(mesh)
    }
}

/// Numbers the vertices in the order of their use; returns their former numbers.
///
/// The work depends on how many corners there are, and not on how far apart their vertices lie in the file.
fn renumber(triangles: &mut [[u32; 3]]) -> Vec<u32> {
    let mut sorted = triangles.as_flattened().to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let mut numbers = vec![u32::MAX; sorted.len()];
    let mut used = Vec::with_capacity(sorted.len());
    for corner in triangles.as_flattened_mut() {
        let number = &mut numbers[sorted.partition_point(|former| former < corner)];
        if *number == u32::MAX {
            *number = used.len() as u32;
            used.push(*corner);
        }
        *corner = *number;
    }
    used
}

/// Whether a vertex can be rendered.
pub(crate) fn is_usable(p: DVec3) -> bool {
    p.is_finite() && p.abs().max_element() <= MAX_COORDINATE
}

/// Puts the mean of the adjoining triangles' normals, weighted by area, where a normal has no direction.
fn repair_normals(mesh: &mut Mesh, warnings: &mut Vec<String>) {
    let bad = mesh.normals.iter().filter(|n| **n == Vec3::ZERO).count();
    if bad == 0 {
        return;
    }
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|&i| sums[i as usize] += normal);
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums).filter(|(n, _)| **n == Vec3::ZERO) {
        *normal = sum.normalize_or(DVec3::Y).as_vec3();
    }
    let name = &mesh.name;
    warnings.push(format!("mesh `{name}`: {bad} normals have no direction; the triangles' own stand in for them (Blender: Mesh > Normals > Recalculate Outside)"));
}
