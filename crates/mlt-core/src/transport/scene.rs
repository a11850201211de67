//! The scene as the renderer uses it.

mod veil;

use super::Rgb;
use super::accel::Accel;
use super::camera::{Camera, CameraPose};
use super::description::SceneDescription;
use super::light::{Light, LightPoint};
use super::lights::Lights;
use super::material::Material;
use super::mesh::Mesh;
use super::ray::{Hit, Ray};
use super::space::Space;
use super::vertex::{ERROR_FACTOR, Vertex};
use glam::{Vec3, Vec3A};
use std::cell::Cell;

/// What makes a scene unusable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// There is nothing to see.
    #[error("the scene has no triangle")]
    NoTriangle,
    /// There is nothing to see it by.
    #[error("the scene has no light: give a material an emission (glTF emissiveFactor, MTL Ke)")]
    NoLight,
    /// A mesh refers to a vertex or material that does not exist.
    #[error("mesh \"{mesh}\" refers to {what} {index}, which does not exist")]
    BadIndex {
        /// Name of the mesh.
        mesh: String,
        /// "vertex" or "material".
        what: &'static str,
        /// The index.
        index: usize,
    },
    /// More triangles than a 32-bit index can name.
    #[error("the scene has {0} triangles; at most {max} are supported", max = Scene::MOST_TRIANGLES)]
    TooLarge(usize),
}

/// A triangle with all that a hit needs.
#[repr(align(64))]
#[derive(Clone, Copy, Debug)]
struct Primitive {
    vertices: [Vec3; 3],
    normal: Vec3,
    material: u32,
    /// Index into `Scene::normals`; `FLAT`: the triangle's own.
    normals: u32,
    /// Bound on the error of a point interpolated from the vertices.
    error: f32,
    /// As of [`Vertex`].
    delta: bool,
    emits: bool,
}

const _: () = assert!(size_of::<Primitive>() == 64);

const FLAT: u32 = u32::MAX;

/// Triangles, materials and lights, in coordinates of the renderer's own.
pub struct Scene {
    accel: Accel,
    primitives: Vec<Primitive>,
    normals: Vec<[Vec3; 3]>,
    materials: Vec<Material>,
    lights: Lights,
    space: Space,
    dropped: usize,
    /// Whether any surface is not opaque.
    is_veiled: bool,
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

    /// Builds the acceleration structure and finds the lights.
    ///
    /// # Errors
    /// If there is no triangle or no light, or a mesh refers to what is not there.
    pub fn new(mut description: SceneDescription) -> Result<Self, SceneError> {
        check(&description)?;
        let dropped = description.meshes.iter_mut().map(drop_unusable).sum();
        let SceneDescription { mut meshes, materials, .. } = description;
        let opacity = |mesh: &Mesh| materials[mesh.material as usize].opacity;
        meshes.retain(|mesh| opacity(mesh) > 0.0);
        let is_veiled = meshes.iter().any(|mesh| opacity(mesh) < 1.0);
        let space =
            Space::around(meshes.iter().flat_map(|m| m.triangles.iter().flatten().map(|&i| m.positions[i as usize])));
        let count = meshes.iter().map(|m| m.triangles.len()).sum();
        let (mut primitives, mut normals) = (Vec::with_capacity(count), Vec::new());
        for mesh in &meshes {
            append(mesh, &materials[mesh.material as usize], &space, &mut primitives, &mut normals);
        }
        let triangles: Vec<_> = primitives.iter().map(|p: &Primitive| p.vertices).collect();
        if triangles.is_empty() {
            return Err(SceneError::NoTriangle);
        }
        let lights = Lights::new(&meshes, &materials, &triangles);
        if lights.lights.is_empty() {
            return Err(SceneError::NoLight);
        }
        drop(meshes);
        let accel = Accel::new(&triangles);
        Ok(Self { accel, primitives, normals, materials, lights, space, dropped, is_veiled })
    }

    /// A camera in this scene, for images of `size` pixels.
    pub fn camera(&self, pose: &CameraPose, size: [u32; 2]) -> Camera {
        let lights = self.lights.lights.iter().map(|light| (light.centre(), light.area));
        Camera::new(pose, self.space.point(pose.position), size).among(lights)
    }

