//! Textures of scene files: images of every kind, those that are missing or broken, and what vertices carry for them.

use crate::support::{Document, f32s, load_files};
use image::{DynamicImage, ImageFormat, RgbImage, RgbaImage};
use mlt_core::memory::Memory;
use mlt_core::transport::scene::Material;
use mlt_scene::{Glass, LoadOptions, Loaded, open_within};
use serde_json::json;
use std::io::Cursor;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    image.write_to(&mut file, format).unwrap();
    file.into_inner()
}

fn picture(format: ImageFormat) -> Vec<u8> {
    encoded(&RgbImage::from_fn(8, 8, |x, y| image::Rgb([x as u8 * 30, y as u8 * 30, 99])).into(), format)
}

/// A triangle with texture coordinates and a base colour texture, whose image is `json`.
fn textured(image: serde_json::Value) -> Document {
    Document::new()
        .with_view(&f32s(&[0., 0., 1., 0., 0., 1.]))
        .with("/accessors/-", json!({ "bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC2" }))
        .with("/meshes/0/primitives/0/attributes/TEXCOORD_0", 3.into())
        .with("/images", json!([image]))
        .with("/textures", json!([{ "source": 0 }]))
        .with("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": { "index": 0 } }))
}

fn is_textured(loaded: &Loaded) -> bool {
    loaded.description.materials.iter().any(|m: &Material| m.textured.is_some())
}

#[test]
fn images_of_every_format_are_read_from_wherever_they_are() {
    for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP] {
        let bytes = picture(format);
        let inside = textured(json!({ "bufferView": 4, "mimeType": "image/any" })).with_view(&bytes).loaded();
        assert!(is_textured(&inside) && inside.warnings.is_empty(), "{format:?}: {:?}", inside.warnings);
        let json = textured(json!({ "uri": "my%20wood.png" }));
        let files =
            [("scene.gltf", json.json.to_string().into_bytes()), ("scene.bin", json.bin), ("my wood.png", bytes)];
        let beside = load_files(&files.each_ref().map(|(name, content)| (*name, &content[..]))).unwrap();
        assert!(is_textured(&beside) && beside.warnings.is_empty(), "{format:?}: {:?}", beside.warnings);
        let mesh = &beside.description.meshes[0];
        assert_eq!((mesh.uv[0].len(), mesh.uv[1].len(), beside.description.textures.len()), (3, 0, 1));
    }
}

#[test]
fn an_image_that_is_lost_is_a_warning() {
    let broken = picture(ImageFormat::Png)[..40].to_vec();
    let huge = {
        // A header of 32,000 x 32,000 pixels with nothing behind it.
        let mut png = picture(ImageFormat::Png);
        png[16..24].copy_from_slice(&[0, 0, 0x7d, 0, 0, 0, 0x7d, 0]);
        png
    };
    let wide = {
        let mut png = huge.clone();
        png[16..20].copy_from_slice(&[0x7f, 0, 0, 0]);
        png
    };
    for (what, image, reason) in [
        ("gone", json!({ "uri": "gone.png" }), "cannot be read"),
        ("outside", json!({ "uri": "../x.png" }), "outside of the scene's folder"),
        ("no source", json!({}), "neither a URI nor a buffer view"),
        ("broken", json!({ "bufferView": 4 }), ""),
        ("text", json!({ "uri": "data:,hello" }), "neither PNG, JPEG nor WebP"),
        ("no view", json!({ "bufferView": 99 }), "does not exist"),
        ("ktx2", json!({ "uri": "data:;base64,q0tUWCAyMLs=" }), "KTX2 is not supported"),
    ] {
        let loaded = textured(image).with_view(&broken).loaded();
        assert!(!is_textured(&loaded), "{what}");
        let said = |w: &String| w.starts_with("the image ") && w.contains("is left out: ") && w.contains(reason);
        assert!(loaded.warnings.iter().any(said), "{what}: {:?}", loaded.warnings);
    }
    for bytes in [huge, wide] {
        let loaded = textured(json!({ "bufferView": 4 })).with_view(&bytes).loaded();
        assert!(loaded.warnings.iter().any(|w| w.contains("is left out: ")), "{:?}", loaded.warnings);
    }
    let missing = textured(json!({})).with("/textures", json!([{ "source": 7, "sampler": 9 }])).loaded();
    assert!(missing.warnings.iter().any(|w| w.contains("the texture has no image")), "{:?}", missing.warnings);
}

#[test]
fn pixels_are_part_of_the_memory_that_is_asked_for_first() {
    let folder = tempfile::tempdir().unwrap();
    let large = encoded(&RgbaImage::new(2048, 2048).into(), ImageFormat::Png);
    textured(json!({ "bufferView": 4 })).with_view(&large).write(folder.path());
    let open = |bytes| open_within(folder.path().join("scene.gltf"), &LoadOptions::default(), &Memory::of(bytes));
    let error = open(8 << 20).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("the pixels of 1 image needs 16.0 MiB of memory"), "{error}");
    assert!(open(64 << 20).is_ok());
}

