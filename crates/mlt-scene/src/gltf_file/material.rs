//! glTF's materials.

use super::unsupported;
use crate::{range::Range, text::shown};
use gltf::Document;
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::MetallicRoughness;
use mlt_core::transport::scene::Material;
use std::collections::BTreeSet;

/// Every material of the document, and glTF's default one behind them if it is used; only used ones give warnings.
pub(super) fn materials(document: &Document, used: &BTreeSet<usize>, warnings: &mut Vec<String>) -> Vec<Material> {
    let mut materials = Vec::new();
    for (index, source) in document.materials().enumerate() {
        let mut unheard = Vec::new();
        let heard = if used.contains(&index) { &mut *warnings } else { &mut unheard };
        heard.extend(unsupported::in_material(&source));
        heard.extend(unsupported::in_volume(&source));
        materials.push(material(index, &source, heard));
    }
    if used.contains(&materials.len()) {
        let bsdf = MetallicRoughness::default().bsdf();
        materials.push(Material {
            name: "default".to_owned(),
            bsdf,
            emission: Rgb::ZERO,
            emits_both_sides: false,
            opacity: 1.0,
        });
    }
    materials
}

fn material(index: usize, source: &gltf::Material, warnings: &mut Vec<String>) -> Material {
    let name = source.name().map_or_else(|| format!("material {index}"), shown);
    let mut range = Range { material: &name, warnings };
    let strength = source.emissive_strength().unwrap_or(1.0);
    let emission = range.colour("the emission", strength * Rgb::from_array(source.emissive_factor()), 1e12);
    let bsdf = parameters(source, &mut range).bsdf();
    Material { name, bsdf, emission, emits_both_sides: source.double_sided(), opacity: 1.0 }
}

/// A surface with KHR_materials_volume bounds a solid, whatever thickness its author gave for rasterisers;
/// [`unsupported`](super::unsupported) says so of a thickness of 0.
fn parameters(source: &gltf::Material, range: &mut Range) -> MetallicRoughness {
    const SHARE: [f32; 2] = [0.0, 1.0];
    let pbr = source.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    let specular = source.specular();
    let specular_color = specular.as_ref().map_or([1.0; 3], |s| s.specular_color_factor());
    let transmission = source.transmission().map_or(0.0, |t| t.transmission_factor());
    MetallicRoughness {
        base_color: range.colour("the base colour", Rgb::new(r, g, b), 1.0),
        metallic: range.number("the metallic factor", pbr.metallic_factor(), SHARE),
        roughness: range.number("the roughness", pbr.roughness_factor(), SHARE),
        ior: range.number("the index of refraction", source.ior().unwrap_or(1.5), [0.0, 100.0]),
        specular: range.number("the specular factor", specular.map_or(1.0, |s| s.specular_factor()), SHARE),
        specular_color: range.colour("the specular colour", Rgb::from_array(specular_color), 1e6),
        transmission: range.number("the transmission", transmission, SHARE),
        thin: source.volume().is_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(material: &str) -> MetallicRoughness {
        let json = format!(r#"{{ "asset": {{ "version": "2.0" }}, "materials": [{material}] }}"#);
        let gltf = gltf::Gltf::from_slice(json.as_bytes()).unwrap();
        let mut warnings = Vec::new();
        let mut range = Range { material: "m", warnings: &mut warnings };
        let parameters = parameters(&gltf.materials().next().unwrap(), &mut range);
        assert!(warnings.is_empty(), "{warnings:?}");
        parameters
    }

    #[test]
    fn an_empty_material_has_the_defaults() {
        assert_eq!(parsed("{}"), MetallicRoughness::default());
        assert_eq!(parsed(r#"{ "pbrMetallicRoughness": {} }"#), MetallicRoughness::default());
    }

    #[test]
    fn every_parameter_arrives() {
        let all = parsed(
            r#"{ "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 1], "metallicFactor": 0.4, "roughnessFactor": 0.5 },
                "extensions": { "KHR_materials_ior": { "ior": 1.6 },
                                "KHR_materials_specular": { "specularFactor": 0.7, "specularColorFactor": [0.8, 0.9, 2] },
                                "KHR_materials_transmission": { "transmissionFactor": 0.25 } } }"#,
        );
        let expected = MetallicRoughness {
            base_color: Rgb::new(0.1, 0.2, 0.3),
            metallic: 0.4,
            roughness: 0.5,
            ior: 1.6,
            specular: 0.7,
            specular_color: Rgb::new(0.8, 0.9, 2.0),
            transmission: 0.25,
            thin: true,
        };
        assert_eq!(all, expected);
    }

    #[test]
    fn a_volume_makes_a_solid() {
        for volume in ["{}", r#"{ "thicknessFactor": 1 }"#] {
            assert!(!parsed(&format!(r#"{{ "extensions": {{ "KHR_materials_volume": {volume} }} }}"#)).thin);
        }
    }
}
