//! Copies of shapes: meshes that stand in several places are held once.
//!
//! A shape's triangles have coordinates of their own, near the origin, as the scene has. What depends on the triangles alone is found
//! there once: ties, errors, the tree. A hit becomes a vertex there, which is then mapped to the scene.

#[cfg(test)]
mod tests;

use super::Scene;
use super::description::SceneDescription;
use super::primitive::Primitive;
use super::triangles::{Triangles, mix, on_side_of};
use crate::transport::accel::{Accel, Copies};
use crate::transport::geometry::{Hit, Placement, Ray, Space, Vertex, points};
use glam::{DAffine3, Vec3A};

/// Triangles that stand in several places.
#[derive(Debug)]
pub(super) struct Shape {
    triangles: Triangles,
    /// Number of its first triangle among all that are held.
    first: u32,
}

/// A triangle as it is held in memory.
pub(super) struct Held<'a> {
    pub(super) primitive: &'a Primitive,
    /// Its number among all that are held.
    pub(super) number: u32,
    /// Where it stands; `None`: it has the scene's coordinates.
    pub(super) placement: Option<&'a Placement>,
}

impl Shape {
    /// The shapes of a description's prototypes, and their copies. `first`: the number of triangles in world space.
    pub(super) fn all(description: &SceneDescription, space: &Space, mut first: u32) -> (Vec<Self>, Copies) {
        let (mut shapes, mut copies) = (Vec::new(), Copies::default());
        for (number, prototype) in (0..).zip(&description.prototypes) {
            let own_space = Space::around(points(&prototype.meshes));
            let triangles = Triangles::new(&prototype.meshes, &description.materials, &own_space);
            let placement = |place: &DAffine3| Placement::new(space.map() * *place * own_space.to_world());
            copies.places.extend(prototype.places.iter().filter_map(placement).map(|placement| (number, placement)));
            copies.shapes.push(Accel::new(&triangles.corners()));
            let count = triangles.primitives.len() as u32;
            shapes.push(Self { triangles, first });
            first += count;
        }
        (shapes, copies)
    }

    /// Memory that its triangles take, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.triangles.bytes()
    }

    /// Number of triangles.
    pub(super) fn triangles(&self) -> usize {
        self.triangles.primitives.len()
    }
}

impl Scene {
    /// The triangle of a number, which is no light's.
    #[inline]
    pub(super) fn held(&self, primitive: u32) -> Held<'_> {
        match self.accel.instance(primitive) {
            None => {
                Held { primitive: &self.triangles.primitives[primitive as usize], number: primitive, placement: None }
            }
            Some(instance) => {
                let shape = &self.shapes[instance.shape];
                let primitive = &shape.triangles.primitives[instance.triangle as usize];
                Held { primitive, number: shape.first + instance.triangle, placement: Some(instance.placement) }
            }
        }
    }

    /// The interpolated normal of a vertex at barycentric weights of its triangle, which no map has bent.
    pub(super) fn smooth_normal(&self, vertex: &Vertex, weights: [f32; 2]) -> Vec3A {
        let corners = match self.accel.instance(vertex.primitive) {
            None => self.triangles.normals(vertex.primitive).map(|normals| normals.map(Vec3A::from)),
            Some(instance) => {
                let normals = self.shapes[instance.shape].triangles.normals(instance.triangle);
                normals.map(|normals| normals.map(|normal| instance.placement.normal(normal.into())))
            }
        };
        corners.map_or(vertex.geometric_normal, |corners| on_side_of(vertex.geometric_normal, mix(corners, weights)))
    }

    /// The vertex of a hit on a copy; `None`: there is no such triangle. Takes both by value: a reference would keep them out of registers.
    #[inline(never)]
    pub(super) fn vertex_of_copy(&self, hit: Hit, ray: Ray) -> Option<Vertex> {
        let instance = self.accel.instance(hit.primitive)?;
        let (first, placement) = (hit.primitive - instance.triangle, instance.placement);
        let in_shape = Hit { primitive: instance.triangle, ..hit };
        let triangles = &self.shapes[instance.shape].triangles;
        let p = triangles.primitive(&in_shape)?;
        let (vertex, weights) = triangles.vertex(p, &self.materials, &in_shape, &placement.ray(&ray));
        // No copy emits, and only of lights is it asked later what else is in their place.
        let mut vertex = Vertex { primitive: first + vertex.primitive, shared: false, ..placement.vertex(vertex) };
        vertex.shading_normal = self.smooth_normal(&vertex, weights);
        if self.needs.normal_maps {
            vertex.shading_normal = self.bent_normal(vertex, weights);
        }
        Some(vertex)
    }
}
