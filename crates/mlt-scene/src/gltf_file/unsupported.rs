//! What a glTF file asks for that changes the image and is not rendered, in words.

use super::graph::place;
use gltf::{Document, Material, Node, Semantic, material::AlphaMode};

/// Extensions that are read, that change no image, or that speak of what has its own warning.
const KNOWN: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_texture_webp",
];

/// Of the whole document.
pub(super) fn in_document(document: &Document) -> Vec<String> {
    let in_materials =
        |name: &str| document.materials().any(|m| m.extensions().is_some_and(|map| map.contains_key(name)));
    let mut warnings: Vec<_> = document
        .extensions_used()
        .filter(|name| !KNOWN.contains(name) && !in_materials(name))
        .map(|name| format!("the extension {name} is not supported; what it says is left out"))
        .collect();
    if document.animations().len() > 0 {
        warnings.push("animations are not supported; the scene is shown as it stands without them".to_owned());
    }
    warnings
}

/// Of one node and its mesh.
pub(super) fn in_node(node: &Node) -> Option<String> {
    let mut features = Vec::new();
    if let Some(light) = node.light() {
        features.push(format!("the point, spot or directional light `{}`", light.name().unwrap_or("without a name")));
    }
    if node.skin().is_some() {
        features.push("the skin".to_owned());
    }
    let primitives = || node.mesh().into_iter().flat_map(|m| m.primitives());
    if primitives().any(|p| p.morph_targets().len() > 0) {
        features.push("morph targets".to_owned());
    }
    if primitives().any(|p| p.get(&Semantic::Colors(0)).is_some()) {
        features.push("vertex colours".to_owned());
    }
    sentence(&place(node), features)
}

/// Of one material.
pub(super) fn in_material(material: &Material) -> Option<String> {
    let pbr = material.pbr_metallic_roughness();
    let (transmission, volume, specular) = (material.transmission(), material.volume(), material.specular());
    let textured = pbr.base_color_texture().is_some();
    let translucent = textured || pbr.base_color_factor()[3] < 1.0;
    let absorbs = |v: &gltf::material::Volume| {
        v.attenuation_distance().is_finite() && v.attenuation_color().iter().any(|&c| c < 1.0)
    };
    let glossy = |s: &gltf::material::Specular| s.specular_factor() != 1.0 || s.specular_color_factor() != [1.0; 3];
    let features = [
        (textured, "baseColorTexture"),
        (pbr.metallic_roughness_texture().is_some(), "metallicRoughnessTexture"),
        (material.normal_texture().is_some(), "normalTexture"),
        (material.emissive_texture().is_some(), "emissiveTexture"),
        (transmission.is_some_and(|t| t.transmission_texture().is_some()), "transmissionTexture"),
        (specular.as_ref().is_some_and(|s| s.specular_texture().is_some()), "specularTexture"),
        (specular.as_ref().is_some_and(|s| s.specular_color_texture().is_some()), "specularColorTexture"),
        (translucent && material.alpha_mode() == AlphaMode::Blend, "alphaMode BLEND"),
        (translucent && material.alpha_mode() == AlphaMode::Mask, "alphaMode MASK"),
        (volume.as_ref().is_some_and(absorbs), "attenuation in the volume"),
        (
            transmits(material) && specular.as_ref().is_some_and(glossy),
            "KHR_materials_specular of what transmits light",
        ),
    ];
    let features = features.iter().filter(|f| f.0).map(|f| f.1.to_owned());
    let extensions = material.extensions().into_iter().flat_map(|map| map.keys().cloned());
    sentence(&place_of(material), features.chain(extensions).collect())
}

/// Of a material whose volume has no thickness.
pub(super) fn in_volume(material: &Material) -> Option<String> {
    let thin = material.volume().is_some_and(|volume| volume.thickness_factor() <= 0.0);
    (transmits(material) && thin).then(|| {
        format!(
            "{}: a volume of thickness 0 is taken for a solid, as one of any other thickness; leave KHR_materials_volume \
             out for a thin wall",
            place_of(material)
        )
    })
}

fn transmits(material: &Material) -> bool {
    material.transmission().is_some_and(|t| t.transmission_factor() > 0.0)
}

fn place_of(material: &Material) -> String {
    format!("material `{}`", material.name().unwrap_or("without a name"))
}

fn sentence(place: &str, features: Vec<String>) -> Option<String> {
    (!features.is_empty()).then(|| format!("{place}: not supported and left out: {}", features.join(", ")))
}
