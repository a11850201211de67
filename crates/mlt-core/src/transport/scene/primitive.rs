//! A triangle with all that a hit needs.

use super::material::Material;
use crate::transport::accel::{COARSE, size};
use crate::transport::geometry::{ERROR_FACTOR, Mesh, Place, Space, Vertex};
use glam::{DVec3, Vec3, Vec3A};

/// [`Primitive::normals`] of a triangle whose shading normal is its own.
pub(super) const FLAT: u32 = u32::MAX;

/// A triangle with all that a hit needs: one cache line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Primitive {
    pub(super) vertices: [Vec3; 3],
    pub(super) normal: Vec3,
    pub(super) material: u32,
    /// Index into the scene's normals, or [`FLAT`].
    pub(super) normals: u32,
    /// Bound on the error of a point interpolated from the vertices. Points of a coarse triangle are rounded where they lie; this
    /// is the bound at the origin, no more than that of the scene's smallest triangle.
    pub(super) error: f32,
    /// As of [`Vertex`](crate::transport::geometry::Vertex).
    pub(super) delta: bool,
    /// As of [`Vertex`](crate::transport::geometry::Vertex).
    pub(super) emits: bool,
    /// Whether its points are found in f64: see [`coarse_size`](crate::transport::accel::coarse_size).
    pub(super) coarse: bool,
    /// Whether another triangle may be seen in its place: see [`ties`](super::ties).
    pub(super) shared: bool,
}

const _: () = assert!(size_of::<Primitive>() == 64);

impl Primitive {
    /// A vertex at a position on it, with its own normal to shade with; `number`: its index.
    #[inline(always)]
    pub(super) fn vertex(&self, number: u32, position: Vec3A) -> Vertex {
        let normal = Vec3A::from(self.normal);
        Vertex {
            position,
            geometric_normal: normal,
            shading_normal: normal,
            primitive: number,
            material: self.material,
            error: self.error,
            delta: self.delta,
            emits: self.emits,
            shared: self.shared,
            place: Place::Surface,
        }
    }

    /// Largest absolute coordinate.
    pub(super) fn reach(&self) -> f32 {
        self.vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f32::max)
    }

    /// Sets the bound on the error of its points, where triangles that are larger than `coarse_size` are coarse.
    pub(super) fn set_error(&mut self, coarse_size: f32) {
        self.coarse = size(&self.vertices) > coarse_size;
        let reach = if self.coarse { coarse_size / COARSE } else { self.reach() };
        self.error = ERROR_FACTOR * reach;
    }

    /// Barycentric weights of the second and third vertex at the foot of `position`; `None` outside.
    pub(super) fn weights(&self, position: Vec3A) -> Option<[f32; 2]> {
        let [u, v] = self.weights_in_plane(position);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some([u as f32, v as f32])
    }

    /// The same of a point that is on the triangle but for rounding.
    pub(super) fn nearest_weights(&self, position: Vec3A) -> [f32; 2] {
        let [u, v] = self.weights_in_plane(position).map(|weight| weight.clamp(0.0, 1.0));
        let excess = (u + v).max(1.0);
        [(u / excess) as f32, (v / excess) as f32]
    }

    fn weights_in_plane(&self, position: Vec3A) -> [f64; 2] {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        let (e, f, p) = (b - a, c - a, position.as_dvec3() - a);
        let n = e.cross(f);
        let square = n.length_squared();
        [p.cross(f), e.cross(p)].map(|area| area.dot(n) / square)
    }
}

/// The triangles of all meshes, one mesh after the other, and the corner normals of those that are not flat. What depends on
/// other triangles is not set.
pub(super) fn primitives(meshes: &[Mesh], materials: &[Material], space: &Space) -> (Vec<Primitive>, Vec<[Vec3; 3]>) {
    let (mut primitives, mut normals) = (Vec::new(), Vec::new());
    for mesh in meshes {
        append(mesh, &materials[mesh.material as usize], space, &mut primitives, &mut normals);
    }
    (primitives, normals)
}

fn append(
    mesh: &Mesh,
    material: &Material,
    space: &Space,
    primitives: &mut Vec<Primitive>,
    normals: &mut Vec<[Vec3; 3]>,
) {
    let smooth = mesh.normals.len() == mesh.positions.len();
    for triangle in &mesh.triangles {
        let vertices = triangle.map(|i| space.point(mesh.positions[i as usize]));
        let [a, b, c] = vertices.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3();
        let corner_normals = if smooth { triangle.map(|i| mesh.normals[i as usize]) } else { [normal; 3] };
        let flat = corner_normals.iter().all(|n| n.distance(normal) < 1e-6);
        primitives.push(Primitive {
            vertices,
            normal,
            material: mesh.material,
            normals: if flat { FLAT } else { normals.len() as u32 },
            error: 0.0,
            delta: material.bsdf.is_delta(),
            emits: material.emission.max_element() > 0.0,
            coarse: false,
            shared: false,
        });
        if !flat {
            normals.push(corner_normals);
        }
    }
}
