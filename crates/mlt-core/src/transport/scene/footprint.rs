//! Memory that a scene takes.

use super::copies::Shape;
use super::{Scene, Texture};

/// Memory of a scene's parts, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Footprint {
    /// Triangles with their normals and texture coordinates, those of copies once.
    pub geometry: usize,
    /// The bounding-volume hierarchies.
    pub acceleration: usize,
    /// Images on surfaces.
    pub textures: usize,
}

impl Scene {
    /// Memory that its largest parts take.
    pub fn footprint(&self) -> Footprint {
        Footprint {
            geometry: self.triangles.bytes()
                + self.shapes.iter().map(Shape::bytes).sum::<usize>()
                + self.attributes.bytes(),
            acceleration: self.accel.bytes(),
            textures: Texture::bytes(&self.textures),
        }
    }
}
