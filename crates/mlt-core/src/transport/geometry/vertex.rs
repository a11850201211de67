//! A vertex of a path: a point on a surface or on the camera, or a light without a surface.

use glam::Vec3A;

/// `Vertex::primitive` of the camera.
pub const CAMERA: u32 = u32::MAX;

/// `Vertex::primitive` of a vertex on light number i that has no surface: `LIGHT` + i. No scene has so many triangles.
pub(crate) const LIGHT: u32 = 1 << 31;

/// Meaning of a vertex's `position`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Place {
    /// A point of a surface or of the lens.
    Surface,
    /// A point of the plane that parallel rays start from, along the normal: of an orthographic camera, which is infinitely far behind it.
    Parallel,
    /// A point without a surface: of light that comes from there alone.
    Point,
    /// No point but a direction, as a unit vector from the scene: of light that comes from that direction alone.
    Direction,
    /// The same, of light that comes from infinitely far away all around.
    Distant,
}

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
    /// Triangle, [`CAMERA`], or a light that has no surface.
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
    /// Meaning of `position`.
    pub place: Place,
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
            place: Place::Surface,
        }
    }

    /// A vertex on a distant light, in the unit direction `towards` it. It scatters as `material` does, which must be black.
    #[inline(always)]
    pub(crate) fn distant(light: u32, towards: Vec3A, material: u32) -> Self {
        Self {
            position: towards,
            geometric_normal: -towards,
            shading_normal: -towards,
            primitive: LIGHT + light,
            material,
            error: 0.0,
            delta: false,
            emits: true,
            shared: false,
            place: Place::Distant,
        }
    }

    /// A vertex at the point that a light is, with its axis. It scatters as `material` does, which must be black.
    #[inline(always)]
    pub(crate) fn free(light: u32, [position, axis]: [Vec3A; 2], material: u32) -> Self {
        let place = Place::Point;
        Self { position, geometric_normal: axis, shading_normal: axis, place, ..Self::distant(light, axis, material) }
    }

    /// Where an edge to another vertex begins: of a parallel vertex, a point of its plane.
    pub(crate) fn opposite(&self, other: &Self) -> Self {
        if !self.is_parallel() {
            return *self;
        }
        let normal = self.geometric_normal;
        Self::camera(other.position - normal * normal.dot(other.position - self.position), normal)
    }

    /// Whether this is the camera.
    #[inline]
    pub fn is_camera(&self) -> bool {
        self.primitive == CAMERA
    }

    /// Whether both are on surfaces, or on a lens of which all that holds for a surface holds.
    #[inline(always)]
    pub(crate) fn are_on_surfaces(a: &Self, b: &Self) -> bool {
        (a.place as u8 | b.place as u8) == Place::Surface as u8
    }

    /// Whether it is a direction instead of a point.
    #[inline]
    pub fn is_distant(&self) -> bool {
        matches!(self.place, Place::Direction | Place::Distant)
    }

    /// Whether a ray may meet it by chance.
    #[inline]
    pub fn can_be_met(&self) -> bool {
        !matches!(self.place, Place::Direction | Place::Point)
    }

    /// Whether rays leave it in parallel.
    #[inline]
    pub fn is_parallel(&self) -> bool {
        self.place == Place::Parallel
    }

    /// Whether this and `other` are directions, of which that of `other` alone can be the edge between them: no connection makes it.
    #[inline]
    pub(crate) fn is_met_by_one_ray(&self, other: &Self) -> bool {
        self.is_distant() & other.is_parallel()
    }

    /// Squared length of an edge from here to `other`, as densities per solid angle are divided by it; 1 where either is infinitely far
    /// away.
    #[inline(always)]
    pub(crate) fn distance_squared(&self, other: &Self) -> f32 {
        if self.is_distant() | other.is_parallel() { 1.0 } else { self.position.distance_squared(other.position) }
    }

    /// Start of a ray that leaves into `direction`: moved off the surface by the bound on the position's error, so that
    /// the ray does not meet the surface it leaves.
    #[inline]
    pub fn origin(&self, direction: Vec3A) -> Vec3A {
        self.position + self.geometric_normal * self.error.copysign(self.geometric_normal.dot(direction))
    }

    /// The ray that leaves into `direction`: its [`origin`](Self::origin) and its direction.
    #[inline(always)]
    pub(crate) fn ray(&self, direction: Vec3A) -> (Vec3A, Vec3A) {
        (self.origin(direction), direction)
    }
}
