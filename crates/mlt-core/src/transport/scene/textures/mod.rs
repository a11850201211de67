//! Textures: images on surfaces, where they lie, and the parameters that read them.

mod coordinates;
mod texture;
mod textured;

use super::Scene;
use crate::transport::geometry::Vertex;
pub(super) use coordinates::{Attributes, Coordinates};
use glam::Vec3A;

pub use texture::{Encoding, Filter, Pixels, Texture, Wrap, srgb_to_linear};
pub use textured::{Alpha, ChannelMap, Map, Maps, NormalMap, Textured};

impl Scene {
    /// Texture coordinates at a vertex, from its position on its triangle.
    pub(super) fn coordinates(&self, vertex: &Vertex) -> Coordinates {
        let held = self.held(vertex.primitive);
        let position = held.placement.map_or(vertex.position, |placement| placement.point_in_shape(vertex.position));
        self.attributes.at(held.number, held.primitive.nearest_weights(position))
    }

    /// The shading normal that a vertex's normal map gives it, at barycentric weights of its triangle. Takes the vertex by
    /// value: a reference would keep it out of registers.
    #[inline(never)]
    pub(super) fn bent_normal(&self, vertex: Vertex, weights: [f32; 2]) -> Vec3A {
        let Some(map) = self.material(&vertex).textured.as_ref().and_then(|textured| textured.maps.normal) else {
            return vertex.shading_normal;
        };
        let held = self.held(vertex.primitive);
        let [a, b, c] = held.primitive.vertices.map(Vec3A::from);
        let set = usize::from(map.map.set);
        let Some((mut tangent, mut sign)) = self.attributes.tangent(held.number, weights, set, [b - a, c - a]) else {
            return vertex.shading_normal;
        };
        if let Some(placement) = held.placement {
            tangent = placement.vector(tangent);
            sign *= placement.handedness();
        }
        let tangents = [tangent, vertex.shading_normal.cross(tangent) * sign];
        let place = self.attributes.at(held.number, weights);
        map.normal(&self.textures, &place, tangents, [vertex.shading_normal, vertex.geometric_normal])
    }
}
