//! Rectangles in the unit square of a light.

use crate::engine::{DecodeError, Reader, put};
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

    /// Appends it to bytes.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        put(to, u64::from(self.light));
        [self.low.x, self.low.y, self.high.x, self.high.y].into_iter().for_each(|x| put(to, x.to_bits()));
    }

    /// Reads what [`write`](Self::write) has written: a rectangle within the unit square.
    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let light = u32::try_from(from.number()?).map_err(|_| DecodeError::Damaged)?;
        let mut corner = || Ok(DVec2::new(f64::from_bits(from.number()?), f64::from_bits(from.number()?)));
        let (low, high) = (corner()?, corner()?);
        let inside = low.cmpge(DVec2::ZERO) & low.cmplt(high) & high.cmple(DVec2::ONE);
        if inside.all() { Ok(Self { light, low, high }) } else { Err(DecodeError::Damaged) }
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
