//! Materials: how a surface scatters and emits light.

use super::cone::Cone;
use super::textures::{Alpha, Coordinates, Maps, Texture, Textured};
use crate::transport::bsdf::{Bsdf, MetallicRoughness};
use crate::transport::colour::Rgb;

/// A surface's scattering and emission.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the scene file, for messages.
    pub name: String,
    /// Scattering; of what is textured, an example of it.
    pub bsdf: Bsdf,
    /// Emitted radiance, uniform over directions unless it has a cone, and over the surface unless it is textured; zero: no light.
    pub emission: Rgb,
    /// Emits from the back as well as from the front.
    pub emits_both_sides: bool,
    /// Directions that the emitted radiance goes into; `None`: all on the side that emits.
    pub cone: Option<Cone>,
    /// Share of the surface that is there, α ∈ [0, 1]; through the rest light goes straight on. 0: there is no surface.
    pub opacity: f32,
    /// σ of the solid behind the surface, per scene unit: see `scene::medium`; zero: it is clear, or there is none.
    pub absorption: Rgb,
    /// Parameters that vary over the surface; `None`: none does.
    pub textured: Option<Box<Textured>>,
}

impl Default for Material {
    /// Black and opaque.
    fn default() -> Self {
        Self {
            name: String::new(),
            bsdf: Bsdf::Black,
            emission: Rgb::ZERO,
            emits_both_sides: false,
            cone: None,
            opacity: 1.0,
            absorption: Rgb::ZERO,
            textured: None,
        }
    }
}

impl Material {
    /// α at a point.
    pub(super) fn opacity_at(&self, textures: &[Texture], place: &Coordinates) -> f32 {
        match &self.textured {
            Some(textured) if textured.has_opacity() => textured.opacity(self.opacity, textures, place),
            _ => self.opacity,
        }
    }

    /// Emitted radiance at a point.
    pub(super) fn emission_at(&self, textures: &[Texture], place: &Coordinates) -> Rgb {
        self.textured.as_ref().map_or(self.emission, |textured| self.emission * textured.emission(textures, place))
    }

    /// The same as the surface of a solid instead of a thin wall; `None`: it is no such wall.
    pub fn solid(&self) -> Option<Self> {
        let textured = match &self.textured {
            Some(textured) => Some(Box::new(textured.solid()?)),
            None => None,
        };
        let bsdf = textured.as_ref().map_or_else(|| self.bsdf.solid(), |textured| Some(textured.representative()))?;
        Some(Self { bsdf, textured, ..self.clone() })
    }

    /// Whether its emission, or the share of it that is there, varies.
    pub(super) fn shines_unevenly(&self) -> bool {
        self.textured.as_ref().is_some_and(|textured| textured.has_opacity() || textured.has_emission())
    }

    /// The same with parameters of these factors, which vary as textures and vertices say.
    #[must_use]
    pub fn scattering(self, factors: MetallicRoughness, maps: Maps, alpha: Alpha) -> Self {
        if maps.is_empty() && !factors.is_brushed() {
            return Self { bsdf: factors.bsdf(), ..self };
        }
        let textured = Textured::new(factors, maps, alpha);
        Self { bsdf: textured.representative(), textured: Some(Box::new(textured)), ..self }
    }

    /// Whether it scatters light through the surface, here or there.
    pub fn transmits(&self) -> bool {
        self.bsdf.is_transmissive() || self.textured.as_deref().is_some_and(Textured::may_transmit)
    }

    /// Whether it has a narrow lobe, here or there.
    pub(crate) fn may_be_narrow(&self) -> bool {
        let varies =
            |textured: &Textured| textured.maps.roughness.is_some() || textured.maps.clearcoat_roughness.is_some();
        self.bsdf.narrow_lobe().is_some() || self.textured.as_deref().is_some_and(varies)
    }

    /// Whether some of the light that comes to it goes straight on.
    pub(crate) fn is_veil(&self) -> bool {
        self.opacity < 1.0 || self.textured.as_ref().is_some_and(|textured| textured.has_opacity())
    }
}
