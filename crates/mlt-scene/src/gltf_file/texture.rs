//! glTF's textures: which image a parameter reads, where and how.

use super::{buffer::Buffers, parse::Parsed};
use crate::{images::Sampler, source::Source};
use glam::{Affine2, Mat2, Vec2};
use gltf::{
    Material,
    json::validation::Checked,
    texture::{MagFilter, WrappingMode},
};
use mlt_core::transport::bsdf::Stretch;
use mlt_core::transport::scene::{Filter, Map, Wrap};
use serde_json::Value;
use std::borrow::Cow;

/// Extensions that name another image for a texture, which is not read.
const UNREAD_FORMATS: [&str; 3] = ["KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"];

/// The extension that moves a texture on its surface.
const TRANSFORM: &str = "KHR_texture_transform";

/// The extension for a clear coat.
pub(super) const CLEARCOAT: &str = "KHR_materials_clearcoat";

/// The extension for velvet.
pub(super) const SHEEN: &str = "KHR_materials_sheen";

/// The extension for brushed metal.
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// The extension for a diffuse and a specular colour, older than metalness.
pub(super) const GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// A material's use of a texture.
#[derive(Clone, Copy)]
pub(super) struct Slot {
    /// Index of the texture in the document.
    pub texture: usize,
    /// Set of texture coordinates.
    pub set: u32,
    pub transform: Affine2,
}

/// A material's textures.
#[derive(Default)]
pub(super) struct Slots {
    pub base_color: Option<Slot>,
    pub metallic_roughness: Option<Slot>,
    pub normal: Option<(Slot, f32)>,
    pub emission: Option<Slot>,
    pub transmission: Option<Slot>,
    pub specular: Option<Slot>,
    pub specular_color: Option<Slot>,
    /// 1 − roughness, in alpha.
    pub glossiness: Option<Slot>,
    pub clearcoat: Option<Slot>,
    pub clearcoat_roughness: Option<Slot>,
    pub clearcoat_normal: Option<(Slot, f32)>,
    pub sheen_color: Option<Slot>,
    pub sheen_roughness: Option<Slot>,
    pub anisotropy: Option<Slot>,
    /// Whether it is brushed, with a texture or without.
    pub brushed: bool,
}

impl Slots {
    /// Of a material.
    pub(super) fn of(material: &Material) -> Self {
        let pbr = material.pbr_metallic_roughness();
        let specular = material.specular();
        let specular = specular.as_ref();
        let normal = material.normal_texture();
        let normal = normal.map(|normal| {
            let transform = normal.extension_value(TRANSFORM).cloned().unwrap_or_default();
            (Slot::new(normal.texture().index(), normal.tex_coord(), &transform), normal.scale())
        });
        let modern = Self {
            base_color: pbr.base_color_texture().map(Slot::typed),
            metallic_roughness: pbr.metallic_roughness_texture().map(Slot::typed),
            normal,
            emission: material.emissive_texture().map(Slot::typed),
            transmission: material.transmission().and_then(|t| t.transmission_texture()).map(Slot::typed),
            specular: specular.and_then(|s| s.specular_texture()).map(Slot::typed),
            specular_color: specular.and_then(|s| s.specular_color_texture()).map(Slot::typed),
            glossiness: None,
            clearcoat: Slot::raw(material, CLEARCOAT, "clearcoatTexture"),
            clearcoat_roughness: Slot::raw(material, CLEARCOAT, "clearcoatRoughnessTexture"),
            clearcoat_normal: Slot::raw(material, CLEARCOAT, "clearcoatNormalTexture")
                .map(|slot| (slot, scale(material.extension_value(CLEARCOAT)))),
            sheen_color: Slot::raw(material, SHEEN, "sheenColorTexture"),
            sheen_roughness: Slot::raw(material, SHEEN, "sheenRoughnessTexture"),
            anisotropy: Slot::raw(material, ANISOTROPY, "anisotropyTexture"),
            brushed: material.extension_value(ANISOTROPY).is_some(),
        };
        if material.extension_value(GLOSSINESS).is_none() {
            return modern;
        }
        let specular = Slot::raw(material, GLOSSINESS, "specularGlossinessTexture");
        Self {
            base_color: Slot::raw(material, GLOSSINESS, "diffuseTexture"),
            metallic_roughness: None,
            specular_color: specular,
            glossiness: specular,
            ..modern
        }
    }

