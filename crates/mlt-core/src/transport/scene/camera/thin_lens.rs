//! The thin lens: a disc whose rays through one film point meet in a point of the plane in focus.
//!
//! For each point of the disc the rays are those of a pinhole there, but for a shift of the film by the point's offset from the
//! centre over the distance in focus; so W_e and densities are the pinhole's, per normalised area of the disc.
//!
//! Source: [Cook84].

use super::pinhole::Pinhole;
use super::{CameraRay, Part};
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::{square_to_disk, unit};
use glam::{Vec2, Vec3A};
use std::f32::consts::PI;

/// Sees through a disc.
#[derive(Clone, Debug)]
pub(super) struct ThinLens {
    /// The rays through its centre.
    pub centre: Pinhole,
    /// The centre.
    position: Vec3A,
    /// Unit viewing direction.
    forward: Vec3A,
    /// Unit vectors along the image's axes.
    axes: [Vec3A; 2],
    /// Radius of the disc.
    radius: f32,
    /// Distance of the plane in focus.
    focus: f32,
}

impl ThinLens {
    /// A disc about a pinhole at a vertex.
    pub(super) fn new(centre: Pinhole, vertex: &Vertex, radius: f32, focus: f32) -> Self {
        let axes = [centre.across, centre.along].map(unit);
        let (position, forward) = (vertex.position, vertex.geometric_normal);
        Self { centre, position, forward, axes, radius, focus }
    }

    /// The same for a part of the image.
    pub(super) fn part(&self, part: Part) -> Self {
        Self { centre: self.centre.part(part), ..self.clone() }
    }

    /// The vertex at a uniform point of the disc.
    #[inline]
    pub(super) fn vertex(&self, u: Vec2) -> Vertex {
        self.at(square_to_disk(u).0)
    }

    /// The vertex at a point of the disc, whose radius is the unit.
    #[inline]
    fn at(&self, p: Vec2) -> Vertex {
        let offset = self.radius * (p.x * self.axes[0] + p.y * self.axes[1]);
        Vertex::camera(self.position + offset, self.forward)
    }

    /// The vertex moved on the disc, whose radius is the unit; `None` beyond its rim.
    pub(super) fn moved(&self, lens: &Vertex, by: Vec2) -> Option<Vertex> {
        let offset = self.offset(lens);
        let p = Vec2::from(self.axes.map(|axis| offset.dot(axis) / self.radius)) + by;
        (p.length_squared() < 1.0).then(|| self.at(p))
    }

    #[inline]
    fn offset(&self, lens: &Vertex) -> Vec3A {
        lens.position - self.position
    }

    /// The ray from a point of the disc through a film point.
    #[inline]
    pub(super) fn sample(&self, film: Vec2, lens: &Vertex) -> CameraRay {
        let step = self.centre.sample(film).step - self.offset(lens) / self.focus;
        CameraRay { origin: lens.origin(step), step }
    }

    /// The film point that a direction from a point of the disc passes through, and the cosine of its angle with the viewing
    /// direction.
    #[inline]
    pub(super) fn project(&self, lens: &Vertex, direction: Vec3A) -> (Vec2, f32) {
        let (film, cos) = self.centre.project(direction);
        let shift = self.offset(lens) / self.focus;
        (film + Vec2::new(shift.dot(self.centre.across), shift.dot(self.centre.along)), cos)
    }

    /// Area that the rays through one film point take up at a depth.
    pub(super) fn blur(&self, depth: f32) -> f32 {
        let radius = self.radius * (1.0 - depth / self.focus);
        PI * radius * radius
    }
}
