//! The energy that one scattering by microfacets lacks.

use super::interpolation::lerp;
use super::microfacet::Microfacets;
use glam::Vec3A;
use std::fmt::Debug;

/// Terms of the albedo of one scattering by microfacets with f = D G₂/(4 cosθₗ cosθₑ), for light along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Lacking {
    /// m = 1 - ∫ f cosθ dω.
    pub white: f32,
    /// B = ∫ f (1 - h·l)⁵ cosθ dω, the part of Schlick's F that goes with F₉₀ - F₀.
    pub grazing: f32,
}

impl Lacking {
    /// Linear interpolation.
    #[inline]
    pub(super) fn towards(self, end: Self, t: f32) -> Self {
        Self { white: lerp(self.white, end.white, t), grazing: lerp(self.grazing, end.grazing, t) }
    }
}

/// Microfacets whose albedo is in a table.
pub trait Tabulated: Microfacets {
    /// Kept for one roughness, to read it.
    type Albedo: Copy + Debug;

    /// The energy that one scattering lacks at a direction.
    fn lacking(self, albedo: &Self::Albedo, n: Vec3A, direction: Vec3A) -> Lacking;
}