    /// Set of texture coordinates that tangents follow; `None`: no parameter needs them.
    pub(super) fn tangents(&self) -> Option<usize> {
        let normal = self.normal.or(self.clearcoat_normal).map(|(slot, _)| slot);
        let set = self.anisotropy.or(normal).map(|slot| slot.set.min(1) as usize);
        set.or(self.brushed.then_some(0))
    }

    /// Each that is there.
    pub(super) fn iter(&self) -> impl Iterator<Item = Slot> {
        // Without "..": an image that is forgotten here is not decoded.
        let &Self {
            base_color,
            metallic_roughness,
            normal,
            emission,
            transmission,
            specular,
            specular_color,
            glossiness,
            clearcoat,
            clearcoat_roughness,
            clearcoat_normal,
            sheen_color,
            sheen_roughness,
            anisotropy,
            brushed: _,
        } = self;
        let normals = [normal, clearcoat_normal].map(|normal| normal.map(|(slot, _)| slot));
        let base = [base_color, metallic_roughness, emission, transmission, specular, specular_color, glossiness];
        let layers = [clearcoat, clearcoat_roughness, sheen_color, sheen_roughness, anisotropy];
        normals.into_iter().chain(base).chain(layers).flatten()
    }
}

/// Factor on the slopes of the clear coat's normal map.
fn scale(clearcoat: Option<&Value>) -> f32 {
    let scale = clearcoat.and_then(|value| value.get("clearcoatNormalTexture")?.get("scale")?.as_f64());
    scale.map_or(1.0, |scale| scale as f32)
}

impl Slot {
    /// As a parameter of the renderer reads it, by the number of its texture there.
    pub(super) fn map(&self, texture: u32) -> Map {
        Map { texture, set: self.set.min(1) as u8, transform: self.transform }
    }

    fn typed(info: gltf::texture::Info) -> Self {
        let (mut set, mut transform) = (info.tex_coord(), Affine2::IDENTITY);
        if let Some(found) = info.texture_transform() {
            set = found.tex_coord().unwrap_or(set);
            transform = placement(found.offset().into(), found.rotation(), found.scale().into());
        }
        Self { texture: info.texture().index(), set, transform }
    }

    /// Of an extension that the parser does not know.
    fn raw(material: &Material, extension: &str, name: &str) -> Option<Self> {
        let info = material.extension_value(extension)?.get(name)?;
        let index = |key: &str| info.get(key).and_then(Value::as_u64);
        let transform = info.get("extensions").and_then(|extensions| extensions.get(TRANSFORM));
        let set = index("texCoord").map_or(0, set_of);
        Some(Self::new(index("index")? as usize, set, transform.unwrap_or(&Value::Null)))
    }

    /// With the content of [`TRANSFORM`].
    fn new(texture: usize, set: u32, transform: &Value) -> Self {
        let number = |value: &Value| value.as_f64().map(|x| x as f32);
        let pair = |key, default| {
            let value = |i: usize| transform.get(key).and_then(|pair| number(pair.get(i)?)).unwrap_or(default);
            Vec2::new(value(0), value(1))
        };
        let rotation = transform.get("rotation").and_then(number).unwrap_or(0.0);
        let set = transform.get("texCoord").and_then(Value::as_u64).map_or(set, set_of);
        Self { texture, set, transform: placement(pair("offset", 0.0), rotation, pair("scale", 1.0)) }
    }
}

/// The set of coordinates of this number; no mesh has the one of the largest.
fn set_of(number: u64) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// Scales, then turns counter-clockwise as an image is seen, then moves.
fn placement(offset: Vec2, rotation: f32, scale: Vec2) -> Affine2 {
    let (sin, cos) = libm::sincosf(rotation);
    let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    Affine2::from_mat2_translation(turn * Mat2::from_diagonal(scale), offset)
}

/// The images of a document.
pub(super) struct Files<'a> {
    pub source: &'a Source<'a>,
    pub parsed: &'a Parsed,
    pub buffers: &'a Buffers<'a>,
}

impl<'a> Files<'a> {
    /// Meaning of an anisotropy's strength in this file: Blender writes its own number.
    pub(super) fn stretch(&self) -> Stretch {
        let generator = self.parsed.document.as_json().asset.generator.as_deref().unwrap_or_default();
        if generator.contains("Blender") { Stretch::Balanced } else { Stretch::OneSided }
    }

