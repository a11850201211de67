//! Microfacets with all that is known of them at one roughness.

use super::albedo::Albedo;
use super::albedo_table::ROWS;
use super::lacking::{Lacking, Tabulated};
use super::microfacet::Ggx;
use super::spread::Spread;
use glam::Vec3A;
use std::sync::LazyLock;

/// Microfacets, what one scattering by them lacks, and where the rest goes.
#[derive(Clone, Copy, Debug)]
pub struct Facets<D: Tabulated = Ggx> {
    /// Their distribution.
    pub ggx: D,
    pub(super) albedo: D::Albedo,
    /// Directions about as light leaves that they scatter more than once.
    pub(super) spread: Spread,
    /// ∫₀¹ · 2μ dμ of what is lacking, in the mean over azimuths.
    pub(super) mean: Lacking,
}

impl<D: Tabulated> Facets<D> {
    /// The energy that one scattering lacks at a direction.
    #[inline]
    pub(super) fn lacking(&self, n: Vec3A, direction: Vec3A) -> Lacking {
        self.ggx.lacking(&self.albedo, n, direction)
    }
}

/// Nodes of [`MEANS`] between two rows of the tables of albedo.
const NODES_PER_ROW: usize = 8;

/// The means at equidistant roughnesses √α.
static MEANS: LazyLock<Vec<Lacking>> = LazyLock::new(|| {
    let last = NODES_PER_ROW * (ROWS - 1);
    let roughness = |i: usize| (i as f32 / last as f32).max(1e-3);
    (0..=last).map(|i| Albedo::new(Ggx { alpha: roughness(i) * roughness(i) }).average()).collect()
});

impl Facets {
    /// With means by quadrature.
    pub fn new(ggx: Ggx) -> Self {
        let albedo = Albedo::new(ggx);
        Self { ggx, albedo, spread: Spread::new(ggx), mean: albedo.average() }
    }

    /// With means from a table: a hundredth of the time, for roughness that varies over a surface.
    pub fn tabulated(ggx: Ggx) -> Self {
        let means = &MEANS[..];
        let position = ggx.alpha.sqrt() * (means.len() - 1) as f32;
        let node = (position as usize).min(means.len() - 2);
        let mean = means[node].towards(means[node + 1], position - node as f32);
        Self { ggx, albedo: Albedo::new(ggx), spread: Spread::new(ggx), mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_means_are_those_of_quadrature() {
        for roughness in [0.011, 0.05, 0.2, 0.333, 0.51, 0.77, 0.999, 1.0f32] {
            let ggx = Ggx { alpha: roughness * roughness };
            let (exact, quick) = (Facets::new(ggx).mean, Facets::tabulated(ggx).mean);
            let off = [exact.white - quick.white, exact.grazing - quick.grazing];
            assert!(off.iter().all(|d| d.abs() < 2e-4), "{roughness}: {off:?}");
        }
    }
}
