//! Textures: images on surfaces, where they lie, and the parameters that read them.

mod coordinates;
mod texture;
mod textured;

use super::Scene;
use crate::transport::geometry::Vertex;
pub(super) use coordinates::{Attributes, Coordinates, TriangleFrame};
use glam::Vec3A;

pub use texture::{Encoding, Filter, Pixels, Texture, Wrap, srgb_to_linear};
pub use textured::{Alpha, ChannelMap, Map, Maps, NormalMap, Textured};

impl Scene {
    /// Texture coordinates at a vertex, from its position on its triangle.
    pub(super) fn coordinates(&self, vertex: &Vertex) -> Coordinates {
        let weights = self.primitives[vertex.primitive as usize].nearest_weights(vertex.position);
        self.attributes.at(vertex.primitive, weights)
    }

    /// The shading normal that a vertex's normal map gives it, at barycentric weights of its triangle. Takes the vertex by
    /// value: a reference would keep it out of registers.
    #[inline(never)]
    pub(super) fn bent_normal(&self, vertex: Vertex, weights: [f32; 2]) -> Vec3A {
        let Some(map) = self.material(&vertex).textured.as_ref().and_then(|textured| textured.maps.normal) else {
            return vertex.shading_normal;
        };
        let [a, b, c] = self.primitives[vertex.primitive as usize].vertices.map(Vec3A::from);
        let frame = TriangleFrame { edges: [b - a, c - a], normal: vertex.shading_normal };
        let set = usize::from(map.map.set);
        let Some(tangents) = self.attributes.tangents(vertex.primitive, weights, set, frame) else {
            return vertex.shading_normal;
        };
        let place = self.attributes.at(vertex.primitive, weights);
        map.normal(&self.textures, &place, tangents, [vertex.shading_normal, vertex.geometric_normal])
    }
}