#[test]
fn an_image_is_decoded_once_for_all_textures() {
    let twice = textured(json!({ "uri": "a.png" }))
        .with("/images/-", json!({ "uri": "a.png" }))
        .with("/textures/-", json!({ "source": 1 }))
        .with("/materials/0/emissiveFactor", json!([1, 1, 1]))
        .with("/materials/0/emissiveTexture", json!({ "index": 1 }))
        .with("/materials/0/normalTexture", json!({ "index": 1, "scale": 0.5 }));
    let bytes = picture(ImageFormat::Png);
    let files = [("scene.gltf", twice.json.to_string().into_bytes()), ("scene.bin", twice.bin), ("a.png", bytes)];
    let loaded = load_files(&files.each_ref().map(|(name, content)| (*name, &content[..]))).unwrap();
    // One for the two colours, one for the normals.
    assert_eq!((loaded.description.textures.len(), loaded.warnings.len()), (2, 0), "{:?}", loaded.warnings);
}

#[test]
fn an_emission_whose_image_is_lost_is_dark() {
    let loaded = textured(json!({}))
        .with("/materials/0/emissiveFactor", json!([1, 1, 1]))
        .with("/materials/0/emissiveTexture", json!({ "index": 0 }))
        .loaded();
    assert_eq!(loaded.description.materials[0].emission, glam::Vec3::ZERO);
}

#[test]
fn occlusion_is_named_once() {
    let loaded = textured(json!({}))
        .with("/materials/0/occlusionTexture", json!({ "index": 0 }))
        .with("/materials/-", json!({ "occlusionTexture": { "index": 0 } }))
        .loaded();
    assert_eq!(loaded.warnings.iter().filter(|w| w.contains("occlusion")).count(), 1, "{:?}", loaded.warnings);
}

