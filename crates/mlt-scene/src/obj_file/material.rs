//! MTL's materials.

use crate::metallic_roughness::{MetallicRoughness, Range};
use mlt_core::transport::{Rgb, material::Material};

/// Reflectance of the surface that stands in for a missing material.
const GREY: Rgb = Rgb::splat(0.5);

/// Reflectance at normal incidence of a dielectric with glTF's index of refraction, 1.5.
const F0: f32 = 0.04;

/// What stands in for a material that is not defined.
pub(super) fn grey() -> Material {
    let bsdf = MetallicRoughness::lambert(GREY).bsdf();
    Material { name: "grey".to_owned(), bsdf, emission: Rgb::ZERO, emits_both_sides: false }
}

/// A material, which emits `Ke` as radiance from its front.
pub(super) fn material(source: &tobj::Material, warnings: &mut Vec<String>) -> Material {
    let name = source.name.clone();
    let mut range = Range { material: &name, warnings };
    let emission = rgb(source.emissive).map_or(Rgb::ZERO, |c| range.colour("Ke", c, 1e12));
    let bsdf = parameters(source, &mut range).bsdf();
    let textures = textures(source);
    if !textures.is_empty() {
        warnings.push(format!("material `{name}`: {} are not supported and left out", textures.join(", ")));
    }
    Material { name, bsdf, emission, emits_both_sides: false }
}

/// The model that a material's parameters ask for, in this order: glass, the `Pr`/`Pm` extension, mirror, gloss, diffuse.
fn parameters(source: &tobj::Material, range: &mut Range) -> MetallicRoughness {
    let number = |key: &str| source.unknown_param.get(key)?.split_whitespace().next()?.parse::<f32>().ok();
    let absent = if source.emissive.is_some() { Rgb::ZERO } else { GREY };
    let diffuse = range.colour("Kd", rgb(source.diffuse).unwrap_or(absent), 1.0);
    let specular = range.colour("Ks", rgb(source.specular).unwrap_or(Rgb::ZERO), 1.0);
    let shininess = source.shininess.map(|n| n as f32);
    let opacity = source.dissolve.map(|d| d as f32).or(number("Tr").map(|t| 1.0 - t)).unwrap_or(1.0);
    let shown = source.illumination_model.unwrap_or(2);

    if matches!(shown, 4 | 6 | 7 | 9) || opacity < 1.0 {
        let ior = source.optical_density.map_or(1.5, |n| n as f32);
        return MetallicRoughness {
            base_color: range.colour("Tf", filter(source).unwrap_or(Rgb::ONE), 1.0),
            metallic: 0.0,
            roughness: range.number("Pr", number("Pr").unwrap_or(0.0), [0.0, 1.0]),
            ior: range.number("Ni", ior, [1.0, 100.0]),
            transmission: 1.0,
            thin: false,
            ..MetallicRoughness::default()
        };
    }
    if number("Pr").is_some() || number("Pm").is_some() {
        return MetallicRoughness {
            base_color: diffuse,
            metallic: range.number("Pm", number("Pm").unwrap_or(0.0), [0.0, 1.0]),
            roughness: range.number("Pr", number("Pr").unwrap_or(1.0), [0.0, 1.0]),
            ..MetallicRoughness::default()
        };
    }
    match shininess {
        _ if specular == Rgb::ZERO => MetallicRoughness::lambert(diffuse),
        _ if matches!(shown, 3 | 5) => {
            MetallicRoughness { base_color: specular, roughness: 0.0, ..MetallicRoughness::default() }
        }
        Some(exponent) if shown >= 2 => glossy(diffuse, specular, range.number("Ns", exponent, [0.0, 1e6])),
        _ => MetallicRoughness::lambert(diffuse),
    }
}

/// A diffuse base under a reflection that is `specular` at normal incidence.
///
/// α = √(2 / (n + 2)) gives a microfacet distribution the width of Blinn's lobe with exponent n; roughness = √α.
/// Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007.
fn glossy(diffuse: Rgb, specular: Rgb, exponent: f32) -> MetallicRoughness {
    let alpha = (2.0 / (exponent + 2.0)).sqrt();
    MetallicRoughness {
        base_color: diffuse,
        metallic: 0.0,
        roughness: alpha.sqrt(),
        specular_color: specular / F0,
        ..MetallicRoughness::default()
    }
}

/// The transmission filter, as three numbers.
fn filter(source: &tobj::Material) -> Option<Rgb> {
    let mut words = source.unknown_param.get("Tf")?.split_whitespace().map(|w| w.parse().ok());
    Some(Rgb::new(words.next()??, words.next()??, words.next()??))
}

fn rgb(colour: Option<[f64; 3]>) -> Option<Rgb> {
    colour.map(|c| Rgb::from_array(c.map(|x| x as f32)))
}

/// The statements that name texture files.
fn textures(source: &tobj::Material) -> Vec<String> {
    let read = [
        (&source.diffuse_texture, "map_Kd"),
        (&source.specular_texture, "map_Ks"),
        (&source.normal_texture, "bump"),
        (&source.shininess_texture, "map_Ns"),
        (&source.dissolve_texture, "map_d"),
    ];
    let unread =
        source.unknown_param.keys().filter(|k| k.starts_with("map_") || ["disp", "norm", "refl"].contains(&k.as_str()));
    let mut names: Vec<_> =
        read.iter().filter(|t| t.0.is_some()).map(|t| t.1.to_owned()).chain(unread.cloned()).collect();
    names.sort();
    names
}
