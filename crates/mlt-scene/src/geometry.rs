//! From a file's vertices to a mesh that the renderer can rely on.

use glam::{DVec3, Vec3};
use mlt_core::transport::mesh::Mesh;
use std::collections::HashSet;

/// The most triangles, or vertices, that a scene may have.
pub(crate) const MAX_ELEMENTS: usize = 1 << 27;

/// The largest coordinate: areas and squared distances still fit f32.
const MAX_COORDINATE: f64 = 1e9;

/// Triangles of one material as a file gives them, before anything is checked.
pub(crate) struct RawMesh<P, N> {
    /// Name in the file.
    pub name: String,
    /// Corners, each a vertex that `position` knows.
    pub triangles: Vec<[u32; 3]>,
    /// World position of a vertex.
    pub position: P,
    /// World normal of a vertex, of any length; `None`: flat.
    pub normal: Option<N>,
}

impl<P: Fn(u32) -> DVec3, N: Fn(u32) -> Vec3> RawMesh<P, N> {
    /// Keeps the triangles that have an area and the vertices that they use; `None`: nothing is left.
    ///
    /// The material is left at 0 for the caller to set.
    pub fn finish(self, warnings: &mut Vec<String>) -> Option<Mesh> {
        let corners = || self.triangles.iter().flatten().copied();
        let (first, last) = (corners().min()?, corners().max()?);
        let mut local = vec![u32::MAX; (last - first) as usize + 1];
        let mut mesh = Mesh { name: self.name, ..Mesh::default() };
        let (mut bad, mut lost) = (HashSet::new(), 0usize);
        for &corners in &self.triangles {
            let points = corners.map(&self.position);
            let usable = points.map(is_usable);
            if usable.contains(&false) {
                lost += 1;
                bad.extend((0..3).filter(|&k| !usable[k]).map(|k| corners[k]));
                continue;
            }
            if (points[1] - points[0]).cross(points[2] - points[0]) == DVec3::ZERO {
                continue;
            }
            mesh.triangles.push([0, 1, 2].map(|k| {
                let slot = &mut local[(corners[k] - first) as usize];
                if *slot == u32::MAX {
                    *slot = mesh.positions.len() as u32;
                    mesh.positions.push(points[k]);
                    mesh.normals.extend(self.normal.as_ref().map(|normal| normal(corners[k]).normalize_or_zero()));
                }
                *slot
            }));
        }
        if lost > 0 {
            let (name, count) = (&mesh.name, bad.len());
            warnings.push(format!(
                "mesh `{name}`: {count} vertices have coordinates that are not numbers or beyond {MAX_COORDINATE:e}; \
                 the {lost} triangles that use them are dropped"
            ));
        }
        repair_normals(&mut mesh, warnings);
        (!mesh.triangles.is_empty()).then_some(mesh)
    }
}

/// Whether a vertex can be rendered.
fn is_usable(p: DVec3) -> bool {
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
    warnings.push(format!("mesh `{name}`: {bad} normals have no direction; the triangles' own stand in for them"));
}
