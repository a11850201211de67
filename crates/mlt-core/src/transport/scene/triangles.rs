//! Triangles and their vertices.

use super::material::Material;
use super::primitive::{FLAT, Primitive, primitives};
use super::ties::{Surfaces, Ties};
use crate::transport::accel::coarse_size;
use crate::transport::geometry::{ERROR_FACTOR, Hit, Mesh, Ray, Space, Vertex};
use glam::{Vec3, Vec3A};

/// Triangles with all that a hit needs, in the scene's coordinates or in those of a shape.
#[derive(Debug)]
pub(super) struct Triangles {
    pub(super) primitives: Vec<Primitive>,
    normals: Vec<[Vec3; 3]>,
    ties: Ties,
}

impl Triangles {
    /// Memory that they take, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.primitives[..]) + size_of_val(&self.normals[..])
    }

    /// Those of all meshes, one mesh after the other.
    pub(super) fn new(meshes: &[Mesh], materials: &[Material], space: &Space) -> Self {
        let (mut primitives, normals) = primitives(meshes, materials, space);
        let corners = primitives.iter().map(|p| &p.vertices);
        let coarse_size = coarse_size(corners);
        primitives.iter_mut().for_each(|p| p.set_error(coarse_size));
        let mesh_of: Vec<_> = (0..).zip(meshes).flat_map(|(i, m)| std::iter::repeat_n(i, m.triangles.len())).collect();
        let ties = Ties::resolve(&mut primitives, materials, &mesh_of);
        Self { primitives, normals, ties }
    }

    /// Their corners.
    pub(super) fn corners(&self) -> Vec<[Vec3; 3]> {
        self.primitives.iter().map(|p| p.vertices).collect()
    }

    /// Pairs of meshes, by number, that lie in one plane and overlap, a light one of them.
    pub(super) fn overlaps(&self) -> impl Iterator<Item = [u32; 2]> {
        self.ties.overlaps()
    }

    /// The triangle of a hit; `None`: it is none of these.
    #[inline(always)]
    pub(super) fn primitive(&self, hit: &Hit) -> Option<&Primitive> {
        self.primitives.get(hit.primitive as usize)
    }

    /// The vertex of a hit on a triangle, and the barycentric weights of the second and third corner there of the triangle that it is
    /// on.
    #[inline(always)]
    pub(super) fn vertex(&self, p: &Primitive, materials: &[Material], hit: &Hit, ray: &Ray) -> (Vertex, [f32; 2]) {
        if p.coarse | p.shared
            && let Some(apart) = self.vertex_apart(materials, *hit, *ray)
        {
            return apart;
        }
        (self.interpolated(p, hit), [hit.u, hit.v])
    }

    /// The vertex of a hit on a triangle that is coarse or shares its place; `None`: that of any other hit. By value: what a call
    /// refers to has to lie in memory even where it is not made.
    #[cold]
    fn vertex_apart(&self, materials: &[Material], hit: Hit, ray: Ray) -> Option<(Vertex, [f32; 2])> {
        let position = Vec3A::from(ray.at(ray.plane_parameter(self.primitives[hit.primitive as usize].vertices)));
        let primitive = self.seen(materials, hit.primitive, position, Vec3A::from(-ray.direction));
        let p = &self.primitives[primitive as usize];
        if primitive == hit.primitive && !p.coarse {
            return None;
        }
        let [u, v] =
            if primitive == hit.primitive { Some([hit.u, hit.v]) } else { p.weights(position) }.unwrap_or_default();
        let vertex = self.interpolated(p, &Hit { primitive, u, v, ..hit });
        if !p.coarse {
            return Some((vertex, [u, v]));
        }
        let error = vertex.error.max(ERROR_FACTOR * position.abs().max_element());
        Some((Vertex { position: ray.at(ray.plane_parameter(p.vertices)).into(), error, ..vertex }, [u, v]))
    }

    /// Which of the triangles at a point of one is seen from a direction.
    #[cold]
    pub(super) fn seen(&self, materials: &[Material], primitive: u32, position: Vec3A, towards: Vec3A) -> u32 {
        let surfaces = Surfaces { primitives: &self.primitives, materials };
        self.ties.winner(surfaces, primitive, position, towards)
    }

    /// The vertex at a hit on a triangle.
    #[inline(always)]
    fn interpolated(&self, p: &Primitive, hit: &Hit) -> Vertex {
        let weights = [hit.u, hit.v];
        let mut vertex = p.vertex(hit.primitive, mix(p.vertices.map(Vec3A::from), weights));
        if p.normals != FLAT {
            let smooth = mix(self.normals[p.normals as usize].map(Vec3A::from), weights);
            vertex.shading_normal = on_side_of(vertex.geometric_normal, smooth);
        }
        vertex
    }

    /// Normals at the corners of a triangle; `None`: its own.
    pub(super) fn normals(&self, primitive: u32) -> Option<[Vec3; 3]> {
        self.normals.get(self.primitives[primitive as usize].normals as usize).copied()
    }
}

/// The point between three with these weights of the second and third.
#[inline(always)]
pub(super) fn mix([a, b, c]: [Vec3A; 3], [u, v]: [f32; 2]) -> Vec3A {
    (1.0 - u - v) * a + u * b + v * c
}

/// The unit vector along `smooth`, of any length, or against it, that is on the side of a normal.
#[inline(always)]
pub(super) fn on_side_of(normal: Vec3A, smooth: Vec3A) -> Vec3A {
    smooth.normalize_or(normal) * 1f32.copysign(smooth.dot(normal))
}
