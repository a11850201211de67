//! A point on a surface, or on the camera.

use glam::Vec3A;

/// `Vertex::primitive` of the camera.
pub const CAMERA: u32 = u32::MAX;

/// Bound on the error of a position and of the intersection test near it, relative to the largest coordinate of the triangle
/// that it is interpolated on, or of the position itself where it is found in f64: 16 units in the last place of f32.
pub(crate) const ERROR_FACTOR: f32 = 16.0 * f32::EPSILON;

/// A path's vertex: where it is and how the surface lies there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Scene units.
    pub position: Vec3A,
    /// Unit normal of the triangle, on its front; of the camera: its viewing direction.
    pub geometric_normal: Vec3A,
    /// Unit interpolated normal, on the side of `geometric_normal`.
    pub shading_normal: Vec3A,
    /// Triangle, or [`CAMERA`].
    pub primitive: u32,
    /// Index into the scene's materials; 0 for the camera.
    pub material: u32,
    /// Bound on the error of `position`, scene units.
    pub error: f32,
    /// Whether it scatters into discrete directions only, so that nothing can be connected to it.
    pub delta: bool,
    /// Whether it lies on a light.
    pub emits: bool,
    /// Whether another surface may be seen in its place: see `scene::ties`.
    pub(crate) shared: bool,
}

impl Vertex {
    /// The camera at `position`, looking along `forward`. It may lie on a surface that it looks away from.
    pub fn camera(position: Vec3A, forward: Vec3A) -> Self {
        Self {
            position,
            geometric_normal: forward,
            shading_normal: forward,
            primitive: CAMERA,
            material: 0,
            error: ERROR_FACTOR * position.abs().max_element(),
            delta: false,
            emits: false,
            shared: false,
        }
    }

    /// Whether this is the camera.
    #[inline]
    pub fn is_camera(&self) -> bool {
        self.primitive == CAMERA
    }

    /// Start of a ray that leaves into `direction`: moved off the surface by the bound on the position's error, so that
    /// the ray does not meet the surface it leaves.
    #[inline]
    pub fn origin(&self, direction: Vec3A) -> Vec3A {
        self.position + self.geometric_normal * self.error.copysign(self.geometric_normal.dot(direction))
    }
}
