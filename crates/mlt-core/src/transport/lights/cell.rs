//! Rectangles in the unit square of a light.

use crate::transport::scene::Light;
use glam::DVec2;

/// A rectangle in one light's unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Index of the light.
    pub light: u32,
    /// Corner with the smallest coordinates.
    pub low: DVec2,
    /// Corner with the largest coordinates.
    pub high: DVec2,
}

impl Cell {
    /// The whole of a light.
    pub fn whole(light: u32) -> Self {
        Self { light, low: DVec2::ZERO, high: DVec2::ONE }
    }

    /// Whether a point lies in it, given its place in the light's unit square.
    pub(crate) fn holds(&self, place: DVec2) -> bool {
        place.cmpge(self.low).all() && place.cmplt(self.high).all()
    }

    /// Emitted power of the cell.
    pub fn power(&self, lights: &[Light]) -> f64 {
        let size = self.high - self.low;
        lights[self.light as usize].power() * size.x * size.y
    }
}