    /// Index of the image of a texture, or why there is none.
    fn image(&self, texture: usize) -> Result<usize, String> {
        let root = self.parsed.document.as_json();
        let texture = root.textures.get(texture).ok_or("the texture does not exist")?;
        let extension = |name: &str| texture.extensions.as_ref()?.others.get(name);
        let webp = extension("EXT_texture_webp").and_then(|value| value.get("source")?.as_u64());
        let image = webp.map_or(texture.source.value(), |image| image as usize);
        match UNREAD_FORMATS.iter().find(|name| extension(name).is_some()) {
            _ if image < root.images.len() => Ok(image),
            Some(name) => Err(format!("{name} is not supported; convert its image to PNG, JPEG or WebP")),
            None => Err("the texture has no image".to_owned()),
        }
    }

    /// The name of a texture's image, for messages and to tell images apart.
    pub(super) fn name(&self, texture: usize) -> String {
        match self.image(texture) {
            Ok(image) => self.name_of_image(image),
            Err(_) => format!("of textures[{texture}]"),
        }
    }

    /// The name of an image.
    pub(super) fn name_of_image(&self, image: usize) -> String {
        let Some(json) = self.parsed.document.as_json().images.get(image) else { return format!("images[{image}]") };
        match (&json.uri, &json.name) {
            (Some(uri), _) if !uri.starts_with("data:") => format!("`{uri}`"),
            (_, Some(name)) if !name.is_empty() => format!("images[{image}] `{name}`"),
            _ => format!("images[{image}]"),
        }
    }

    /// The content of a texture's image, or why there is none.
    pub(super) fn content(&self, texture: usize) -> Result<Cow<'a, [u8]>, String> {
        self.content_of_image(self.image(texture)?)
    }

    /// The content of an image, or why there is none.
    pub(super) fn content_of_image(&self, image: usize) -> Result<Cow<'a, [u8]>, String> {
        let json = self.parsed.document.as_json().images.get(image).ok_or("the image does not exist")?;
        let found = match (&json.uri, json.buffer_view) {
            (Some(uri), _) => self.buffers.read_uri(&format!("images[{image}]"), uri).map(Cow::Owned),
            (None, Some(view)) => self.buffers.view_at(view.value()).map(Cow::Borrowed),
            (None, None) => return Err("it has neither a URI nor a buffer view".to_owned()),
        };
        found.map_err(|error| error.to_string())
    }

    /// How a texture reads its image.
    pub(super) fn sampler(&self, texture: usize) -> Sampler {
        let root = self.parsed.document.as_json();
        let sampler = root.textures.get(texture).and_then(|t| root.samplers.get(t.sampler?.value()));
        let Some(sampler) = sampler else { return Sampler::default() };
        let wrap = [&sampler.wrap_s, &sampler.wrap_t].map(|mode| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            _ => Wrap::Repeat,
        });
        let nearest = matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest)));
        Sampler { wrap, filter: if nearest { Filter::Nearest } else { Filter::Bilinear } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blender's exporter and importer, and three.js, place textures so.
    #[test]
    fn a_texture_is_scaled_turned_and_moved() {
        let quarter = std::f32::consts::FRAC_PI_2;
        let placed = placement(Vec2::new(0.5, 0.25), quarter, Vec2::new(2.0, 3.0));
        let at = |u, v| placed.transform_point2(Vec2::new(u, v));
        assert!(at(0.0, 0.0).distance(Vec2::new(0.5, 0.25)) < 1e-6);
        assert!(at(1.0, 0.0).distance(Vec2::new(0.5, -1.75)) < 1e-6);
        assert!(at(0.0, 1.0).distance(Vec2::new(3.5, 0.25)) < 1e-6);
    }

    #[test]
    fn a_transform_may_be_raw_json() {
        let json = serde_json::from_str(r#"{ "offset": [0.5, 0], "scale": [2, 2], "texCoord": 1 }"#).unwrap();
        let slot = Slot::new(3, 0, &json);
        assert_eq!((slot.texture, slot.set), (3, 1));
        assert_eq!(slot.transform.transform_point2(Vec2::ONE), Vec2::new(2.5, 2.0));
    }
}
