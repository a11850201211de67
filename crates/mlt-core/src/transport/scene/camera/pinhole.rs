//! The pinhole camera.

use crate::transport::geometry::Vertex;
use glam::{DVec3, Vec2, Vec3, Vec3A};

/// Where the camera stands and what it takes in; the image's aspect ratio comes with its size.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPose {
    /// Name in the scene file.
    pub name: String,
    /// World position.
    pub position: DVec3,
    /// Unit vector into the scene.
    pub forward: Vec3,
    /// Unit vector up in the image, at a right angle to `forward`.
    pub up: Vec3,
    /// Full vertical opening angle, radians.
    pub vertical_fov: f32,
    /// Width over height that the scene's author meant, if given.
    pub aspect_ratio: Option<f32>,
}

/// A pinhole camera for images of a given size, in the scene's own coordinates.
///
/// Its importance is normalised over the image: ∫ W_e |cosθ| dω = 1, so ∫ f over all paths is the image's mean radiance.
#[derive(Clone, Debug)]
pub struct Camera {
    vertex: Vertex,
    /// Where rays into the image start.
    origin: Vec3A,
    /// Half the image's width and height on the plane at distance 1, along the image's axes.
    right: Vec3A,
    down: Vec3A,
    /// The same two, over their squared lengths and twice: what measures a point of that plane in images.
    across: Vec3A,
    along: Vec3A,
    size: [u32; 2],
    /// Area of the image on the plane at distance 1.
    area: f32,
    /// Whether a light may be smaller than a pixel.
    tiny_lights: bool,
}

/// The ray through a film point.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// Where it leaves the lens.
    pub vertex: Vertex,
    /// Its start: the [`origin`](Vertex::origin) of that vertex.
    pub origin: Vec3A,
    /// Its direction, with the length that takes it to the plane at distance 1.
    pub step: Vec3A,
}

impl CameraRay {
    /// Its direction, a unit vector.
    #[inline(always)]
    pub fn direction(&self) -> Vec3A {
        self.step.normalize()
    }
}

impl Camera {
    pub(crate) fn new(pose: &CameraPose, position: Vec3, size: [u32; 2]) -> Self {
        let half_height = libm::tanf(0.5 * pose.vertical_fov);
        let half_width = half_height * size[0] as f32 / size[1] as f32;
        let right = Vec3A::from(half_width * pose.forward.cross(pose.up));
        let down = Vec3A::from(-half_height * pose.up);
        let vertex = Vertex::camera(position.into(), pose.forward.into());
        Self {
            vertex,
            origin: vertex.origin(pose.forward.into()),
            right,
            down,
            across: 0.5 * right / right.length_squared(),
            along: 0.5 * down / down.length_squared(),
            size,
            area: 4.0 * half_width * half_height,
            tiny_lights: false,
        }
    }

    /// The camera among some lights, each given by its centre and area.
    pub(crate) fn among(mut self, mut lights: impl Iterator<Item = (Vec3, f64)>) -> Self {
        let pixel = f64::from(self.area) / f64::from(self.pixels());
        let position = Vec3::from(self.vertex.position);
        self.tiny_lights = lights.any(|(centre, area)| area < pixel * f64::from(position.distance_squared(centre)));
        self
    }

    /// Whether a light may be smaller than a pixel: random camera rays hardly ever meet it.
    #[inline]
    pub fn has_tiny_lights(&self) -> bool {
        self.tiny_lights
    }

    /// The vertex at the pinhole.
    pub fn vertex(&self) -> Vertex {
        self.vertex
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The same view in other pixels.
    #[must_use]
    pub fn with_size(&self, size: [u32; 2]) -> Self {
        Self { size, ..self.clone() }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// The ray through a film point, given in [0, 1)² from the top left corner.
    #[inline(always)]
    pub fn sample(&self, film: Vec2) -> CameraRay {
        let p = 2.0 * film - Vec2::ONE;
        let step = self.vertex.geometric_normal + p.x * self.right + p.y * self.down;
        CameraRay { vertex: self.vertex, origin: self.origin, step }
    }

    /// The film point that a direction from a vertex on the lens passes through; `None` outside the image.
    #[inline(always)]
    pub fn project(&self, lens: &Vertex, direction: Vec3A) -> Option<Vec2> {
        let cos = lens.geometric_normal.dot(direction);
        let film = Vec2::new(direction.dot(self.across), direction.dot(self.along)) / cos + 0.5;
        let inside = cos > 0.0 && film.cmpge(Vec2::ZERO).all() && film.cmplt(Vec2::ONE).all();
        inside.then_some(film)
    }

    /// Index of the pixel at a film point, row by row.
    #[inline]
    pub fn pixel(&self, film: Vec2) -> u32 {
        let column = ((film.x * self.size[0] as f32) as u32).min(self.size[0] - 1);
        let row = ((film.y * self.size[1] as f32) as u32).min(self.size[1] - 1);
        row * self.size[0] + column
    }

    /// W_e from a vertex on the lens into a direction, per area of the pinhole and sr: 1/(A cos⁴θ), A the image's area at
    /// distance 1.
    ///
    /// Source: [PharrJakobHumphreys16], section 16.1.1.
    #[inline(always)]
    pub fn w_e(&self, lens: &Vertex, direction: Vec3A) -> f32 {
        let cos = lens.geometric_normal.dot(direction);
        1.0 / (self.area * cos * cos * cos * cos)
    }

    /// Density per unit solid angle of the direction from a vertex on the lens through a uniform film point, sr⁻¹: 1/(A cos³θ).
    #[inline(always)]
    pub fn pdf(&self, lens: &Vertex, direction: Vec3A) -> f32 {
        let cos = lens.geometric_normal.dot(direction);
        1.0 / (self.area * cos * cos * cos)
    }
}
