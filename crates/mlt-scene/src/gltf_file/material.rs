//! glTF's materials.

use super::{
    texture::{ANISOTROPY, CLEARCOAT, Files, GLOSSINESS, SHEEN, Slot, Slots},
    unsupported,
};
use crate::{SceneError, images::Images, range::Range, text::shown};
use gltf::{Document, material::AlphaMode};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Anisotropy, MetallicRoughness};
use mlt_core::transport::scene::{Alpha, ChannelMap, Encoding, Map, Maps, Material, NormalMap, Pixels, Texture};
use serde_json::Value;
use std::collections::BTreeMap;

/// How the meshes that a scene shows use its materials: the material's index, one behind the last for glTF's default one, and
/// whether one of the meshes has vertex colours.
pub(super) type Used = BTreeMap<usize, bool>;

/// Every material of the document, and glTF's default one behind them if it is used, with the textures of those that are used;
/// only these give warnings.
pub(super) fn materials(
    files: &Files,
    used: &Used,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let document = &files.parsed.document;
    let mut images = decode(files, used, warnings)?;
    let mut materials = Vec::new();
    for (index, source) in document.materials().enumerate() {
        let mut unheard = Vec::new();
        let heard = if used.contains_key(&index) { &mut *warnings } else { &mut unheard };
        heard.extend(unsupported::in_material(&source));
        heard.extend(unsupported::in_volume(&source));
        let mut converter = Converter { files, images: &mut images, coloured: used.get(&index) == Some(&true) };
        materials.push(converter.material(index, &source, heard));
    }
    if let Some(&coloured) = used.get(&materials.len()) {
        let maps = Maps { vertex_colours: coloured, ..Maps::default() };
        let plain = Material { name: "default".to_owned(), ..Material::default() };
        materials.push(plain.scattering(MetallicRoughness::default(), maps, Alpha::Opaque));
    }
    Ok((materials, images.into_textures()))
}

/// The images of the materials in use.
fn decode(files: &Files, used: &Used, warnings: &mut Vec<String>) -> Result<Images, SceneError> {
    let document = &files.parsed.document;
    let mut contents = BTreeMap::new();
    for material in document.materials().filter(|m| m.index().is_some_and(|i| used.contains_key(&i))) {
        for slot in Slots::of(&material).iter() {
            contents.entry(files.name(slot.texture)).or_insert_with(|| files.content(slot.texture));
        }
    }
    if has_occlusion(document, used) {
        warnings.push("occlusion textures are ignored: light itself finds what is occluded".to_owned());
    }
    Images::decode(files.source, contents, warnings)
}

fn has_occlusion(document: &Document, used: &Used) -> bool {
    let shown = |m: &gltf::Material| m.index().is_some_and(|i| used.contains_key(&i));
    document.materials().filter(shown).any(|m| m.occlusion_texture().is_some())
}

/// Converts one material.
struct Converter<'a> {
    files: &'a Files<'a>,
    images: &'a mut Images,
    /// A mesh of it has vertex colours.
    coloured: bool,
}

