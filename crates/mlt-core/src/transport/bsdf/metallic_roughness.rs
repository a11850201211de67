//! glTF's metallic-roughness parameters, and the simplest BSDF for them.

use super::microfacet::Ggx;
use super::{Bsdf, Conductor, Dielectric, Glossy, Lambert, Mirror, Mix, RoughDielectric, RoughThin, Thin};
use crate::transport::colour::Rgb;

/// α below this is perfectly smooth: rounding of directions in f32, 10⁻⁷, no longer resolves the lobe.
pub const SMOOTH_ALPHA: f32 = 1e-6;

/// Smallest α of a lobe that is mixed with others: mixtures of delta and finite lobes are not modelled.
pub const MIXED_ALPHA: f32 = 1e-4;

/// An interface with |ior - 1| up to this does not bend light.
const INDEX_MATCHED: f32 = 1e-3;

/// Constant factors of a glTF 2.0 material with KHR_materials_ior, _specular, _transmission and _volume.
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
    fn valid(&self) -> Self {
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
        }
    }

    /// The simplest BSDF for these factors:
    /// mix(mix(coated base, transmitter, transmission), metal, metallic), without the terms of weight 0.
    pub fn bsdf(&self) -> Bsdf {
        let m = self.valid();
        let alpha = m.roughness * m.roughness;
        let alpha_of_lobe = if m.is_single_lobe() { alpha } else { alpha.max(MIXED_ALPHA) };
        let ggx = (alpha_of_lobe >= SMOOTH_ALPHA).then_some(Ggx { alpha: alpha_of_lobe });
        let transmitting = || mix(|| m.opaque(alpha), || m.transmitter(ggx), m.transmission);
        mix(transmitting, || m.metal(ggx), m.metallic)
    }

    /// Nothing but metal, or nothing but a transmitter: may be delta.
    fn is_single_lobe(&self) -> bool {
        self.metallic == 1.0 || (self.metallic == 0.0 && self.transmission == 1.0)
    }

    fn metal(&self, ggx: Option<Ggx>) -> Bsdf {
        let f0 = self.base_color;
        ggx.map_or(Bsdf::Mirror(Mirror { f0 }), |ggx| Bsdf::Conductor(Conductor::new(f0, 1.0, ggx)))
    }

    fn opaque(&self, alpha: f32) -> Bsdf {
        let base = Lambert { reflectance: self.base_color };
        if self.specular == 0.0 {
            return if base.reflectance == Rgb::ZERO { Bsdf::Black } else { Bsdf::Lambert(base) };
        }
        let r = (self.ior - 1.0) / (self.ior + 1.0);
        let f0 = (r * r * self.specular_color).min(Rgb::ONE) * self.specular;
        let coat = Conductor::new(f0, self.specular, Ggx { alpha: alpha.max(MIXED_ALPHA) });
        Bsdf::Glossy(Glossy::new(base, coat))
    }

    fn transmitter(&self, ggx: Option<Ggx>) -> Bsdf {
        let (ior, tint) = (self.ior, self.base_color);
        match ggx {
            Some(ggx) if self.thin => Bsdf::RoughThin(RoughThin::new(ior, tint, ggx)),
            Some(ggx) if (ior - 1.0).abs() > INDEX_MATCHED => {
                Bsdf::RoughDielectric(RoughDielectric::new(ior, tint, ggx))
            }
            Some(_) if !self.is_single_lobe() => Bsdf::RoughThin(RoughThin::new(ior, tint, Ggx { alpha: MIXED_ALPHA })),
            None if self.thin => Bsdf::Thin(Thin { ior, tint }),
            _ => Bsdf::Dielectric(Dielectric { ior, tint }),
        }
    }
}

/// (1 - weight)·a + weight·b, or the one that is left.
fn mix(a: impl FnOnce() -> Bsdf, b: impl FnOnce() -> Bsdf, weight: f32) -> Bsdf {
    match weight {
        0.0 => a(),
        1.0 => b(),
        _ => Bsdf::Mix(Box::new(Mix { a: a(), b: b(), weight })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> MetallicRoughness {
        MetallicRoughness { metallic: 0.0, ..Default::default() }
    }

    #[test]
    fn simplest_variant_for_each_material() {
        let glass = || MetallicRoughness { transmission: 1.0, roughness: 0.0, thin: false, ..plain() };
        let smooth = |roughness| MetallicRoughness { roughness, ..Default::default() }.bsdf();
        assert!(matches!(MetallicRoughness { specular: 0.0, ..plain() }.bsdf(), Bsdf::Lambert(_)));
        let black = MetallicRoughness { specular: 0.0, base_color: Rgb::ZERO, ..plain() };
        assert!(matches!(black.bsdf(), Bsdf::Black));
        assert!(matches!(plain().bsdf(), Bsdf::Glossy(_)));
        assert!(matches!(smooth(0.0), Bsdf::Mirror(_)) && matches!(smooth(0.01), Bsdf::Conductor(_)));
        assert!(matches!(glass().bsdf(), Bsdf::Dielectric(_)));
        assert!(matches!(MetallicRoughness { thin: true, ..glass() }.bsdf(), Bsdf::Thin(_)));
        assert!(matches!(MetallicRoughness { roughness: 0.2, ..glass() }.bsdf(), Bsdf::RoughDielectric(_)));
        assert!(matches!(MetallicRoughness { roughness: 0.2, ior: 1.0, ..glass() }.bsdf(), Bsdf::Dielectric(_)));
        assert!(matches!(MetallicRoughness { roughness: 0.2, thin: true, ..glass() }.bsdf(), Bsdf::RoughThin(_)));
        assert!(matches!(MetallicRoughness { ior: 0.0, ..glass() }.bsdf(), Bsdf::Glossy(_)));
    }

    #[test]
    fn coat_has_the_extensions_reflectance() {
        let tinted = MetallicRoughness { specular: 0.5, specular_color: Rgb::new(1.0, 0.5, 50.0), ..plain() };
        let Bsdf::Glossy(g) = tinted.bsdf() else { panic!("not a coat") };
        assert!((g.coat.f0 - Rgb::new(0.02, 0.01, 0.5)).length() < 1e-6 && g.coat.f90 == 0.5);
    }

    /// No mixture holds a delta lobe, whatever the factors, and none is NaN.
    #[test]
    fn mixtures_are_finite_whatever_the_file_says() {
        fn check(b: &Bsdf, inside_mixture: bool) {
            assert!(!(inside_mixture && b.is_delta()), "{b:?}");
            assert!(!format!("{b:?}").contains("NaN"));
            if let Bsdf::Mix(m) = b {
                check(&m.a, true);
                check(&m.b, true);
            }
        }
        let odd = [0.0, 1e-9, 0.3, 1.0, -1.0, 7.0, f32::NAN, f32::INFINITY];
        // A part of them: rough glass takes a millisecond to make.
        for i in (0..odd.len().pow(5)).step_by(37) {
            let factor = |k: u32| odd[i / odd.len().pow(k) % odd.len()];
            let (base, specular) = (factor(0), factor(4));
            let m = MetallicRoughness {
                base_color: Rgb::splat(base),
                metallic: factor(1),
                roughness: factor(2),
                ior: factor(3),
                specular,
                specular_color: Rgb::splat(base),
                transmission: specular,
                thin: i % 2 == 0,
            };
            check(&m.bsdf(), false);
        }
    }
}
