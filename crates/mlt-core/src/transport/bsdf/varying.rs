//! BSDFs for parameters that vary over a surface.

use super::conversion::{Directions, MIXED_ALPHA, Microsurfaces, SMOOTH_ALPHA};
use super::microfacet::Ggx;
use super::rough_dielectric::RoughGlass;
use super::{Bsdf, Facets, MetallicRoughness, RoughDielectric, RoughThin};
use crate::transport::colour::Rgb;

/// Conversion of factors that vary over a surface, without allocation and without quadrature.
///
/// Index of refraction and thinness are the same everywhere.
#[derive(Clone, Debug)]
pub struct Varying {
    /// No lobe is perfectly smooth.
    rough: bool,
    /// [`RoughThin::mean_reflectance`].
    reflected: f32,
    glass: Option<RoughGlass>,
}

impl Varying {
    /// For a surface whose factors are at most these; `lobes`: metalness or transmission vary; `roughness`: roughness does.
    pub fn new(most: &MetallicRoughness, lobes: bool, roughness: bool) -> Self {
        let m = most.valid();
        let rough = lobes || roughness || m.is_layered() || m.is_brushed();
        let least = if rough || !m.is_single_lobe() { MIXED_ALPHA } else { SMOOTH_ALPHA }.sqrt();
        let most = m.roughness.max(least);
        let is_rough = rough || !m.is_single_lobe() || m.roughness * m.roughness >= SMOOTH_ALPHA;
        let has_glass = m.transmission > 0.0 && !m.thin && m.bends() && is_rough;
        Self {
            rough,
            reflected: RoughThin::mean_reflectance(m.ior),
            glass: has_glass.then(|| RoughGlass::new(m.ior, [if roughness { least } else { most }, most])),
        }
    }

    /// The simplest BSDF for the factors at one point.
    pub fn bsdf(&self, factors: &MetallicRoughness, directions: Directions) -> Bsdf {
        factors.valid().convert(&AtPoint { varying: self, directions }, self.rough)
    }
}

/// One point of a surface whose factors vary.
struct AtPoint<'a> {
    varying: &'a Varying,
    directions: Directions,
}

impl Microsurfaces for AtPoint<'_> {
    fn own(&self) -> Directions {
        self.directions
    }

    fn facets(&self, ggx: Ggx) -> Facets {
        Facets::tabulated(ggx)
    }

    fn wall(&self, ior: f32, tint: Rgb, ggx: Ggx) -> RoughThin {
        RoughThin::of(ior, tint, Facets::tabulated(ggx), self.varying.reflected)
    }

    fn glass(&self, ior: f32, tint: Rgb, ggx: Ggx) -> RoughDielectric {
        self.varying.glass.as_ref().map_or_else(|| RoughDielectric::new(ior, tint, ggx), |glass| glass.at(tint, ggx))
    }
}
