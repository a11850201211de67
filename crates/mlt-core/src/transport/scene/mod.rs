//! The scene as the renderer uses it.

mod camera;
mod check;
mod description;
pub(crate) mod light;
mod lights;
mod material;
mod medium;
mod needs;
mod primitive;
mod surface;
mod textures;
mod ties;
mod veil;
mod view;
mod way;

use crate::transport::accel::{Accel, coarse_size};
use crate::transport::geometry::{ERROR_FACTOR, Hit, Place, Ray, Space, Sphere, Vertex};
use check::{check, drop_invisible, drop_unusable};
use glam::{Vec3, Vec3A};
use primitive::{FLAT, Primitive, primitives};
use std::cell::Cell;
use ties::{Surfaces, Ties};
use way::Way;

pub use camera::{Camera, CameraPose, CameraRay, Lens};
pub use check::UnusableScene;
pub use description::{SceneDescription, SurfaceName};
pub(crate) use light::Piece;
pub use light::{Cone, Environment, Light, LightPoint, Punctual, PunctualLight};
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
    primitives: Vec<Primitive>,
    normals: Vec<[Vec3; 3]>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    attributes: Attributes,
    lights: Lights,
    space: Space,
    /// Around all surfaces.
    sphere: Sphere,
    /// Whether the camera sees what is beyond all surfaces.
    background: bool,
    ties: Ties,
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
    /// Most triangles in a scene.
    pub const MOST_TRIANGLES: usize = 1 << 27;

    /// Memory for each triangle at the peak of [`new`](Self::new), bytes, with that of the description: measured.
    pub const BYTES_PER_TRIANGLE: u64 = 420;

    /// Further memory for a triangle that emits, bytes: measured.
    pub const BYTES_PER_EMITTER: u64 = 210;

    /// Further memory for a triangle with texture coordinates and its share of their vertices, at most, bytes.
    pub const BYTES_PER_TEXTURED_TRIANGLE: u64 = 160;

    /// Builds the acceleration structure and finds the lights.
    ///
    /// # Errors
    /// If there is no triangle or no light, or a mesh refers to what is not there.
    pub fn new(mut description: SceneDescription) -> Result<Self, UnusableScene> {
        check(&description)?;
        let dropped = description.meshes.iter_mut().map(drop_unusable).sum();
        drop_invisible(&mut description);
        let needs = Needs::of(&description);
        let SceneDescription { meshes, materials, .. } = &description;
        let space =
            Space::around(meshes.iter().flat_map(|m| m.triangles.iter().flatten().map(|&i| m.positions[i as usize])));
        let (mut primitives, normals) = primitives(&description, &space);
        let triangles: Vec<_> = primitives.iter().map(|p: &Primitive| p.vertices).collect();
        if triangles.is_empty() {
            return Err(UnusableScene::NoTriangle);
        }
        let mut lights = Lights::new(meshes, materials, &description.textures, &triangles);
        let without_surface = needs.environment || needs.punctual || needs.suns;
        if lights.lights.is_empty() && !without_surface {
            return Err(UnusableScene::NoLight);
        }
        let coarse_size = coarse_size(&triangles);
        primitives.iter_mut().for_each(|p| p.set_error(coarse_size));
        let mesh_of: Vec<_> = (0..).zip(meshes).flat_map(|(i, m)| std::iter::repeat_n(i, m.triangles.len())).collect();
        let ties = Ties::resolve(&mut primitives, materials, &mesh_of);
        let overlaps = ties.overlaps().map(|pair| pair.map(|mesh| description.surface_name(mesh))).collect();
        let attributes = match needs.textured {
            true => Attributes::take(&mut description.meshes, mesh_of),
            false => Attributes::default(),
        };
        description.meshes = Vec::new();
        let sphere = Sphere::around(triangles.iter().flatten().copied());
        let SceneDescription { mut materials, textures, environment, punctual, .. } = description;
        materials.iter_mut().for_each(|material| material.absorption /= space.length(1.0));
        let environment = environment.filter(|_| needs.environment);
        let background = environment.as_ref().is_none_or(|environment| environment.visible);
        lights = lights.and_punctual(&punctual, &space, sphere);
        if let Some(environment) = environment {
            lights = lights.surrounded(environment, sphere);
        }
        if without_surface {
            materials.push(Material::default());
        }
        let accel = Accel::new(&triangles);
        Ok(Self {
            accel,
            primitives,
            normals,
            materials,
            textures,
            attributes,
            lights,
            space,
            sphere,
            background,
            ties,
            overlaps,
            dropped,
            needs,
        })
    }

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

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.primitives.len()
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
        Some(self.vertex(&hit, &ray))
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

    #[inline(always)]
    fn vertex(&self, hit: &Hit, ray: &Ray) -> Vertex {
        let p = &self.primitives[hit.primitive as usize];
        if p.coarse | p.shared
            && let Some(apart) = self.vertex_apart(*hit, *ray)
        {
            return apart;
        }
        self.interpolated(hit)
    }

    /// The vertex of a hit on a triangle that is coarse or shares its place; `None`: that of any other hit. By value: what a call
    /// refers to has to lie in memory even where it is not made.
    #[cold]
    fn vertex_apart(&self, hit: Hit, ray: Ray) -> Option<Vertex> {
        let position = Vec3A::from(ray.at(ray.plane_parameter(self.primitives[hit.primitive as usize].vertices)));
        let primitive = self.seen(hit.primitive, position, Vec3A::from(-ray.direction));
        let p = &self.primitives[primitive as usize];
        if primitive == hit.primitive && !p.coarse {
            return None;
        }
        let [u, v] =
            if primitive == hit.primitive { Some([hit.u, hit.v]) } else { p.weights(position) }.unwrap_or_default();
        let vertex = self.interpolated(&Hit { primitive, u, v, ..hit });
        if !p.coarse {
            return Some(vertex);
        }
        let error = vertex.error.max(ERROR_FACTOR * position.abs().max_element());
        Some(Vertex { position: ray.at(ray.plane_parameter(p.vertices)).into(), error, ..vertex })
    }

    /// Whether another surface is seen in a vertex's place from a direction.
    #[inline(always)]
    fn is_hidden(&self, vertex: &Vertex, towards: Vec3A) -> bool {
        vertex.shared && self.seen(vertex.primitive, vertex.position, towards) != vertex.primitive
    }

    /// Which of the triangles at a point of one is seen from a direction.
    #[cold]
    fn seen(&self, primitive: u32, position: Vec3A, towards: Vec3A) -> u32 {
        let surfaces = Surfaces { primitives: &self.primitives, materials: &self.materials };
        self.ties.winner(surfaces, primitive, position, towards)
    }

    #[inline(always)]
    fn interpolated(&self, hit: &Hit) -> Vertex {
        let p = &self.primitives[hit.primitive as usize];
        let mix = |corners: [Vec3; 3]| {
            let [a, b, c] = corners.map(Vec3A::from);
            (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c
        };
        let smooth = (p.normals != FLAT).then(|| mix(self.normals[p.normals as usize]));
        let mut vertex = self.vertex_at(hit.primitive, mix(p.vertices), smooth);
        if self.needs.normal_maps {
            vertex.shading_normal = self.bent_normal(vertex, [hit.u, hit.v]);
        }
        vertex
    }

    /// The interpolated normal at barycentric weights of a triangle, which no map has bent.
    fn smooth_normal(&self, primitive: u32, [u, v]: [f32; 2]) -> Vec3A {
        let p = &self.primitives[primitive as usize];
        let smooth = (p.normals != FLAT).then(|| {
            let [a, b, c] = self.normals[p.normals as usize].map(Vec3A::from);
            (1.0 - u - v) * a + u * b + v * c
        });
        self.vertex_at(primitive, Vec3A::ZERO, smooth).shading_normal
    }

    #[inline(always)]
    fn vertex_at(&self, primitive: u32, position: Vec3A, smooth_normal: Option<Vec3A>) -> Vertex {
        let p = &self.primitives[primitive as usize];
        let normal = Vec3A::from(p.normal);
        let shading_normal = match smooth_normal {
            None => normal,
            Some(n) => n.normalize_or(normal) * 1f32.copysign(n.dot(normal)),
        };
        Vertex {
            position,
            geometric_normal: normal,
            shading_normal,
            primitive,
            material: p.material,
            error: p.error,
            delta: p.delta,
            emits: p.emits,
            shared: p.shared,
            place: Place::Surface,
        }
    }
}
