//! Distant lights of a region, which light all vertices alike: points are drawn on them by power.

use super::cell::Cell;
use crate::transport::scene::{Light, LightPoint};
use glam::DVec2;

/// Cells of distant lights.
#[derive(Clone, Debug, Default)]
pub(super) struct Afar {
    cells: Vec<Cell>,
    /// Share of their power up to and with each cell.
    cumulative: Vec<f64>,
    /// Of each cell: density per measure, in the mean over its light.
    densities: Vec<f64>,
    /// ∫ M.
    power: f64,
    /// Σ Φ/R²: bound on the irradiance that they send, in units in which a near light's is Φ cosθ cosθ'/d².
    pub(super) irradiance: f64,
}

impl Afar {
    /// Those of some cells whose lights are distant.
    pub(super) fn of(cells: &[Cell], lights: &[Light]) -> Self {
        let mut it = Self::default();
        for &cell in cells {
            let light = &lights[cell.light as usize];
            if let Some(radius) = light.radius_around() {
                let power = cell.power(lights);
                it.power += power;
                it.irradiance += power / f64::from(radius).powi(2);
                it.cells.push(cell);
                it.cumulative.push(it.power);
                it.densities.push(light.power() / light.measure);
            }
        }
        it.cumulative.iter_mut().for_each(|c| *c /= it.power);
        it.densities.iter_mut().for_each(|d| *d /= it.power);
        it
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    /// ∫ M over the cells.
    pub(super) fn power(&self) -> f64 {
        self.power
    }

    /// A point drawn by power, from two uniform numbers, and its density per measure, in the mean over its light.
    pub(super) fn sample(&self, u: f64, v: f64) -> (LightPoint, f64) {
        let i = self.cumulative.partition_point(|&c| c <= u).min(self.cells.len() - 1);
        let begin = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let Cell { light, low, high } = self.cells[i];
        let last = DVec2::new(high.x.next_down(), high.y.next_down());
        let inside = DVec2::new(((u - begin) / (self.cumulative[i] - begin)).max(0.0), v);
        let place = (low + inside * (high - low)).min(last);
        (LightPoint { light, u: place.x, v: place.y }, self.densities[i])
    }

    /// That density of a point; `None` if it is on none of the cells.
    pub(super) fn density(&self, point: &LightPoint) -> Option<f64> {
        let at = DVec2::new(point.u, point.v).min(DVec2::splat(1f64.next_down()));
        let cell = self.cells.iter().position(|cell| cell.light == point.light && cell.holds(at))?;
        Some(self.densities[cell])
    }
}
