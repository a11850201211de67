//! glTF's materials.

use super::unsupported;
use crate::metallic_roughness::MetallicRoughness;
use gltf::Document;
use mlt_core::transport::{Rgb, material::Material};
use std::collections::BTreeSet;

/// Every material of the document, and glTF's default one behind them if it is used; only used ones give warnings.
pub(super) fn materials(document: &Document, used: &BTreeSet<usize>, warnings: &mut Vec<String>) -> Vec<Material> {
    let mut materials = Vec::new();
    for (index, source) in document.materials().enumerate() {
        let mut unheard = Vec::new();
        let heard = if used.contains(&index) { &mut *warnings } else { &mut unheard };
        heard.extend(unsupported::in_material(&source));
        materials.push(material(index, &source, heard));
    }
    if used.contains(&materials.len()) {
        let bsdf = MetallicRoughness::default().bsdf();
        materials.push(Material { name: "default".to_owned(), bsdf, emission: Rgb::ZERO, emits_both_sides: false });
    }
    materials
}

fn material(index: usize, source: &gltf::Material, warnings: &mut Vec<String>) -> Material {
    let name = source.name().map_or_else(|| format!("material {index}"), str::to_owned);
    let mut change = |what: &str, value: f32, range: [f32; 2]| {
        let clamped = if value.is_nan() { range[0] } else { value.clamp(range[0], range[1]) };
        if clamped != value {
            warnings.push(format!("material `{name}`: {what} is {value}; {clamped} is taken instead"));
        }
        clamped
    };
    let strength = source.emissive_strength().unwrap_or(1.0);
    let emission = source.emissive_factor().map(|c| change("a component of the emission", c * strength, [0.0, 1e12]));
    let bsdf = parameters(source, &mut change).bsdf();
    Material { bsdf, emission: Rgb::from_array(emission), emits_both_sides: source.double_sided(), name }
}

/// The surface's parameters, each made to lie in its range by `within`.
fn parameters(source: &gltf::Material, mut within: impl FnMut(&str, f32, [f32; 2]) -> f32) -> MetallicRoughness {
    const SHARE: [f32; 2] = [0.0, 1.0];
    let pbr = source.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor().map(|c| within("a component of the base colour", c, SHARE));
    let specular = source.specular();
    let tint = specular.as_ref().map_or([1.0; 3], |s| s.specular_color_factor());
    MetallicRoughness {
        base_color: Rgb::new(r, g, b),
        metallic: within("the metallic factor", pbr.metallic_factor(), SHARE),
        roughness: within("the roughness", pbr.roughness_factor(), SHARE),
        ior: within("the index of refraction", source.ior().unwrap_or(1.5), [1.0, 100.0]),
        specular: within("the specular factor", specular.map_or(1.0, |s| s.specular_factor()), SHARE),
        specular_color: Rgb::from_array(tint.map(|c| within("a component of the specular colour", c, [0.0, 1e6]))),
        transmission: within("the transmission", source.transmission().map_or(0.0, |t| t.transmission_factor()), SHARE),
        thin: source.volume().is_none(),
    }
}
