//! Cameras: three models behind one interface.
//!
//! The measure of a lens is normalised: dA over its area, which a pinhole is the limit of. So every lens point is drawn with
//! density 1, and W_e is normalised over the image: ∫ W_e |cosθ| dω dA = 1, so ∫ f over all paths is the image's mean radiance.

mod orthographic;
mod part;
mod pinhole;
mod pose;
mod thin_lens;

use crate::engine::uniform_f32;
use crate::transport::geometry::math::unit;
use crate::transport::geometry::{Place, Space, Vertex};
use glam::{Vec2, Vec3, Vec3A};
use orthographic::Orthographic;
use part::Part;
use pinhole::Pinhole;
use rand_pcg::rand_core::Rng;
use thin_lens::ThinLens;

pub use pose::{CameraPose, Lens};

/// A camera for images of a given size, in the scene's own coordinates.
#[derive(Clone, Debug)]
pub struct Camera {
    /// In the middle of the lens.
    vertex: Vertex,
    model: Model,
    size: [u32; 2],
    /// Whether a light may be smaller than a pixel.
    tiny_lights: bool,
}

#[derive(Clone, Debug)]
enum Model {
    Pinhole(Pinhole),
    Thin(ThinLens),
    Orthographic(Orthographic),
}

/// The ray through a film point.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// Its start, off the lens.
    pub origin: Vec3A,
    /// Its direction; of a perspective camera with the length that takes it to the plane at distance 1.
    pub step: Vec3A,
}

impl CameraRay {
    /// Its direction, a unit vector.
    #[inline(always)]
    pub fn direction(&self) -> Vec3A {
        unit(self.step)
    }
}

impl Camera {
    pub(crate) fn new(pose: &CameraPose, space: &Space, size: [u32; 2]) -> Self {
        let mut vertex = Vertex::camera(space.point(pose.position).into(), pose.forward.into());
        let (up, aspect) = (pose.up, size.map(|side| side as f32));
        let pinhole = |vertical_fov: f32| Pinhole::new(&vertex, up, vertical_fov, aspect);
        let model = match pose.lens {
            Lens::Thin { vertical_fov, radius, focus } if space.length(radius) >= f32::MIN_POSITIVE => {
                let [radius, focus] = [radius, focus].map(|length| space.length(length));
                Model::Thin(ThinLens::new(pinhole(vertical_fov), &vertex, radius, focus))
            }
            Lens::Pinhole { vertical_fov } | Lens::Thin { vertical_fov, .. } => Model::Pinhole(pinhole(vertical_fov)),
            Lens::Orthographic { height } => {
                vertex.place = Place::Parallel;
                Model::Orthographic(Orthographic::new(&vertex, up, space.length(height), aspect))
            }
        };
        Self { vertex, model, size, tiny_lights: false }
    }

    /// The camera among some lights, each given by its centre and area.
    pub(crate) fn among(mut self, mut lights: impl Iterator<Item = (Vec3, f64)>) -> Self {
        self.tiny_lights = lights.any(|(centre, area)| area < self.footprint(centre));
        self
    }

    /// Area that the rays of a pixel take up, across them, around a point.
    fn footprint(&self, point: Vec3) -> f64 {
        let (vertex, pixels) = (&self.vertex, f64::from(self.pixels()));
        let square = f64::from(Vec3::from(vertex.position).distance_squared(point));
        match &self.model {
            Model::Pinhole(model) => f64::from(model.area) / pixels * square,
            Model::Thin(model) => {
                let depth = vertex.geometric_normal.dot(Vec3A::from(point) - vertex.position);
                f64::from(model.centre.area) / pixels * square + f64::from(model.blur(depth))
            }
            Model::Orthographic(model) => f64::from(model.area) / pixels,
        }
    }

    /// Whether a light may be smaller than a pixel, or than what a lens makes of a point: random camera rays hardly ever meet it.
    #[inline]
    pub fn has_tiny_lights(&self) -> bool {
        self.tiny_lights
    }

    /// Whether rays through one film point start at different points of a lens.
    #[inline]
    pub fn has_aperture(&self) -> bool {
        matches!(self.model, Model::Thin(_))
    }