impl Converter<'_> {
    fn material(&mut self, index: usize, source: &gltf::Material, warnings: &mut Vec<String>) -> Material {
        let name = source.name().map_or_else(|| format!("material {index}"), shown);
        let mut range = Range { material: &name, warnings };
        let strength = source.emissive_strength().unwrap_or(1.0);
        let emission = range.colour("the emission", strength * Rgb::from_array(source.emissive_factor()), 1e12);
        let mut factors = parameters(source, &mut range);
        factors.anisotropy.stretch = self.files.stretch();
        if let Some(value) = source.extension_value(GLOSSINESS) {
            factors = glossy(value, factors, &mut range);
        }
        let slots = Slots::of(source);
        let mut maps = self.maps(&slots);
        if let Some(roughness) = self.roughness(&slots, 1.0 - factors.roughness) {
            maps.roughness = Some(roughness);
            factors.roughness = 1.0;
        }
        let (opacity, alpha) = opacity(source, &mut maps);
        // The factor of an image that is lost says nothing: it is white as a rule.
        let is_dark = slots.emission.is_some() && maps.emission.is_none();
        let mut emission = if is_dark { Rgb::ZERO } else { emission };
        if unsupported::is_unlit(source) {
            emission = factors.base_color;
            factors = MetallicRoughness { base_color: Rgb::ZERO, metallic: 0.0, specular: 0.0, ..factors };
            maps = Maps { emission: maps.base_color, opacity: maps.opacity, ..unlit(self.coloured) };
        }
        let emits_both_sides = source.double_sided();
        let absorption = absorption(source);
        Material { name, emission, emits_both_sides, opacity, absorption, ..Material::default() }
            .scattering(factors, maps, alpha)
    }

    fn map(&mut self, slot: Option<Slot>, encoding: Encoding) -> Option<Map> {
        let slot = slot?;
        let (name, sampler) = (self.files.name(slot.texture), self.files.sampler(slot.texture));
        let texture = self.images.texture(&name, sampler, encoding)?;
        Some(slot.map(texture))
    }

    fn channel(&mut self, slot: Option<Slot>, channel: u8) -> Option<ChannelMap> {
        self.map(slot, Encoding::Linear).map(|map| ChannelMap { map, channel })
    }

    /// Roughness of a glossiness with this factor.
    fn roughness(&mut self, slots: &Slots, factor: f32) -> Option<ChannelMap> {
        let slot = slots.glossiness?;
        let rough = |[.., gloss]: [u8; 4]| (255.0 - factor * f32::from(gloss)).round() as u8;
        let name =
            self.images.derived(&self.files.name(slot.texture), &format!("roughness by {factor}"), |pixels| {
                Pixels::new(pixels.size().into(), 1, pixels.iter().map(rough).collect())
            })?;
        let texture = self.images.texture(&name, self.files.sampler(slot.texture), Encoding::Linear)?;
        Some(ChannelMap { map: slot.map(texture), channel: 0 })
    }

    /// All but that of the opacity.
    fn maps(&mut self, slots: &Slots) -> Maps {
        Maps {
            base_color: self.map(slots.base_color, Encoding::Srgb),
            metallic: self.channel(slots.metallic_roughness, 2),
            roughness: self.channel(slots.metallic_roughness, 1),
            transmission: self.channel(slots.transmission, 0),
            specular: self.channel(slots.specular, 3),
            specular_color: self.map(slots.specular_color, Encoding::Srgb),
            emission: self.map(slots.emission, Encoding::Srgb),
            normal: self.normal(slots.normal),
            clearcoat: self.channel(slots.clearcoat, 0),
            clearcoat_roughness: self.channel(slots.clearcoat_roughness, 1),
            clearcoat_normal: self.normal(slots.clearcoat_normal),
            sheen_color: self.map(slots.sheen_color, Encoding::Srgb),
            sheen_roughness: self.channel(slots.sheen_roughness, 3),
            anisotropy: self.map(slots.anisotropy, Encoding::Linear),
            vertex_colours: self.coloured,
            ..Maps::default()
        }
    }

    fn normal(&mut self, slot: Option<(Slot, f32)>) -> Option<NormalMap> {
        let (slot, scale) = slot?;
        self.map(Some(slot), Encoding::Linear).map(|map| NormalMap { map, scale })
    }
}

/// The opacity, and how it varies: the texture's alpha has its map added.
fn opacity(source: &gltf::Material, maps: &mut Maps) -> (f32, Alpha) {
    let [.., factor] = base_color(source);
    let alpha = match source.alpha_mode() {
        AlphaMode::Opaque => return (1.0, Alpha::Opaque),
        AlphaMode::Mask => Alpha::Mask(source.alpha_cutoff().unwrap_or(0.5)),
        AlphaMode::Blend => Alpha::Blend,
    };
    // Alpha is linear in either encoding: one texture serves both.
    maps.opacity = maps.base_color.map(|map| ChannelMap { map, channel: 3 });
    if maps.opacity.is_some() || maps.vertex_colours {
        return (factor.clamp(0.0, 1.0), alpha);
    }
    let opacity = match alpha {
        Alpha::Mask(least) => f32::from(u8::from(factor >= least)),
        _ => factor.clamp(0.0, 1.0),
    };
    (opacity, Alpha::Opaque)
}

/// Maps of a surface that shows its colour whatever light there is: it emits it, and reflects nothing.
fn unlit(coloured: bool) -> Maps {
    Maps { vertex_colours: coloured, emissive_vertices: coloured, ..Maps::default() }
}

