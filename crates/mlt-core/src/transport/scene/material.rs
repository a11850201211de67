//! Materials: how a surface scatters and emits light.

use crate::transport::bsdf::Bsdf;
use crate::transport::colour::Rgb;

/// A surface's scattering and emission.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the scene file, for messages.
    pub name: String,
    /// Scattering.
    pub bsdf: Bsdf,
    /// Emitted radiance, uniform over the surface and over directions; zero: no light.
    pub emission: Rgb,
    /// Emits from the back as well as from the front.
    pub emits_both_sides: bool,
    /// Share of the surface that is there, α ∈ [0, 1]; through the rest light goes straight on. 0: there is no surface.
    pub opacity: f32,
}

impl Material {
    /// A surface that neither reflects nor emits.
    pub(super) fn black() -> Self {
        Self { name: String::new(), bsdf: Bsdf::Black, emission: Rgb::ZERO, emits_both_sides: false, opacity: 1.0 }
    }
}
