//! Textures: images on surfaces, where they lie, and the parameters that read them.

mod coordinates;
mod texture;
mod textured;

use super::Scene;
use crate::transport::bsdf::Bsdf;
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::cross;
pub(super) use coordinates::{Attributes, Coordinates};
use glam::Vec3A;

pub use texture::{Encoding, Filter, Pixels, Texture, Wrap, srgb_to_linear};
pub use textured::{Alpha, ChannelMap, Map, Maps, NormalMap, Textured};

impl Scene {
    /// Texture coordinates at a vertex, from its position on its triangle.
    pub(super) fn coordinates(&self, vertex: &Vertex) -> Coordinates {
        self.placed(vertex).1
    }

    /// The same, behind barycentric weights of its triangle.
    fn placed(&self, vertex: &Vertex) -> ([f32; 2], Coordinates) {
        let held = self.held(vertex.primitive);
        let position = held.placement.map_or(vertex.position, |placement| placement.point_in_shape(vertex.position));
        let weights = held.primitive.nearest_weights(position);
        (weights, self.attributes.at(held.number, weights))
    }

    /// The shading normal that a vertex's normal map gives it, at barycentric weights of its triangle. Takes the vertex by
    /// value: a reference would keep it out of registers.
    #[inline(never)]
    pub(super) fn bent_normal(&self, vertex: Vertex, weights: [f32; 2]) -> Vec3A {
        let map = self.material(&vertex).textured.as_ref().and_then(|textured| textured.maps.normal);
        map.map_or(vertex.shading_normal, |map| self.mapped_normal(&map, &vertex, weights))
    }

    /// The BSDF of a textured surface at a vertex.
    pub(super) fn textured_bsdf(&self, textured: &Textured, vertex: &Vertex) -> Bsdf {
        let (weights, place) = self.placed(vertex);
        let tangents = textured.brushed_along().and_then(|set| {
            let ([along, across], normal) = (self.tangents(vertex, weights, set)?, vertex.shading_normal);
            let along = (along - normal * normal.dot(along)).try_normalize()?;
            let aside = cross(normal, along);
            Some([along, aside * 1f32.copysign(aside.dot(across))])
        });
        let coat_normal = textured.coat_normal().map(|map| {
            let smooth = Vertex { shading_normal: self.smooth_normal(vertex, weights), ..*vertex };
            map.map_or(smooth.shading_normal, |map| self.mapped_normal(&map, &smooth, weights))
        });
        textured.bsdf(&self.textures, &place, tangents, coat_normal)
    }

    /// The shading normal that a normal map makes of that of a vertex.
    fn mapped_normal(&self, map: &NormalMap, vertex: &Vertex, weights: [f32; 2]) -> Vec3A {
        let Some(tangents) = self.tangents(vertex, weights, usize::from(map.map.set)) else {
            return vertex.shading_normal;
        };
        let place = self.attributes.at(self.held(vertex.primitive).number, weights);
        map.normal(&self.textures, &place, tangents, [vertex.shading_normal, vertex.geometric_normal])
    }

    /// Tangent and bitangent at barycentric weights of a vertex's triangle, of any length, from a set of texture coordinates.
    fn tangents(&self, vertex: &Vertex, weights: [f32; 2], set: usize) -> Option<[Vec3A; 2]> {
        let held = self.held(vertex.primitive);
        let [a, b, c] = held.primitive.vertices.map(Vec3A::from);
        let (mut tangent, mut sign) = self.attributes.tangent(held.number, weights, set, [b - a, c - a])?;
        if let Some(placement) = held.placement {
            tangent = placement.vector(tangent);
            sign *= placement.handedness();
        }
        Some([tangent, cross(vertex.shading_normal, tangent) * sign])
    }
}
