//! glTF's metallic-roughness parameters, and the simplest BSDF for them.

use super::microfacet::Ggx;
use super::rough_dielectric::RoughGlass;
use super::{
    Brushed, Bsdf, Coat, Conductor, Dielectric, Facets, Glossy, Lambert, Layered, Lobe, Mirror, Mix, RoughDielectric,
    RoughThin, Sheen, Thin,
};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// α below this is perfectly smooth: rounding of directions in f32, 10⁻⁷, no longer resolves the lobe.
pub const SMOOTH_ALPHA: f32 = 1e-6;

/// Smallest α of a lobe that is mixed with others: mixtures of delta and finite lobes are not modelled.
pub const MIXED_ALPHA: f32 = 1e-4;

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
    fn alphas(self, alpha: f32) -> [f32; 2] {
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
            clearcoat: clamped(self.clearcoat, 1.0, 0.0),
            clearcoat_roughness: clamped(self.clearcoat_roughness, 1.0, 0.0),
            sheen_color: clamped_rgb(self.sheen_color, 1.0),
            sheen_roughness: clamped(self.sheen_roughness, 1.0, 0.0),
            anisotropy: self.anisotropy.valid(),
        }
    }

    /// The simplest BSDF for these factors:
    /// mix(mix(coated base, transmitter, transmission), metal, metallic), without the terms of weight 0.
    pub fn bsdf(&self) -> Bsdf {
        self.valid().convert(&Computed, false)
    }

    /// The same; `rough`: no lobe is perfectly smooth.
    fn convert(&self, made: &impl Microsurfaces, rough: bool) -> Bsdf {
        if self.is_layered() {
            let alpha = (self.roughness * self.roughness).max(MIXED_ALPHA);
            return Bsdf::Layered(self.layers(made, self.mix(made, Ggx { alpha })));
        }
        let rough = rough || self.is_brushed();
        let alpha = self.roughness * self.roughness;
        let alpha_of_lobe = if !rough && self.is_single_lobe() { alpha } else { alpha.max(MIXED_ALPHA) };
        let ggx = (alpha_of_lobe >= SMOOTH_ALPHA).then_some(Ggx { alpha: alpha_of_lobe });
        let (metal, clear) = (self.metallic, (1.0 - self.metallic) * self.transmission);
        let opaque = || self.opaque(made, alpha);
        match ggx {
            _ if metal == 0.0 && clear == 0.0 => opaque().map_or(Bsdf::Black, Bsdf::from),
            None if metal == 1.0 => Bsdf::Mirror(Mirror { f0: self.base_color }),
            None => self.smooth_transmitter(),
            Some(ggx) if metal == 1.0 => self.metal(made, ggx).into(),
            Some(ggx) if clear == 1.0 => match self.rough_transmitter(made, ggx) {
                None if !rough => self.smooth_transmitter(),
                lobe => lobe.unwrap_or_else(|| self.index_matched(made)).into(),
            },
            Some(ggx) => Bsdf::Mix(self.mix(made, ggx)),
        }
    }

    /// All lobes of positive weight.
    fn mix(&self, made: &impl Microsurfaces, ggx: Ggx) -> Mix {
        let (metal, clear) = (self.metallic, (1.0 - self.metallic) * self.transmission);
        let transmitter = || self.rough_transmitter(made, ggx).unwrap_or_else(|| self.index_matched(made));
        let rest = (1.0 - metal) * (1.0 - self.transmission);
        let part = |weight: f32, lobe: &dyn Fn() -> Option<Lobe>| (weight, if weight > 0.0 { lobe() } else { None });
        let lobes = [
            part(rest, &|| self.opaque(made, ggx.alpha)),
            part(clear, &|| Some(transmitter())),
            part(metal, &|| Some(self.metal(made, ggx))),
        ];
        Mix { lobes }
    }

    /// Whether it is rougher along one direction than across it, where that is known.
    pub(crate) fn is_brushed(&self) -> bool {
        self.anisotropy.strength > 0.0
    }

    /// Something covers the base.
    fn is_layered(&self) -> bool {
        self.clearcoat > 0.0 || self.sheen_color != Rgb::ZERO
    }

    /// A coat of index 1.5 and fibres over a base.
    fn layers(&self, made: &impl Microsurfaces, base: Mix) -> Layered {
        let alpha = (self.clearcoat_roughness * self.clearcoat_roughness).max(MIXED_ALPHA);
        let lobe = || Conductor::of(Rgb::splat(0.04), 1.0, made.facets(Ggx { alpha }));
        Layered {
            coat: (self.clearcoat > 0.0).then(|| Coat {
                lobe: lobe(),
                share: self.clearcoat,
                normal: made.own().coat_normal,
            }),
            sheen: (self.sheen_color != Rgb::ZERO).then(|| Sheen::new(self.sheen_color, self.sheen_roughness)),
            base,
        }
    }

    /// Nothing but metal, or nothing but a transmitter: may be delta.
    fn is_single_lobe(&self) -> bool {
        self.metallic == 1.0 || (self.metallic == 0.0 && self.transmission == 1.0)
    }

    fn metal(&self, made: &impl Microsurfaces, ggx: Ggx) -> Lobe {
        match self.brushed(made, ggx.alpha) {
            Some(facets) => Lobe::BrushedMetal(Conductor::of(self.base_color, 1.0, facets)),
            None => Lobe::Conductor(Conductor::of(self.base_color, 1.0, made.facets(ggx))),
        }
    }

    /// `None`: it is black.
    fn opaque(&self, made: &impl Microsurfaces, alpha: f32) -> Option<Lobe> {
        let base = Lambert { reflectance: self.base_color };
        if self.specular == 0.0 {
            return (base.reflectance != Rgb::ZERO).then_some(Lobe::Lambert(base));
        }
        let r = (self.ior - 1.0) / (self.ior + 1.0);
        let f0 = (r * r * self.specular_color).min(Rgb::ONE) * self.specular;
        let alpha = alpha.max(MIXED_ALPHA);
        Some(match self.brushed(made, alpha) {
            Some(facets) => Lobe::BrushedCoat(Glossy::new(base, Conductor::of(f0, self.specular, facets))),
            None => Lobe::Glossy(Glossy::new(base, Conductor::of(f0, self.specular, made.facets(Ggx { alpha })))),
        })
    }

    /// Microfacets of what is brushed in a known direction.
    fn brushed(&self, made: &impl Microsurfaces, alpha: f32) -> Option<Brushed> {
        let tangent = made.own().streak.filter(|_| self.is_brushed())?;
        Some(Brushed::new(tangent, self.anisotropy.alphas(alpha)))
    }

    /// `None`: it does not bend light.
    fn rough_transmitter(&self, made: &impl Microsurfaces, ggx: Ggx) -> Option<Lobe> {
        if self.thin {
            Some(Lobe::RoughThin(made.wall(self.ior, self.base_color, ggx)))
        } else {
            self.bends().then(|| Lobe::RoughDielectric(made.glass(self.ior, self.base_color, ggx)))
        }
    }

    fn smooth_transmitter(&self) -> Bsdf {
        let (ior, tint) = (self.ior, self.base_color);
        if self.thin { Bsdf::Thin(Thin { ior, tint }) } else { Bsdf::Dielectric(Dielectric { ior, tint }) }
    }

    /// The lobe of an interface that does not bend light, where nothing may be delta.
    fn index_matched(&self, made: &impl Microsurfaces) -> Lobe {
        Lobe::RoughThin(made.wall(self.ior, self.base_color, Ggx { alpha: MIXED_ALPHA }))
    }

    /// Whether a solid of it bends light.
    fn bends(&self) -> bool {
        (self.ior - 1.0).abs() > INDEX_MATCHED
    }
}

