//! The orthographic camera: parallel rays from a rectangle.
//!
//! It is a point at infinity, behind the rectangle: an edge to it runs along the viewing direction, with |cosθ| of its other end
//! for a geometric term. A film point is then a point of the rectangle, of area A, from which W_e = 1/A and the density
//! of a ray, per area across it, is 1/A as well.

use super::{CameraRay, Part};
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::cross;
use glam::{Vec2, Vec3, Vec3A};

/// Sees by parallel rays.
#[derive(Clone, Debug)]
pub(super) struct Orthographic {
    /// In the middle of the rectangle.
    pub middle: Vec3A,
    /// Unit viewing direction.
    forward: Vec3A,
    /// Half the rectangle's width and height.
    right: Vec3A,
    down: Vec3A,
    /// The same two, over their squared lengths and twice: what measures a point in images.
    across: Vec3A,
    along: Vec3A,
    /// Area of the rectangle.
    pub area: f32,
}

impl Orthographic {
    /// Around a vertex, for images of a ratio of width to height; `up`: unit vector.
    pub(super) fn new(vertex: &Vertex, up: Vec3, height: f32, aspect: [f32; 2]) -> Self {
        let half_height = 0.5 * height;
        let half_width = half_height * aspect[0] / aspect[1];
        let right = half_width * cross(vertex.geometric_normal, up.into());
        let down = Vec3A::from(-half_height * up);
        Self {
            middle: vertex.position,
            forward: vertex.geometric_normal,
            right,
            down,
            across: 0.5 * right / right.length_squared(),
            along: 0.5 * down / down.length_squared(),
            area: 4.0 * half_width * half_height,
        }
    }

    /// The same for a part of the image.
    pub(super) fn part(&self, part: Part) -> Self {
        let (offset, size) = (part.offset(), part.size);
        Self {
            middle: self.middle + offset.x * self.right + offset.y * self.down,
            forward: self.forward,
            right: self.right * size.x,
            down: self.down * size.y,
            across: self.across / size.x,
            along: self.along / size.y,
            area: self.area * size.x * size.y,
        }
    }

    /// The ray through a film point.
    #[inline]
    pub(super) fn sample(&self, film: Vec2) -> CameraRay {
        let p = 2.0 * film - Vec2::ONE;
        let start = self.middle + p.x * self.right + p.y * self.down;
        CameraRay { origin: Vertex::camera(start, self.forward).origin(self.forward), step: self.forward }
    }

    /// The film point that a point is seen at, and its depth; negative for a direction, which is seen everywhere or nowhere.
    #[inline]
    pub(super) fn project(&self, seen: &Vertex) -> (Vec2, f32) {
        if seen.is_distant() {
            return (Vec2::ZERO, -1.0);
        }
        let offset = seen.position - self.middle;
        let film = Vec2::new(offset.dot(self.across), offset.dot(self.along)) + 0.5;
        (film, offset.dot(self.forward))
    }
}