    /// The lights.
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Whether a surface scatters into discrete directions only.
    pub fn has_specular(&self) -> bool {
        self.materials.iter().any(|m| m.bsdf.is_delta())
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

    /// The first surface along a direction, of any length, from a vertex.
    #[inline(always)]
    pub fn trace(&self, from: &Vertex, direction: Vec3A) -> Option<Vertex> {
        self.trace_ray(from.origin(direction), direction)
    }

    /// The first surface along a direction, of any length, from a point that is on no surface.
    #[inline(always)]
    pub(super) fn trace_ray(&self, origin: Vec3A, direction: Vec3A) -> Option<Vertex> {
        RAYS.set(RAYS.get() + 1);
        let hit = self.accel.closest(&Ray::new(origin.into(), direction.into()))?;
        Some(self.vertex(&hit))
    }

    /// Whether nothing stands between two vertices.
    #[inline(always)]
    pub fn visible(&self, a: &Vertex, b: &Vertex) -> bool {
        RAYS.set(RAYS.get() + 1);
        let [from, to] = Self::segment(a, b);
        !self.accel.occluded(&Ray { origin: from.into(), direction: (to - from).into(), t_max: 1.0 })
    }

    /// The ends of a ray between two vertices, off their surfaces.
    ///
    /// It starts where coordinates are finer: its end is rounded in proportion to its length, which would put it behind
    /// a small surface that is seen from a large one.
    #[inline(always)]
    fn segment(a: &Vertex, b: &Vertex) -> [Vec3A; 2] {
        let (a, b) = if a.error <= b.error { (a, b) } else { (b, a) };
        let towards_b = b.position - a.position;
        [a.origin(towards_b), b.origin(-towards_b)]
    }

    /// The light and the vertex at a point of the lights.
    #[inline(always)]
    pub(super) fn light_point(&self, point: &LightPoint) -> (&Light, Vertex) {
        let light = &self.lights.lights[point.light as usize];
        let (primitive, position) = light.at(point.u, point.v);
        (light, self.vertex_at(primitive, position.into(), None))
    }

    /// The material of a vertex on a surface.
    #[inline(always)]
    pub(super) fn material(&self, vertex: &Vertex) -> &Material {
        &self.materials[vertex.material as usize]
    }

    /// Whether a light emits from both of its sides.
    #[inline]
    pub(super) fn emits_both_sides(&self, vertex: &Vertex) -> bool {
        self.material(vertex).emits_both_sides
    }

    /// Radiance that a vertex emits into a direction.
    #[inline(always)]
    pub fn emitted(&self, vertex: &Vertex, direction: Vec3A) -> Rgb {
        let material = self.material(vertex);
        if material.emits_both_sides || vertex.geometric_normal.dot(direction) > 0.0 {
            material.emission
        } else {
            Rgb::ZERO
        }
    }

    #[inline(always)]
    fn vertex(&self, hit: &Hit) -> Vertex {
        let p = &self.primitives[hit.primitive as usize];
        let mix = |corners: [Vec3; 3]| {
            let [a, b, c] = corners.map(Vec3A::from);
            (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c
        };
        let smooth = (p.normals != FLAT).then(|| mix(self.normals[p.normals as usize]));
        self.vertex_at(hit.primitive, mix(p.vertices), smooth)
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
        }
    }
}

fn check(description: &SceneDescription) -> Result<(), SceneError> {
    let total: usize = description.meshes.iter().map(|m| m.triangles.len()).sum();
    if total > Scene::MOST_TRIANGLES {
        return Err(SceneError::TooLarge(total));
    }
    for mesh in &description.meshes {
        let bad = |what, index: u32| SceneError::BadIndex { mesh: mesh.name.clone(), what, index: index as usize };
        if mesh.material as usize >= description.materials.len() {
            return Err(bad("material", mesh.material));
        }
        if let Some(&i) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= mesh.positions.len()) {
            return Err(bad("vertex", i));
        }
    }
    Ok(())
}

/// Drops triangles with a corner that is not finite; returns how many.
fn drop_unusable(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let Mesh { positions, triangles, .. } = mesh;
    triangles.retain(|t| t.iter().all(|&i| positions[i as usize].is_finite()));
    before - triangles.len()
}

fn append(
    mesh: &Mesh,
    material: &Material,
    space: &Space,
    primitives: &mut Vec<Primitive>,
    normals: &mut Vec<[Vec3; 3]>,
) {
    let smooth = mesh.normals.len() == mesh.positions.len();
    for triangle in &mesh.triangles {
        let vertices = triangle.map(|i| space.point(mesh.positions[i as usize]));
        let [a, b, c] = vertices.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or(glam::DVec3::Z).as_vec3();
        let corner_normals = if smooth { triangle.map(|i| mesh.normals[i as usize]) } else { [normal; 3] };
        let flat = corner_normals.iter().all(|n| n.distance(normal) < 1e-6);
        let largest = vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f32::max);
        primitives.push(Primitive {
            vertices,
            normal,
            material: mesh.material,
            normals: if flat { FLAT } else { normals.len() as u32 },
            error: ERROR_FACTOR * largest,
            delta: material.bsdf.is_delta(),
            emits: material.emission.max_element() > 0.0,
        });
        if !flat {
            normals.push(corner_normals);
        }
    }
}
