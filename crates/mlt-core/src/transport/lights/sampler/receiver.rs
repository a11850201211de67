//! Who asks for light.

use crate::transport::geometry::Vertex;
use crate::transport::scene::Scene;
use glam::Vec3A;

/// A vertex that light is to come to.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'a> {
    /// The scene that it is in.
    pub scene: &'a Scene,
    /// Where it is; by value, as a reference would keep it out of registers.
    pub vertex: Vertex,
    /// A direction on the side of it that is to be lit: to the next vertex of the path towards the camera, or to the light. A surface that
    /// no light passes has both on one side.
    pub towards: Vec3A,
}

impl<'a> Receiver<'a> {
    /// x_1, for which x_0 might have been drawn.
    #[inline(always)]
    pub(crate) fn of_light(scene: &'a Scene, x_0: &Vertex, x_1: &Vertex) -> Self {
        let towards = if x_0.is_distant() { x_0.position } else { x_0.position - x_1.position };
        Self { scene, vertex: *x_1, towards }
    }

    /// The shading normal on the side that is lit, and whether the other side is lit as well.
    #[inline]
    pub(super) fn lit_side(&self) -> (Vec3A, bool) {
        let Self { scene, vertex, towards } = self;
        let both = vertex.is_camera() || scene.material(vertex).transmits();
        let normal = vertex.shading_normal;
        (if normal.dot(*towards) < 0.0 { -normal } else { normal }, both)
    }
}