/// Where a conversion has from what depends on roughness, index of refraction and place alone.
trait Microsurfaces {
    /// Directions of the place.
    fn own(&self) -> Directions;
    fn facets(&self, ggx: Ggx) -> Facets;
    fn wall(&self, ior: f32, tint: Rgb, ggx: Ggx) -> RoughThin;
    fn glass(&self, ior: f32, tint: Rgb, ggx: Ggx) -> RoughDielectric;
}

/// Found for one material.
struct Computed;

impl Microsurfaces for Computed {
    fn own(&self) -> Directions {
        Directions::default()
    }

    fn facets(&self, ggx: Ggx) -> Facets {
        Facets::new(ggx)
    }

    fn wall(&self, ior: f32, tint: Rgb, ggx: Ggx) -> RoughThin {
        RoughThin::new(ior, tint, ggx)
    }

    fn glass(&self, ior: f32, tint: Rgb, ggx: Ggx) -> RoughDielectric {
        RoughDielectric::new(ior, tint, ggx)
    }
}

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

/// Directions of one point of a surface beside its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Directions {
    /// Unit tangent along which the surface is rougher; `None`: it is not known, and the surface is as rough along all.
    pub streak: Option<Vec3A>,
    /// Unit normal of the clear coat; `None`: that of the base.
    pub coat_normal: Option<Vec3A>,
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

    /// No number of a BSDF is NaN.
    #[test]
    fn mixtures_are_finite_whatever_the_file_says() {
        fn check(b: &Bsdf) {
            assert!(!format!("{b:?}").contains("NaN"));
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
                clearcoat: specular,
                clearcoat_roughness: base,
                sheen_color: Rgb::splat(factor(3)),
                sheen_roughness: factor(2),
                anisotropy: Anisotropy { strength: factor(1), rotation: factor(3), stretch: Stretch::Balanced },
            };
            check(&m.bsdf());
        }
    }
}