    /// The vertex in the middle of the lens; the only one where there is no aperture.
    #[inline]
    pub fn vertex(&self) -> Vertex {
        self.vertex
    }

    /// Draws a vertex on the lens, with density 1; no number without an aperture.
    #[inline]
    pub fn sample_lens(&self, rng: &mut impl Rng) -> Vertex {
        match &self.model {
            Model::Thin(model) => model.vertex(Vec2::new(uniform_f32(rng), uniform_f32(rng))),
            _ => self.vertex,
        }
    }

    /// A vertex of the lens moved on it, whose radius is the unit; `None` beyond its rim.
    #[inline]
    pub(crate) fn move_on_lens(&self, lens: &Vertex, by: Vec2) -> Option<Vertex> {
        match &self.model {
            Model::Thin(model) => model.moved(lens, by),
            _ => Some(*lens),
        }
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

    /// The part of the view that `size` pixels from pixel `corner` on show: its image is those pixels alone, and as W_e is normalised
    /// over the image, ∫ f over all paths becomes the mean radiance of the part.
    #[must_use]
    pub fn part(&self, corner: [u32; 2], size: [u32; 2]) -> Self {
        let part = Part::of_pixels(corner, size, self.size);
        let model = match &self.model {
            Model::Pinhole(model) => Model::Pinhole(model.part(part)),
            Model::Thin(model) => Model::Thin(model.part(part)),
            Model::Orthographic(model) => Model::Orthographic(model.part(part)),
        };
        let position = match &model {
            Model::Orthographic(model) => model.middle,
            _ => self.vertex.position,
        };
        Self { vertex: Vertex { position, ..self.vertex }, model, size, tiny_lights: self.tiny_lights }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// The ray from a vertex on the lens through a film point, given in [0, 1)² from the top left corner.
    #[inline(always)]
    pub fn sample(&self, film: Vec2, lens: &Vertex) -> CameraRay {
        match &self.model {
            Model::Pinhole(model) => model.sample(film),
            Model::Thin(model) => model.sample(film, lens),
            Model::Orthographic(model) => model.sample(film),
        }
    }

    /// The film point at which a vertex is seen, in a direction from a vertex on the lens; `None` outside the image, and
    /// for what has no extent.
    #[inline(always)]
    pub fn project(&self, lens: &Vertex, seen: &Vertex, direction: Vec3A) -> Option<Vec2> {
        let (film, depth) = match &self.model {
            Model::Pinhole(model) => model.project(direction),
            Model::Thin(model) => model.project(lens, direction),
            Model::Orthographic(model) => model.project(seen),
        };
        let inside = depth > 0.0 && seen.can_be_met() && film.cmpge(Vec2::ZERO).all() && film.cmplt(Vec2::ONE).all();
        inside.then_some(film)
    }

    /// Index of the pixel at a film point, row by row.
    #[inline]
    pub fn pixel(&self, film: Vec2) -> u32 {
        let column = ((film.x * self.size[0] as f32) as u32).min(self.size[0] - 1);
        let row = ((film.y * self.size[1] as f32) as u32).min(self.size[1] - 1);
        row * self.size[0] + column
    }

    /// W_e from a vertex on the lens into a direction, per normalised area of the lens and sr; for parallel rays, per area across
    /// them.
    #[inline(always)]
    pub fn w_e(&self, direction: Vec3A) -> f32 {
        match &self.model {
            Model::Pinhole(model) => model.w_e(direction),
            Model::Thin(model) => model.centre.w_e(direction),
            Model::Orthographic(model) => 1.0 / model.area,
        }
    }

    /// Density of the direction from a vertex on the lens through a uniform film point, sr⁻¹; for parallel rays, of the ray, per
    /// area across it.
    #[inline(always)]
    pub fn pdf(&self, direction: Vec3A) -> f32 {
        match &self.model {
            Model::Pinhole(model) => model.pdf(direction),
            Model::Thin(model) => model.centre.pdf(direction),
            Model::Orthographic(model) => 1.0 / model.area,
        }
    }
}
