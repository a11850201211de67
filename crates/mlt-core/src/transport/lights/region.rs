//! A part of the lights, from which points are drawn in proportion to power, or for a vertex that they are to light.

use super::cell::Cell;
use super::sampler::{LightSampler, Receiver};
use crate::transport::geometry::Vertex;
use crate::transport::scene::{LightPoint, Lights, Scene};
use glam::DVec2;
use std::sync::Arc;

/// Cells of one or more lights.
#[derive(Clone, Debug)]
pub struct LightRegion {
    cells: Vec<Cell>,
    /// Share of the power up to and with each cell.
    cumulative: Vec<f64>,
    /// How u lies on each cell.
    scales: Vec<Scale>,
    power: f64,
    light_sampler: Arc<LightSampler>,
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

impl LightRegion {
    /// The union of disjoint cells, those of a light in one run.
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
        let light_sampler = Arc::new(LightSampler::new(lights, &cells));
        Self { cells, cumulative, scales, power, light_sampler }
    }

    /// All lights.
    pub fn whole(lights: &Lights) -> Self {
        Self::new(lights, (0..lights.lights.len() as u32).map(Cell::whole).collect())
    }

    /// ∫ M over the region; a point's density is M/power, in its light's measure.
    #[inline]
    pub fn power(&self) -> f64 {
        self.power
    }

    /// The cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Draws points of the region for a vertex.
    #[inline]
    pub fn light_sampler(&self) -> &LightSampler {
        &self.light_sampler
    }

    /// λ = d(x_0 | x_1) Φ/M: how much likelier [`light_sampler`](Self::light_sampler) draws x_0 for x_1 than [`sample`](Self::sample)
    /// does; 1 where there is but one piece, 0 where x_0, at `point`, is not in the region, and where no
    /// connection makes the edge.
    #[inline]
    pub(crate) fn preference(&self, scene: &Scene, [x_0, x_1]: [&Vertex; 2], point: &LightPoint) -> f64 {
        if x_0.is_met_by_one_ray(x_1) {
            return 0.0;
        }
        if !self.light_sampler.has_choice() {
            return 1.0;
        }
        let Some(number) = scene.lights().number(x_0.primitive) else { return 0.0 };
        let exitance = scene.lights().lights[number.0 as usize].mean_exitance();
        let receiver = Receiver::of_light(scene, x_0, x_1);
        self.preference_of(self.light_sampler.density(&receiver, number, || point.place()), exitance)
    }

    /// The same from d and M, both in the mean over the piece, as a piece's points are drawn in proportion to M.
    #[inline]
    pub(crate) fn preference_of(&self, density: f64, mean_exitance: f64) -> f64 {
        if self.light_sampler.has_choice() { density * self.power / mean_exitance } else { 1.0 }
    }

    /// A point with density M/power, from two uniform numbers; never on a cell's upper bounds.
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
