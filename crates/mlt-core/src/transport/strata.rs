//! Strata over the surface of the lights.

use super::light::{Light, LightPoint, Shape};
use super::lights::Lights;
use super::region::{Cell, LightRegion};
use glam::DVec2;

/// How Ω is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stratification {
    /// Not at all: one stratum.
    #[default]
    None,
    /// N×M cells of a rectangle; N·M parts of equal area of any other light.
    Grid(u32, u32),
}

/// A partition of the lights, and with them of path space: Ω_j are the paths that start in part j.
#[derive(Clone, Debug)]
pub struct LightStrata {
    regions: Vec<LightRegion>,
    /// Of each light: its first stratum and its grid. Without a cut: (0, 1, 1) for all.
    grids: Vec<(u32, u32, u32)>,
}

impl LightStrata {
    /// Cuts the lights.
    pub fn new(lights: &Lights, stratification: Stratification) -> Self {
        let Stratification::Grid(n, m) = stratification else {
            return Self { regions: vec![LightRegion::whole(lights)], grids: vec![(0, 1, 1); lights.lights.len()] };
        };
        let (mut regions, mut grids) = (Vec::new(), Vec::new());
        for (id, light) in (0..).zip(&lights.lights) {
            let (nu, nv) = grid(light, n.max(1), m.max(1));
            grids.push((regions.len() as u32, nu, nv));
            let size = DVec2::new(f64::from(nu), f64::from(nv));
            for (j, i) in (0..nv).flat_map(|j| (0..nu).map(move |i| (j, i))) {
                let corner = DVec2::new(f64::from(i), f64::from(j));
                let cell = Cell { light: id, low: corner / size, high: (corner + DVec2::ONE) / size };
                regions.push(LightRegion::new(lights, vec![cell]));
            }
        }
        Self { regions, grids }
    }

    /// The parts, in the order of [`index`](Self::index).
    pub fn regions(&self) -> &[LightRegion] {
        &self.regions
    }

    /// The part that a point lies in, in constant time.
    #[inline]
    pub fn index(&self, point: &LightPoint) -> u32 {
        let (first, nu, nv) = self.grids[point.light as usize];
        first + cell(point.v, nv) * nu + cell(point.u, nu)
    }
}

/// Index of the interval [i/n, (i+1)/n) that x lies in, bounds rounded as the regions' are.
#[inline]
fn cell(x: f64, n: u32) -> u32 {
    let bound = |i: u32| f64::from(i) / f64::from(n);
    let i = ((x * f64::from(n)) as u32).min(n - 1);
    if x < bound(i) {
        i - 1
    } else if i + 1 < n && x >= bound(i + 1) {
        i + 1
    } else {
        i
    }
}

/// A mesh is cut along u alone, which runs through its triangles.
fn grid(light: &Light, n: u32, m: u32) -> (u32, u32) {
    match light.shape {
        Shape::Parallelogram { .. } => (n, m),
        Shape::Triangles { .. } => (n * m, 1),
    }
}
