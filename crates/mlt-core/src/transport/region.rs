//! A part of the lights, from which points are drawn in proportion to power.

use super::light::{Light, LightPoint};
use super::lights::Lights;
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

/// Cells of one or more lights.
#[derive(Clone, Debug)]
pub struct LightRegion {
    cells: Vec<Cell>,
    cumulative: Vec<f64>,
    power: f64,
}

impl Cell {
    /// The whole of a light.
    pub fn whole(light: u32) -> Self {
        Self { light, low: DVec2::ZERO, high: DVec2::ONE }
    }

    /// Emitted power of the cell.
    pub fn power(&self, lights: &[Light]) -> f64 {
        let size = self.high - self.low;
        lights[self.light as usize].power() * size.x * size.y
    }
}

impl LightRegion {
    /// The union of disjoint cells.
    pub fn new(lights: &Lights, cells: Vec<Cell>) -> Self {
        let mut power = 0.0;
        let mut add = |cell: &Cell| {
            power += cell.power(&lights.lights);
            power
        };
        let mut cumulative: Vec<f64> = cells.iter().map(&mut add).collect();
        cumulative.iter_mut().for_each(|c| *c /= power);
        Self { cells, cumulative, power }
    }

    /// All lights.
    pub fn whole(lights: &Lights) -> Self {
        Self::new(lights, (0..lights.lights.len() as u32).map(Cell::whole).collect())
    }

    /// ∫ M dA over the region; a point's density per area is M/power.
    #[inline]
    pub fn power(&self) -> f64 {
        self.power
    }

    /// The cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// A point with density M/power per area, from two uniform numbers; never on a cell's upper bounds.
    pub fn sample(&self, u: f64, v: f64) -> LightPoint {
        let i = self.cumulative.partition_point(|&c| c <= u).min(self.cells.len() - 1);
        let low = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let Cell { light, low: corner, high } = self.cells[i];
        let u = ((u - low) / (self.cumulative[i] - low)).max(0.0);
        let p = corner + DVec2::new(u, v) * (high - corner);
        LightPoint { light, u: p.x.min(high.x.next_down()), v: p.y.min(high.y.next_down()) }
    }
}
