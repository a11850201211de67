//! The pinhole camera.

use super::{CameraRay, Part};
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::cross;
use glam::{Vec2, Vec3, Vec3A};

/// Sees through a point, onto a plane at distance 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pinhole {
    /// Unit viewing direction.
    forward: Vec3A,
    /// Where rays into the image start.
    origin: Vec3A,
    /// The middle of the image on the plane, from the point.
    middle: Vec3A,
    /// The film point in the viewing direction.
    axis: Vec2,
    /// Half the image's width and height on the plane, along the image's axes.
    right: Vec3A,
    down: Vec3A,
    /// The same two, over their squared lengths and twice: what measures a point of that plane in images.
    pub across: Vec3A,
    pub along: Vec3A,
    /// Area of the image on the plane.
    pub area: f32,
}

impl Pinhole {
    /// At a vertex, for images of a ratio of width to height; `up`: unit vector.
    pub(super) fn new(vertex: &Vertex, up: Vec3, vertical_fov: f32, aspect: [f32; 2]) -> Self {
        let forward = vertex.geometric_normal;
        let half_height = libm::tanf(0.5 * vertical_fov);
        let half_width = half_height * aspect[0] / aspect[1];
        let right = half_width * cross(forward, up.into());
        let down = Vec3A::from(-half_height * up);
        Self {
            forward,
            origin: vertex.origin(forward),
            middle: forward,
            axis: Vec2::splat(0.5),
            right,
            down,
            across: 0.5 * right / right.length_squared(),
            along: 0.5 * down / down.length_squared(),
            area: 4.0 * half_width * half_height,
        }
    }

    /// The same for a part of the image.
    pub(super) fn part(&self, part: Part) -> Self {
        let (offset, Part { low, size }) = (part.offset(), part);
        Self {
            middle: self.middle + offset.x * self.right + offset.y * self.down,
            axis: (self.axis - low) / size,
            right: self.right * size.x,
            down: self.down * size.y,
            across: self.across / size.x,
            along: self.along / size.y,
            area: self.area * size.x * size.y,
            ..*self
        }
    }

    /// The ray through a film point.
    #[inline(always)]
    pub(super) fn sample(&self, film: Vec2) -> CameraRay {
        let p = 2.0 * film - Vec2::ONE;
        CameraRay { origin: self.origin, step: self.middle + p.x * self.right + p.y * self.down }
    }

    /// The film point that a direction passes through, and the cosine of its angle with the viewing direction.
    #[inline(always)]
    pub(super) fn project(&self, direction: Vec3A) -> (Vec2, f32) {
        let cos = self.forward.dot(direction);
        (Vec2::new(direction.dot(self.across), direction.dot(self.along)) / cos + self.axis, cos)
    }

    /// W_e = 1/(A cos⁴θ) per sr.
    ///
    /// Source: [PharrJakobHumphreys16], section 16.1.1.
    #[inline(always)]
    pub(super) fn w_e(&self, direction: Vec3A) -> f32 {
        let cos = self.forward.dot(direction);
        1.0 / (self.area * cos * cos * cos * cos)
    }

    /// 1/(A cos³θ), sr⁻¹.
    #[inline(always)]
    pub(super) fn pdf(&self, direction: Vec3A) -> f32 {
        let cos = self.forward.dot(direction);
        1.0 / (self.area * cos * cos * cos)
    }
}
