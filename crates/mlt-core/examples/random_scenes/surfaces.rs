//! Random materials.

use super::dice::Dice;
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Anisotropy, Bsdf, Lambert, MetallicRoughness};
use mlt_core::transport::scene::{Alpha, Maps, Material};

/// A surface that scatters widely: all methods find all light that it sends on, from lights of any size.
pub(crate) fn wide(dice: &mut Dice) -> Material {
    let opacity = if dice.chance(0.1) { dice.pick(&[0.1, 0.5, 0.9]) } else { 1.0 };
    if dice.chance(0.5) {
        let bsdf = Bsdf::Lambert(Lambert { reflectance: colour(dice) });
        return Material { bsdf, opacity, ..Material::default() };
    }
    let mut factors = opaque(dice, 0.4, 1.0);
    if dice.chance(0.2) {
        factors.sheen_color = colour(dice);
        factors.sheen_roughness = dice.between(0.3, 1.0) as f32;
    }
    material(factors, opacity)
}

/// A surface of any kind: mirrors, clear and frosted glass, panes, coats.
pub(crate) fn any(dice: &mut Dice) -> Material {
    match dice.up_to(6) {
        0 => wide(dice),
        1 => material(MetallicRoughness { roughness: 0.0, metallic: 1.0, ..opaque(dice, 0.0, 0.0) }, 1.0),
        2 => material(opaque(dice, 0.1, 0.5), dice.pick(&[1.0, 1.0, 0.5])),
        3 => {
            let clearcoat = dice.between(0.0, 1.0) as f32;
            material(MetallicRoughness { clearcoat, clearcoat_roughness: 0.3, ..opaque(dice, 0.2, 1.0) }, 1.0)
        }
        kind => {
            let mut solid = material(glass(dice, kind == 6), 1.0);
            if kind != 6 && dice.chance(0.3) {
                solid.absorption = Rgb::from(dice.colour(0.0, 2.0));
            }
            solid
        }
    }
}

fn glass(dice: &mut Dice, thin: bool) -> MetallicRoughness {
    MetallicRoughness {
        base_color: dice.pick(&[Rgb::ONE, Rgb::new(0.9, 0.6, 0.3)]),
        metallic: 0.0,
        roughness: dice.pick(&[0.0, 0.0, 0.2, 0.5]),
        ior: dice.pick(&[1.0, 1.05, 1.33, 1.5, 2.4]),
        transmission: dice.pick(&[1.0, 1.0, 0.5]),
        thin,
        ..MetallicRoughness::default()
    }
}

/// Between plastic and metal, now and then brushed.
fn opaque(dice: &mut Dice, low: f64, high: f64) -> MetallicRoughness {
    let strength = if dice.chance(0.1) { dice.between(0.2, 0.9) as f32 } else { 0.0 };
    MetallicRoughness {
        base_color: colour(dice),
        metallic: dice.pick(&[0.0, 0.0, 0.5, 1.0]),
        roughness: dice.between(low, high) as f32,
        anisotropy: Anisotropy { strength, ..Anisotropy::default() },
        ..MetallicRoughness::default()
    }
}

fn colour(dice: &mut Dice) -> Rgb {
    dice.colour(0.05, 0.9)
}

fn material(factors: MetallicRoughness, opacity: f32) -> Material {
    Material { opacity, ..Material::default() }.scattering(factors, Maps::default(), Alpha::Blend)
}
