//! Parts of lights.

use glam::{DVec2, DVec3, Vec3};

/// A flat part of a surface, or a part of the directions that a distant light is seen in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Its place in the light's unit square: the corners with the smallest and with the largest coordinates.
    pub(crate) square: [DVec2; 2],
    /// Corner of its bounding box with the smallest coordinates; of directions their mean, as the other one is.
    pub(crate) low: Vec3,
    /// Corner with the largest ones.
    pub(crate) high: Vec3,
    /// Unit normal of the front.
    pub(crate) normal: Vec3,
    /// Angle with it up to which light goes out undiminished, radians; beyond that it falls off as from a surface.
    pub(crate) spread: f64,
}

impl Piece {
    pub(super) fn new(square: [DVec2; 2], corners: &[Vec3]) -> Self {
        let [a, b, c] = [0, 1, 2].map(|i| corners[i].as_dvec3());
        Self {
            square,
            low: corners.iter().copied().fold(Vec3::INFINITY, Vec3::min),
            high: corners.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max),
            normal: (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3(),
            spread: 0.0,
        }
    }

    /// Directions with this mean, weighted by power: the shorter, the wider they are spread.
    pub(super) fn of_directions(square: [DVec2; 2], mean: Vec3) -> Self {
        Self { square, low: mean, high: mean, normal: Vec3::Z, spread: 0.0 }
    }
}
