//! Microfacets with all that is known of them at one roughness.

use super::albedo::{Albedo, Lacking};
use super::albedo_table::ROWS;
use super::microfacet::{Ggx, Reflection};
use super::spread::Spread;
use glam::Vec3A;
use std::sync::LazyLock;

/// Microfacets, what one scattering by them lacks, and where the rest goes.
#[derive(Clone, Copy, Debug)]
pub struct Facets {
    /// Their distribution.
    pub ggx: Ggx,
    pub(super) table: Albedo,
    pub(super) spread: Spread,
    /// ∫₀¹ · 2μ dμ of what is lacking.
    pub(super) mean: Lacking,
}

/// Microfacets that reflect, what one scattering by them lacks, and where the rest goes.
pub trait Microfacets: Copy {
    /// How they mirror `a` into `b`; `None`: not on one side.
    fn reflection(&self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Reflection>;

    /// `given` mirrored about a normal that it sees; density: [`Reflection::pdf`]; `None`: it would go below the surface.
    fn sample_reflection(&self, n: Vec3A, given: Vec3A, u: [f32; 2]) -> Option<Vec3A>;

    /// The energy that is lacking at a direction.
    fn lacking(&self, n: Vec3A, direction: Vec3A) -> Lacking;

    /// Its mean over the hemisphere, ∫₀¹ · 2μ dμ.
    fn mean(&self) -> Lacking;

    /// Directions about as light leaves that they scatter more than once.
    fn spread(&self) -> Spread;
}

impl Microfacets for Facets {
    #[inline]
    fn reflection(&self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Reflection> {
        self.ggx.reflection(n, a, b)
    }

    #[inline]
    fn sample_reflection(&self, n: Vec3A, given: Vec3A, u: [f32; 2]) -> Option<Vec3A> {
        self.ggx.sample_reflection(n, given, u)
    }

    #[inline]
    fn lacking(&self, n: Vec3A, direction: Vec3A) -> Lacking {
        self.table.at(n.dot(direction).abs())
    }

    #[inline]
    fn mean(&self) -> Lacking {
        self.mean
    }

    #[inline]
    fn spread(&self) -> Spread {
        self.spread
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
        let table = Albedo::new(ggx);
        Self { ggx, table, spread: Spread::new(ggx), mean: table.average() }
    }

    /// With means from a table: a hundredth of the time, for roughness that varies over a surface.
    pub fn tabulated(ggx: Ggx) -> Self {
        let means = &MEANS[..];
        let position = ggx.alpha.sqrt() * (means.len() - 1) as f32;
        let node = (position as usize).min(means.len() - 2);
        let mean = means[node].towards(means[node + 1], position - node as f32);
        Self { ggx, table: Albedo::new(ggx), spread: Spread::new(ggx), mean }
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