/// A surface with KHR_materials_volume bounds a solid, whatever thickness its author gave for rasterisers;
/// [`unsupported`](super::unsupported) says so of a thickness of 0.
fn parameters(source: &gltf::Material, range: &mut Range) -> MetallicRoughness {
    const SHARE: [f32; 2] = [0.0, 1.0];
    let pbr = source.pbr_metallic_roughness();
    let [r, g, b, _] = base_color(source);
    let specular = source.specular();
    let specular_color = specular.as_ref().map_or([1.0; 3], |s| s.specular_color_factor());
    let transmission = source.transmission().map_or(0.0, |t| t.transmission_factor());
    let factor = |extension: &str, name: &str| {
        let value = source.extension_value(extension).and_then(|value| value.get(name)?.as_f64());
        value.map_or(0.0, |x| x as f32)
    };
    MetallicRoughness {
        base_color: range.colour("the base colour", Rgb::new(r, g, b), 1.0),
        metallic: range.number("the metallic factor", pbr.metallic_factor(), SHARE),
        roughness: range.number("the roughness", pbr.roughness_factor(), SHARE),
        ior: range.number("the index of refraction", source.ior().unwrap_or(1.5), [0.0, 100.0]),
        specular: range.number("the specular factor", specular.map_or(1.0, |s| s.specular_factor()), SHARE),
        specular_color: range.colour("the specular colour", Rgb::from_array(specular_color), 1e6),
        transmission: range.number("the transmission", transmission, SHARE),
        thin: source.volume().is_none(),
        clearcoat: range.number("the clearcoat factor", factor(CLEARCOAT, "clearcoatFactor"), SHARE),
        clearcoat_roughness: range.number(
            "the clearcoat's roughness",
            factor(CLEARCOAT, "clearcoatRoughnessFactor"),
            SHARE,
        ),
        sheen_color: range.colour("the sheen's colour", colour(source, SHEEN, "sheenColorFactor"), 1.0),
        sheen_roughness: range.number("the sheen's roughness", factor(SHEEN, "sheenRoughnessFactor"), SHARE),
        anisotropy: Anisotropy {
            strength: range.number("the anisotropy", factor(ANISOTROPY, "anisotropyStrength"), SHARE),
            rotation: factor(ANISOTROPY, "anisotropyRotation"),
            ..Anisotropy::default()
        },
    }
}

/// The base colour with its alpha.
fn base_color(source: &gltf::Material) -> [f32; 4] {
    let Some(value) = source.extension_value(GLOSSINESS) else {
        return source.pbr_metallic_roughness().base_color_factor();
    };
    let channel = |i: usize| value.get("diffuseFactor").and_then(|factor| factor.get(i)?.as_f64());
    std::array::from_fn(|i| channel(i).map_or(1.0, |x| x as f32))
}

/// Factors of [`GLOSSINESS`] in the place of glTF's own: a dielectric that reflects specularFactor along its normal.
fn glossy(value: &Value, modern: MetallicRoughness, range: &mut Range) -> MetallicRoughness {
    /// Reflectance along the normal of index 1.5.
    const F0: f32 = 0.04;
    let number = |value: Option<&Value>| value.and_then(Value::as_f64).map_or(1.0, |x| x as f32);
    let specular = |i: usize| number(value.get("specularFactor").and_then(|factor| factor.get(i)));
    let specular = Rgb::new(specular(0), specular(1), specular(2));
    MetallicRoughness {
        metallic: 0.0,
        roughness: 1.0 - range.number("the glossiness", number(value.get("glossinessFactor")), [0.0, 1.0]),
        ior: 1.5,
        specular: 1.0,
        specular_color: range.colour("the specular colour", specular, 1.0) / F0,
        ..modern
    }
}

/// A colour of an extension that the parser does not know; black if it is not there.
fn colour(source: &gltf::Material, extension: &str, name: &str) -> Rgb {
    let value = source.extension_value(extension).and_then(|value| value.get(name));
    let channel = |i: usize| value.and_then(|value| value.get(i)?.as_f64()).map_or(0.0, |x| x as f32);
    Rgb::new(channel(0), channel(1), channel(2))
}

/// σ of KHR_materials_volume: of what goes as far as attenuationDistance, attenuationColor is left.
fn absorption(source: &gltf::Material) -> Rgb {
    /// Least share that is left of a channel, so that σ is finite.
    const LEAST: f32 = 1e-6;
    let transmits = source.transmission().is_some_and(|t| t.transmission_factor() > 0.0);
    let Some(volume) = source.volume().filter(|_| transmits) else { return Rgb::ZERO };
    let distance = volume.attenuation_distance();
    let sigma = |left: f32| -libm::logf(left.clamp(LEAST, 1.0)) / distance;
    let is_clear = !(distance > 0.0 && distance.is_finite());
    if is_clear { Rgb::ZERO } else { Rgb::from_array(volume.attenuation_color().map(sigma)) }
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
            ..MetallicRoughness::default()
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