#[test]
fn vertex_colours_arrive_as_numbers_of_any_kind() {
    for (kind, normalized, bytes, components) in [
        (5126, false, f32s(&[0.2, 0.4, 0.6, 0.2, 0.4, 0.6, 0.2, 0.4, 0.6]), "VEC3"),
        (5121, true, [51, 102, 153, 255].repeat(3), "VEC4"),
    ] {
        let accessor =
            json!({ "bufferView": 3, "componentType": kind, "normalized": normalized, "count": 3, "type": components });
        let loaded = Document::new()
            .with_view(&bytes)
            .with("/accessors/-", accessor)
            .with("/meshes/0/primitives/0/attributes/COLOR_0", 3.into())
            .loaded();
        let colour = loaded.description.meshes[0].colours[1];
        assert!(colour.distance(glam::Vec4::new(0.2, 0.4, 0.6, 1.0)) < 1e-6, "{colour}");
        assert!(is_textured(&loaded) && loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";

fn obj(mtl: &str, files: &[(&str, &[u8])]) -> Loaded {
    let mut all: Vec<(&str, &[u8])> = vec![("scene.obj", OBJ.as_bytes()), ("m.mtl", mtl.as_bytes())];
    all.extend(files);
    load_files(&all).unwrap()
}

#[test]
fn mtl_names_textures_as_programs_write_them() {
    let png = &picture(ImageFormat::Png)[..];
    for mtl in [
        "map_Kd a b.png",
        "map_kd -s 2 2 2 -o 0 .5 a b.png",
        "map_Kd C:\\pictures\\a b.png",
        "map_Kd /home/someone/a b.png",
        "map_Kd \"a b.png\"",
        "MAP_KD -clamp on -blendu off -mm 0 1 a b.png",
    ] {
        let loaded = obj(&format!("newmtl m\n{mtl}\n"), &[("a b.png", png)]);
        assert!(loaded.warnings.is_empty() && is_textured(&loaded), "{mtl}: {:?}", loaded.warnings);
        let mesh = &loaded.description.meshes[0];
        // v grows upwards in OBJ and downwards in images.
        assert_eq!(mesh.uv[0][0].y, 1.0);
    }
    let all = "map_Kd a.png\nmap_Ks a.png\nmap_Ns a.png\nmap_d a.png\nmap_Ke a.png\nbump -bm .5 a.png\nNs 99\n";
    let loaded = obj(&format!("newmtl m\n{all}"), &[("a.png", png)]);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    // The image as a colour and as numbers, its roughness and its normals.
    assert_eq!(loaded.description.textures.len(), 4);
    let pbr = obj("newmtl m\nmap_Pr a.png\nmap_Pm a.png\nnorm a.png\ndisp a.png\nmap_Ka a.png\n", &[("a.png", png)]);
    assert_eq!(pbr.warnings, ["material `m`: not supported and left out: disp"]);
}

#[test]
fn a_texture_that_mtl_names_and_is_not_there_is_a_warning() {
    let loaded = obj("newmtl m\nKd .5 .5 .5\nmap_Kd gone.png\nmap_Ke gone.png\n", &[]);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert!(loaded.warnings[0].contains("the image `gone.png` is left out: "), "{:?}", loaded.warnings);
    assert_eq!(loaded.description.materials[0].emission, glam::Vec3::ZERO);
}

#[test]
fn coordinates_that_are_not_there_cost_no_more_than_themselves() {
    let faces = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0\nvt x y\nusemtl m\nf 1/1 2/2 3/9\n";
    let png = &picture(ImageFormat::Png)[..];
    let files: [(&str, &[u8]); 3] =
        [("scene.obj", faces.as_bytes()), ("m.mtl", b"newmtl m\nmap_Kd a.png\n"), ("a.png", png)];
    let loaded = load_files(&files).unwrap();
    assert_eq!(loaded.description.meshes[0].positions.len(), 3);
    assert_eq!(loaded.warnings, ["faces name texture coordinates that are not there; all are left out"]);
}

#[test]
fn colours_of_obj_vertices_are_those_of_a_display() {
    let coloured = "v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0 1 0.5 0\n";
    let loaded = load_files(&[("scene.obj", format!("{coloured}f 1 2 3\n").as_bytes())]).unwrap();
    assert!(loaded.description.meshes[0].colours[0].distance(glam::Vec4::new(1.0, 0.214_041, 0.0, 1.0)) < 1e-5);
    assert!(is_textured(&loaded) && loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let some = load_files(&[("scene.obj", format!("{coloured}v 1 1 0\nf 1 2 4\n").as_bytes())]).unwrap();
    assert!(some.description.meshes[0].colours.is_empty() && some.warnings.len() == 1, "{:?}", some.warnings);
}

/// Two materials that differ in nothing but their walls' thickness: a closed one and an open one.
#[test]
fn glass_is_solid_where_its_mesh_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let glass = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
    let open = Document::new()
        .with("/materials/0/extensions", glass)
        .with("/materials/0/pbrMetallicRoughness", json!({ "metallicFactor": 0, "roughnessFactor": 0 }));
    open.write(folder.path());
    let load = |glass| {
        let options = LoadOptions { glass, ..LoadOptions::default() };
        let loaded = open_within(folder.path().join("scene.gltf"), &options, &Memory::unlimited()).unwrap();
        let scene = &loaded.description;
        format!("{:?}", scene.materials[scene.meshes[0].material as usize].bsdf)
    };
    let found = [Glass::Auto, Glass::Thin, Glass::Solid].map(load);
    assert!(
        found[0].starts_with("Thin") && found[1].starts_with("Thin") && found[2].starts_with("Dielectric"),
        "{found:?}"
    );
}

/// Brushed metal is textured by its tangent alone; a smooth mesh without tangents gets some.
#[test]
fn a_brushed_mesh_has_tangents() {
    let coordinates = |document: Document| {
        document
            .with_view(&f32s(&[0., 0., 1., 0., 0., 1.]))
            .with("/accessors/-", json!({ "bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC2" }))
            .with("/meshes/0/primitives/0/attributes/TEXCOORD_0", 3.into())
    };
    let brushed = json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.5, "anisotropyRotation": 1.0 } });
    let loaded = coordinates(Document::new()).with("/materials/0/extensions", brushed).loaded();
    assert!(is_textured(&loaded) && loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let tangents = &loaded.description.meshes[0].tangents;
    assert_eq!(tangents.len(), 3);
    assert!(tangents.iter().all(|t| (t.x - 1.0).abs() < 1e-5 && t.w == -1.0), "{tangents:?}");
    let plain = coordinates(Document::new()).loaded();
    assert!(!is_textured(&plain) && plain.description.meshes[0].tangents.is_empty());
}

/// Six images as the light of a scene; and what is told where they are not there.
#[test]
fn a_file_brings_its_environment() {
    let face =
        |i: u8| encoded(&RgbaImage::from_pixel(2, 2, image::Rgba([40 * i, 0, 255, 128])).into(), ImageFormat::Png);
    let mut document = (1..7).fold(Document::new(), |document, i| document.with_view(&face(i)));
    let images: Vec<_> = (3..9).map(|view| json!({ "bufferView": view, "mimeType": "image/png" })).collect();
    let light = json!({ "intensity": 0.5, "specularImageSize": 2, "specularImages": [[0, 1, 2, 3, 4, 5]] });
    document = document
        .with("/images", json!(images))
        .with("/extensionsUsed", json!(["EXT_lights_image_based"]))
        .with("/extensions", json!({ "EXT_lights_image_based": { "lights": [light] } }))
        .with("/scenes/0/extensions", json!({ "EXT_lights_image_based": { "light": 0 } }));
    let loaded = document.loaded();
    let environment = loaded.description.environment.expect("an environment");
    assert!(!loaded.neutral_sky && loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!((environment.size(), environment.strength), ([8, 4], 0.5));
    let dark = document.with("/extensions/EXT_lights_image_based/lights/0/specularImages", json!([])).loaded();
    assert!(dark.neutral_sky && dark.warnings[0].contains("--environment FILE"), "{:?}", dark.warnings);
}
