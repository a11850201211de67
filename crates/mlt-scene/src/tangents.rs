//! Tangents of meshes that bring none, as those had them whose normal maps were made from other surfaces.
//!
//! Source: [Mikkelsen08]; glTF asks for it.

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::{DMat3, DVec3, Vec2, Vec3, Vec4};
use mlt_core::transport::geometry::Mesh;
use std::collections::HashMap;

/// Gives a smooth mesh tangents that follow a set of its texture coordinates. A vertex where they differ from triangle to triangle
/// becomes several. A flat mesh has those of its triangles.
///
/// Tangents are those of the mesh as it is made, which `linear` has brought to the world: they are found there and brought to the world, too.
pub(crate) fn add(mesh: &mut Mesh, set: usize, linear: DMat3) {
    if !mesh.tangents.is_empty() || mesh.uv[set].is_empty() || mesh.normals.is_empty() {
        return;
    }
    let (linear, inverse) = match linear.inverse() {
        inverse if inverse.is_finite() => (linear, inverse),
        _ => (DMat3::IDENTITY, DMat3::IDENTITY),
    };
    let mut corners = Corners { mesh, set, linear, inverse, tangents: vec![Vec4::ZERO; 3 * mesh.triangles.len()] };
    if generate_tangents(&mut corners).is_ok() {
        let tangents = corners.tangents;
        part(mesh, &tangents);
    }
}

/// The corners of a mesh's triangles.
struct Corners<'a> {
    mesh: &'a Mesh,
    set: usize,
    /// From the mesh as it is made to the world.
    linear: DMat3,
    inverse: DMat3,
    tangents: Vec<Vec4>,
}

/// The same bits on every machine.
struct Portable;

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acosf(x)
    }
}

impl Corners<'_> {
    fn of<T: Copy>(&self, values: &[T], triangle: usize, corner: usize) -> T {
        values[self.mesh.triangles[triangle][corner] as usize]
    }
}

impl Geometry<Portable> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, triangle: usize, corner: usize) -> [f32; 3] {
        // Relative to one of them, so that f32 is fine enough far away.
        let origin = self.mesh.positions.first().copied().unwrap_or(DVec3::ZERO);
        (self.inverse * (self.of(&self.mesh.positions, triangle, corner) - origin)).as_vec3().to_array()
    }

    fn normal(&self, triangle: usize, corner: usize) -> [f32; 3] {
        // What the inverse transpose took to the world.
        let normal = self.linear.transpose() * self.of(&self.mesh.normals, triangle, corner).as_dvec3();
        normal.normalize_or_zero().as_vec3().to_array()
    }

    fn tex_coord(&self, triangle: usize, corner: usize) -> [f32; 2] {
        self.of(&self.mesh.uv[self.set], triangle, corner).to_array()
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, triangle: usize, corner: usize) {
        if let Some(found) = found {
            let [x, y, z, sign] = found.tangent_encoded();
            // In glTF v grows downwards, and the bitangent leads upwards.
            let tangent = self.linear * Vec3::new(x, y, z).as_dvec3();
            self.tangents[3 * triangle + corner] = tangent.normalize_or_zero().as_vec3().extend(-sign);
        }
    }
}

/// Gives each vertex its corners' tangent, and a copy of it to those that have another one.
fn part(mesh: &mut Mesh, tangents: &[Vec4]) {
    let (mut numbers, mut former) = (HashMap::new(), Vec::new());
    mesh.tangents = Vec::new();
    for (corner, tangent) in mesh.triangles.as_flattened_mut().iter_mut().zip(tangents) {
        let key = (*corner, tangent.to_array().map(f32::to_bits));
        let number = *numbers.entry(key).or_insert(former.len() as u32);
        if number as usize == former.len() {
            former.push(*corner);
            mesh.tangents.push(*tangent);
        }
        *corner = number;
    }
    fn copied<T: Copy>(values: &[T], former: &[u32]) -> Vec<T> {
        if values.is_empty() { Vec::new() } else { former.iter().map(|&i| values[i as usize]).collect() }
    }
    mesh.positions = copied(&mesh.positions, &former);
    mesh.normals = copied(&mesh.normals, &former);
    mesh.uv = mesh.uv.each_ref().map(|set: &Vec<Vec2>| copied(set, &former));
    mesh.colours = copied(&mesh.colours, &former);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4Swizzles;

    /// Two quads side by side in the xy plane, u to the right on the first and to the left on the second, v downwards.
    fn mirrored() -> Mesh {
        let column = |x: f64, u: f32| [(0.0, 1.0), (1.0, 0.0)].map(|(y, v)| (DVec3::new(x, y, 0.0), Vec2::new(u, v)));
        let vertices: Vec<_> = [column(-1.0, 0.0), column(0.0, 1.0), column(1.0, 0.0)].into_iter().flatten().collect();
        Mesh {
            positions: vertices.iter().map(|v| v.0).collect(),
            normals: vec![Vec3::Z; 6],
            uv: [vertices.iter().map(|v| v.1).collect(), Vec::new()],
            triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
            ..Mesh::default()
        }
    }

    /// Tangents lead along u and bitangents upwards in the image; where the two meet, vertices are parted.
    #[test]
    fn tangents_follow_the_coordinates() {
        let mut mesh = mirrored();
        add(&mut mesh, 0, DMat3::IDENTITY);
        assert_eq!((mesh.positions.len(), mesh.tangents.len(), mesh.uv[0].len()), (8, 8, 8));
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            for &corner in triangle {
                let (tangent, normal) = (mesh.tangents[corner as usize], mesh.normals[corner as usize]);
                let along = if i < 2 { Vec3::X } else { Vec3::NEG_X };
                assert!(tangent.xyz().distance(along) < 1e-5, "{i}: {tangent}");
                assert!((normal.cross(tangent.xyz()) * tangent.w).distance(Vec3::Y) < 1e-5, "{i}: {tangent}");
            }
        }
        let bare = Mesh { uv: [Vec::new(), Vec::new()], ..mirrored() };
        let mut same = bare.clone();
        add(&mut same, 0, DMat3::IDENTITY);
        assert!(same.tangents.is_empty() && same.triangles == bare.triangles);
    }
}
