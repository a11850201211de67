//! The scene as the renderer uses it.

mod build;
mod camera;
mod check;
mod cone;
mod copies;
mod description;
mod footprint;
pub(crate) mod light;
mod lights;
mod material;
mod medium;
mod needs;
mod primitive;
mod surface;
mod textures;
mod ties;
mod triangles;
mod veil;
mod view;
mod way;

use crate::transport::accel::Accel;
use crate::transport::geometry::{Hit, LIGHT, Ray, Space, Sphere, Vertex};
use copies::Shape;
use glam::{DVec3, Vec3A};
use std::cell::Cell;
use triangles::Triangles;
use way::Way;

pub use build::SceneGeometry;
pub use camera::{Camera, CameraPose, CameraRay, Lens};
pub use check::UnusableScene;
pub use cone::Cone;
pub use description::{Prototype, SceneDescription, SurfaceName};
pub use footprint::Footprint;
pub(crate) use light::Piece;
pub use light::{Environment, Light, LightPoint, Punctual, PunctualLight};
pub use lights::Lights;
pub use material::Material;
pub use needs::Needs;
pub use surface::{Resolved, Sampled, Surface};
use textures::Attributes;
pub use textures::{
    Alpha, ChannelMap, Encoding, Filter, Map, Maps, NormalMap, Pixels, Texture, Textured, Wrap, srgb_to_linear,
};
pub use view::View;

/// Triangles, materials and lights, in coordinates of the renderer's own.
#[derive(Debug)]
pub struct Scene {
    accel: Accel,
    triangles: Triangles,
    shapes: Vec<Shape>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    attributes: Attributes,
    lights: Lights,
    space: Space,
    /// Around all surfaces.
    sphere: Sphere,
    /// Whether the camera sees what is beyond all surfaces.
    background: bool,
    overlaps: Vec<[SurfaceName; 2]>,
    dropped: usize,
    needs: Needs,
}

thread_local! {
    static RAYS: Cell<u64> = const { Cell::new(0) };
}

/// Rays that this thread has traced since it started; differences of it are what a task has traced.
pub fn rays_traced() -> u64 {
    RAYS.get()
}

impl Scene {
    /// Most triangles in a scene, those of copies counted once.
    pub const MOST_TRIANGLES: usize = 1 << 27;

    /// Most triangles in a scene, those of copies counted as often as they are seen.
    pub const MOST_WITH_COPIES: usize = LIGHT as usize;

    /// Memory for each copy of a prototype at the peak of [`new`](Self::new), bytes, with that of the description: measured.
    pub const BYTES_PER_COPY: u64 = 600;

    /// Memory for each triangle at the peak of [`new`](Self::new), bytes, with that of the description: measured.
    pub const BYTES_PER_TRIANGLE: u64 = 420;

    /// Further memory for a triangle that emits, bytes: measured.
    pub const BYTES_PER_EMITTER: u64 = 210;

    /// Further memory for a triangle with texture coordinates and its share of their vertices, at most, bytes.
    pub const BYTES_PER_TEXTURED_TRIANGLE: u64 = 160;

    /// A camera in this scene, for images of `size` pixels.
    pub fn camera(&self, pose: &CameraPose, size: [u32; 2]) -> Camera {
        let seen = |light: &&Light| light.radius_around().is_none() && light.has_extent();
        let near = self.lights.lights.iter().filter(seen);
        let lights = near.map(|light| (light.centre(), light.measure));
        Camera::new(pose, &self.space, size).among(lights)
    }

    /// The lights.
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Features that it has.
    #[inline]
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// A sphere around all surfaces.
    #[inline]
    pub(crate) fn sphere(&self) -> &Sphere {
        &self.sphere
    }

    /// The materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Number of triangles, those of copies counted once.
    pub fn triangles(&self) -> usize {
        self.triangles.primitives.len() + self.shapes.iter().map(Shape::triangles).sum::<usize>()
    }

    /// World position of a vertex on a surface or on a lens.
    pub fn world_position(&self, vertex: &Vertex) -> DVec3 {
        self.space.world(vertex.position.into())
    }

    /// Triangles left out because a corner's position was not finite.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Pairs of surfaces that lie in one plane and overlap, a light one of them; where they do, only the first is there.
    pub fn overlaps(&self) -> &[[SurfaceName; 2]] {
        &self.overlaps
    }

    /// The first surface along a direction, of any length, from a vertex.
    #[inline(always)]
    pub fn trace(&self, from: &Vertex, direction: Vec3A) -> Option<Vertex> {
        self.trace_ray(from.origin(direction), direction)
    }

    /// The first surface along a direction, of any length, from a point that is on no surface.
    #[inline(always)]
    pub(crate) fn trace_ray(&self, origin: Vec3A, direction: Vec3A) -> Option<Vertex> {
        RAYS.set(RAYS.get() + 1);
        let ray = Ray::new(origin.into(), direction.into());
        let hit = self.accel.closest(&ray)?;
        self.vertex(&hit, &ray)
    }

    /// Whether nothing stands between two vertices.
    #[inline(always)]
    pub fn visible(&self, a: &Vertex, b: &Vertex) -> bool {
        self.is_clear(&Way::between(a, b).ray())
    }

    /// Whether nothing stands on a ray.
    #[inline(always)]
    fn is_clear(&self, ray: &Ray) -> bool {
        RAYS.set(RAYS.get() + 1);
        !self.accel.occluded(ray)
    }

    /// The material of a vertex on a surface.
    #[inline(always)]
    pub(crate) fn material(&self, vertex: &Vertex) -> &Material {
        &self.materials[vertex.material as usize]
    }

    /// The vertex of a hit; `None`: there is no such triangle.
    #[inline(always)]
    fn vertex(&self, hit: &Hit, ray: &Ray) -> Option<Vertex> {
        let Some(p) = self.triangles.primitive(hit) else {
            // Taken apart: what a call returns as a whole stays in memory.
            let vertex = self.vertex_of_copy(*hit, *ray)?;
            return Some(vertex);
        };
        let (mut vertex, weights) = self.triangles.vertex(p, &self.materials, hit, ray);
        if self.needs.normal_maps {
            vertex.shading_normal = self.bent_normal(vertex, weights);
        }
        Some(vertex)
    }

    /// Whether another surface is seen in a vertex's place from a direction.
    #[inline(always)]
    fn is_hidden(&self, vertex: &Vertex, towards: Vec3A) -> bool {
        vertex.shared
            && self.triangles.seen(&self.materials, vertex.primitive, vertex.position, towards) != vertex.primitive
    }
}
