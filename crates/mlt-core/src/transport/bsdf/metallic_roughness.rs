//! glTF's metallic-roughness parameters.

use crate::transport::colour::Rgb;

/// An interface with |ior - 1| up to this does not bend light.
pub(super) const INDEX_MATCHED: f32 = 1e-3;

/// Constant factors of a glTF 2.0 material with KHR_materials_ior, _specular, _transmission, _volume, _clearcoat, _sheen and
/// _anisotropy.
///
/// Values out of range are clamped, those that are not numbers count as the default. Left out: `specular` and
/// `specular_color` on what transmits, which reflects as `ior` says.
#[derive(Clone, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// baseColorFactor ∈ [0, 1].
    pub base_color: Rgb,
    /// metallicFactor ∈ [0, 1].
    pub metallic: f32,
    /// roughnessFactor ∈ [0, 1]; α = roughness².
    pub roughness: f32,
    /// Index of refraction ∈ [0.1, 100]; 0: reflects everything, like a medium of infinite index.
    pub ior: f32,
    /// specularFactor ∈ [0, 1].
    pub specular: f32,
    /// specularColorFactor ≥ 0.
    pub specular_color: Rgb,
    /// transmissionFactor ∈ [0, 1].
    pub transmission: f32,
    /// A wall without volume behind it (no KHR_materials_volume).
    pub thin: bool,
    /// clearcoatFactor ∈ [0, 1].
    pub clearcoat: f32,
    /// clearcoatRoughnessFactor ∈ [0, 1].
    pub clearcoat_roughness: f32,
    /// sheenColorFactor ∈ [0, 1].
    pub sheen_color: Rgb,
    /// sheenRoughnessFactor ∈ [0, 1].
    pub sheen_roughness: f32,
    /// Of what reflects below the clear coat.
    pub anisotropy: Anisotropy,
}

/// How much rougher a surface is along one direction than across it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// anisotropyStrength ∈ [0, 1].
    pub strength: f32,
    /// anisotropyRotation: angle from the tangent to the direction of greater roughness, towards the bitangent, radians.
    pub rotation: f32,
    /// Meaning of the strength.
    pub stretch: Stretch,
}

/// α along the streaks and across them, from α and the strength s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stretch {
    /// α + (1 − α) s² and α, as KHR_materials_anisotropy says.
    #[default]
    OneSided,
    /// α/a and α a with a = √(1 − 0.9 s), as Blender renders and exports it.
    Balanced,
}

impl Anisotropy {
    fn valid(self) -> Self {
        let rotation = if self.rotation.is_finite() { self.rotation } else { 0.0 };
        Self { strength: clamped(self.strength, 1.0, 0.0), rotation, ..self }
    }

    /// α along the streaks and across them.
    pub(super) fn alphas(self, alpha: f32) -> [f32; 2] {
        match self.stretch {
            Stretch::OneSided => [alpha + (1.0 - alpha) * self.strength * self.strength, alpha],
            Stretch::Balanced => {
                let aspect = (1.0 - 0.9 * self.strength).sqrt();
                [(alpha / aspect).min(1.0), alpha * aspect]
            }
        }
    }
}

impl Default for MetallicRoughness {
    /// glTF's defaults.
    fn default() -> Self {
        Self {
            base_color: Rgb::ONE,
            metallic: 1.0,
            roughness: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Rgb::ONE,
            transmission: 0.0,
            thin: true,
            clearcoat: 0.0,
            clearcoat_roughness: 0.0,
            sheen_color: Rgb::ZERO,
            sheen_roughness: 0.0,
            anisotropy: Anisotropy::default(),
        }
    }
}

/// `v` in [0, max], `default` if it is not a number.
fn clamped(v: f32, max: f32, default: f32) -> f32 {
    if v.is_nan() { default } else { v.clamp(0.0, max) }
}

/// The same for each channel.
fn clamped_rgb(c: Rgb, max: f32) -> Rgb {
    Rgb::from_array(c.to_array().map(|v| clamped(v, max, 1.0)))
}

impl MetallicRoughness {
    /// The same with every factor in its range.
    pub(super) fn valid(&self) -> Self {
        let ior = match self.ior {
            ior if ior.is_nan() => 1.5,
            ior if ior <= 0.0 => 0.0,
            ior => ior.clamp(0.1, 100.0),
        };
        Self {
            base_color: clamped_rgb(self.base_color, 1.0),
            metallic: clamped(self.metallic, 1.0, 1.0),
            roughness: clamped(self.roughness, 1.0, 1.0),
            ior,
            specular: clamped(self.specular, 1.0, 1.0),
            specular_color: clamped_rgb(self.specular_color, f32::MAX),
            transmission: if ior == 0.0 { 0.0 } else { clamped(self.transmission, 1.0, 0.0) },
            thin: self.thin,
            clearcoat: clamped(self.clearcoat, 1.0, 0.0),
            clearcoat_roughness: clamped(self.clearcoat_roughness, 1.0, 0.0),
            sheen_color: clamped_rgb(self.sheen_color, 1.0),
            sheen_roughness: clamped(self.sheen_roughness, 1.0, 0.0),
            anisotropy: self.anisotropy.valid(),
        }
    }

    /// Whether it is rougher along one direction than across it, where that is known.
    pub(crate) fn is_brushed(&self) -> bool {
        self.anisotropy.strength > 0.0
    }

    /// Something covers the base.
    pub(super) fn is_layered(&self) -> bool {
        self.clearcoat > 0.0 || self.sheen_color != Rgb::ZERO
    }

    /// Nothing but metal, or nothing but a transmitter: may be delta.
    pub(super) fn is_single_lobe(&self) -> bool {
        self.metallic == 1.0 || (self.metallic == 0.0 && self.transmission == 1.0)
    }

    /// Whether a solid of it bends light.
    pub(super) fn bends(&self) -> bool {
        (self.ior - 1.0).abs() > INDEX_MATCHED
    }
}
