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
    /// Share of the power up to and with each cell.
    cumulative: Vec<f64>,
    /// How u lies on each cell.
    scales: Vec<Scale>,
    power: f64,
}

/// The map of an interval of [0, 1) onto a cell.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// Where the interval begins.
    begin: f64,
    /// Width of the cell over that of the interval.
    width: f64,
    height: f64,
    /// The largest coordinates below the cell's upper bounds.
    last: DVec2,
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
        let mut begin = 0.0;
        let mut scale = |(cell, &end): (&Cell, &f64)| {
            let size = cell.high - cell.low;
            let last = DVec2::new(cell.high.x.next_down(), cell.high.y.next_down());
            let scale = Scale { begin, width: size.x / (end - begin), height: size.y, last };
            begin = end;
            scale
        };
        let scales = cells.iter().zip(&cumulative).map(&mut scale).collect();
        Self { cells, cumulative, scales, power }
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
    #[inline]
    pub fn sample(&self, u: f64, v: f64) -> LightPoint {
        let i = match self.cells.len() {
            1 => 0,
            n => self.cumulative.partition_point(|&c| c <= u).min(n - 1),
        };
        let (Cell { light, low, .. }, Scale { begin, width, height, last }) = (self.cells[i], self.scales[i]);
        let (u, v) = (low.x + ((u - begin) * width).max(0.0), low.y + v * height);
        LightPoint { light, u: least(u, last.x), v: least(v, last.y) }
    }
}

/// The smaller of two numbers; [`f64::min`] also has to look for NaN.
#[inline]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
