//! Features of a glTF file that change the image and are not rendered, in words.

use super::{
    graph::place,
    instance,
    texture::{ANISOTROPY, CLEARCOAT, GLOSSINESS, SHEEN},
};
use crate::text::shown;
use gltf::{Document, Material, Node};
use std::collections::BTreeSet;

/// Extensions that are read, that change no image, or that speak of what has its own warning.
const KNOWN: &[&str] = &[
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "MSFT_texture_dds",
];

/// A material without any shading.
const UNLIT: &str = "KHR_materials_unlit";

/// Of the whole document, of which a time in its animations is shown or none.
pub(super) fn in_document(document: &Document, animated: bool) -> Vec<String> {
    let mut named_elsewhere = BTreeSet::new();
    document
        .materials()
        .for_each(|m| named_elsewhere.extend(m.extensions().into_iter().flat_map(|map| map.keys().cloned())));
    document
        .nodes()
        .for_each(|n| named_elsewhere.extend(n.extensions().into_iter().flat_map(|map| map.keys().cloned())));
    let mut warnings: Vec<_> = document
        .extensions_used()
        .filter(|name| !KNOWN.contains(name) && !named_elsewhere.contains(*name))
        .map(|name| {
            let remedy = match is_environment(name) {
                true => "--environment FILE gives the scene its image",
                false => "if the image lacks it, export without it",
            };
            format!("the extension {} is not supported; what it says is left out: {remedy}", shown(name))
        })
        .collect();
    match (document.animations().len() > 0, animated) {
        (true, false) => warnings
            .push("the file is animated and shown as it stands at rest; --time-in-animation chooses a time".to_owned()),
        (false, true) => warnings.push(
            "the file has no animation that can be read, and is shown at rest; export it with animations, or leave \
             --frames or --time-in-animation out"
                .to_owned(),
        ),
        _ => {}
    }
    warnings
}

/// Whether an extension that is not read is about light from all around.
fn is_environment(name: &str) -> bool {
    ["KHR_environment_map", "KHR_lights_environment", "UX3D_lights_imageBased"].contains(&name)
}

/// Of one node.
pub(super) fn in_node(node: &Node) -> Option<String> {
    let names = node.extensions().into_iter().flat_map(|map| map.keys());
    sentence(&place(node), names.filter(|name| *name != instance::NAME).map(|name| shown(name)).collect())
}

/// Of one material.
pub(super) fn in_material(material: &Material) -> Option<String> {
    let specular = material.specular();
    let glossy = |s: &gltf::material::Specular| s.specular_factor() != 1.0 || s.specular_color_factor() != [1.0; 3];
    let unheard = transmits(material) && specular.as_ref().is_some_and(glossy);
    let features = unheard.then(|| "KHR_materials_specular of what transmits light".to_owned()).into_iter();
    let names = material.extensions().into_iter().flat_map(|map| map.keys());
    let extensions = names
        .filter(|name| ![UNLIT, ANISOTROPY, CLEARCOAT, GLOSSINESS, SHEEN].contains(&name.as_str()))
        .map(|name| shown(name));
    sentence(&place_of(material), features.chain(extensions).collect())
}

/// Whether a material shows its base colour whatever light there is.
pub(super) fn is_unlit(material: &Material) -> bool {
    material.extension_value(UNLIT).is_some()
}

/// Whether a material may give light.
pub(super) fn emits(material: &Material) -> bool {
    material.emissive_factor() != [0.0; 3] || is_unlit(material)
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
    format!("material `{}`", shown(material.name().unwrap_or("without a name")))
}

fn sentence(place: &str, features: Vec<String>) -> Option<String> {
    let remedy = "if the image lacks it, bake it into base colour, roughness or emission";
    (!features.is_empty()).then(|| format!("{place}: not supported and left out: {}; {remedy}", features.join(", ")))
}
