//! The simplest BSDF for glTF's metallic-roughness parameters.

use super::anisotropic::AnisotropicGgx;
use super::microfacet::Ggx;
use super::{
    Bsdf, Coat, Conductor, Dielectric, Facets, Glossy, Lambert, Layered, Lobe, MetallicRoughness, Mirror, Mix,
    RoughDielectric, RoughThin, Sheen, Thin,
};
use crate::transport::colour::Rgb;
use glam::Vec3A;

/// α below this is perfectly smooth: rounding of directions in f32, 10⁻⁷, no longer resolves the lobe.
pub const SMOOTH_ALPHA: f32 = 1e-6;

/// Smallest α of a lobe that is mixed with others: mixtures of delta and finite lobes are not modelled.
pub const MIXED_ALPHA: f32 = 1e-4;

impl MetallicRoughness {
    /// The simplest BSDF for these factors:
    /// mix(mix(coated base, transmitter, transmission), metal, metallic), without the terms of weight 0.
    pub fn bsdf(&self) -> Bsdf {
        self.valid().convert(&Computed, false)
    }

    /// The same; `rough`: no lobe is perfectly smooth.
    pub(super) fn convert(&self, made: &impl Microsurfaces, rough: bool) -> Bsdf {
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
    fn brushed(&self, made: &impl Microsurfaces, alpha: f32) -> Option<Facets<AnisotropicGgx>> {
        let tangent = made.own().streak.filter(|_| self.is_brushed())?;
        Some(Facets::brushed(tangent, self.anisotropy.alphas(alpha)))
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
}

/// Directions of one point of a surface beside its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Directions {
    /// Unit tangent along which the surface is rougher; `None`: it is not known, and the surface is as rough along all.
    pub streak: Option<Vec3A>,
    /// Unit normal of the clear coat; `None`: that of the base.
    pub coat_normal: Option<Vec3A>,
}

/// Where a conversion has from what depends on roughness, index of refraction and place alone.
pub(super) trait Microsurfaces {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::bsdf::{Anisotropy, Stretch};

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
