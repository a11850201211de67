//! glTF files of every kind: what loads, what warns, what is refused.

use crate::support::{Document, f32s, load_files};
use glam::{DVec3, Vec3};
use mlt_core::memory::Memory;
use mlt_core::transport::bsdf::Bsdf;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{Lens, Punctual};
use mlt_scene::{LightUnits, LoadOptions};
use serde_json::{Value, json};

fn geometric_normal(mesh: &Mesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.positions[i as usize]);
    (b - a).cross(c - a).normalize()
}

fn only_mesh(document: &Document) -> Mesh {
    let loaded = document.loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.description.meshes[0].clone()
}

fn warning(document: &Document, needle: &str) {
    let warnings = document.loaded().warnings;
    assert_eq!(warnings.iter().filter(|w| w.contains(needle)).count(), 1, "{needle:?} in {warnings:?}");
}

#[test]
fn text_binary_and_data_uri_say_the_same() {
    let document = Document::new();
    let text = format!("{:?}", document.loaded().description);
    let glb = load_files(&[("scene.glb", &document.glb())]).unwrap();
    assert_eq!(text, format!("{:?}", glb.description));

    let base64 = |bytes: &[u8]| {
        const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let mut text = String::new();
        for group in bytes.chunks(3) {
            let bits = (0..3).fold(0, |v, k| v << 8 | u32::from(*group.get(k).unwrap_or(&0)));
            (0..=group.len()).for_each(|k| text.push(DIGITS[(bits >> (18 - 6 * k) & 63) as usize] as char));
        }
        text + ["", "==", "="][bytes.len() % 3]
    };
    let percent: String = document.bin.iter().map(|b| format!("%{b:02x}")).collect();
    let encoded = base64(&document.bin);
    for uri in [
        format!("data:application/octet-stream;base64,{encoded}"),
        format!("data:;base64,{}", encoded.trim_end_matches('=')),
        format!("DATA:application/octet-stream;Base64,{encoded}"),
        format!("data:application/octet-stream;charset=utf-8; base64, {}\r\n\t{}\n", &encoded[..30], &encoded[30..]),
        format!("data:application/gltf-buffer,{percent}"),
    ] {
        let loaded = document.clone().with("/buffers/0/uri", uri.into()).loaded();
        assert_eq!(text, format!("{:?}", loaded.description));
    }
}

#[test]
fn file_names_are_percent_decoded_or_taken_as_they_are_and_may_lie_in_a_sub_folder() {
    for (uri, name) in [
        ("./parts/my%20part.bin", "my part.bin"),
        ("parts/my part.bin", "my part.bin"),
        ("parts/my%20part.bin", "my%20part.bin"),
        ("parts/100%.bin", "100%.bin"),
    ] {
        let folder = tempfile::TempDir::new().unwrap();
        Document::new().with("/buffers/0/uri", uri.into()).write(folder.path());
        std::fs::create_dir(folder.path().join("parts")).unwrap();
        std::fs::rename(folder.path().join("scene.bin"), folder.path().join("parts").join(name)).unwrap();
        mlt_scene::load(&folder.path().join("scene.gltf")).unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
}

#[test]
fn a_container_may_be_padded_with_nuls_and_hold_chunks_of_other_kinds() {
    let document = Document::new();
    let text = format!("{:?}", document.loaded().description);
    let glb = document.glb();
    let json_length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let (head, binary) = glb.split_at(20 + json_length);
    let mut padded = [head, &[0; 8], binary].concat();
    padded[12..16].copy_from_slice(&(json_length as u32 + 8).to_le_bytes());
    let other = [head, b"\x04\0\0\0OTHR1234", binary, b"\0\0\0\0MORE"].concat();
    for mut glb in [padded, other] {
        let length = glb.len() as u32;
        glb[8..12].copy_from_slice(&length.to_le_bytes());
        assert_eq!(text, format!("{:?}", load_files(&[("scene.glb", &glb)]).unwrap().description));
    }
    let error = load_files(&[("scene.glb", &glb[..glb.len() - 4])]).unwrap_err().to_string();
    assert!(error.contains("a chunk of 80 bytes is announced and 76 are there"), "{error}");
}

#[test]
fn only_what_is_used_is_read() {
    let nothing = json!({ "byteLength": 4 });
    let missing = json!({ "byteLength": 4, "uri": "missing.bin" });
    let image = json!({ "uri": "missing.png" });
    let unused = Document::new()
        .with("/buffers/-", nothing)
        .with("/buffers/-", missing)
        .with("/bufferViews/-", json!({ "buffer": 2, "byteLength": 4 }))
        .with("/accessors/-", json!({ "bufferView": 3, "componentType": 5130, "count": 4, "type": "SCALAR" }))
        .with("/images", json!([image]));
    only_mesh(&unused);
    assert!(unused.with("/accessors/0/bufferView", 3.into()).error().contains("missing.bin"));
}

#[test]
fn unknown_parts_that_are_not_needed_do_no_harm() {
    let reference = only_mesh(&Document::new());
    let pointer = json!({ "channels": [{ "sampler": 0, "target": { "path": "pointer" } }],
                          "samplers": [{ "input": 0, "output": 0 }] });
    for (feature, document) in [
        ("animated", Document::new().with("/animations", json!([pointer]))),
        ("its skin has joints", Document::new().with("/skins", json!([{}])).with("/nodes/0/skin", 0.into())),
        (
            "KHR_texture_basisu is not supported; convert its image",
            Document::new()
                .with("/textures", json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]))
                .with("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": { "index": 0 } })),
        ),
    ] {
        warning(&document, feature);
        assert_eq!(document.loaded().description.meshes[0].positions, reference.positions);
    }
    let silent = Document::new()
        .with("/meshes/0/primitives/0/attributes/KHR_gaussian_splatting:SCALE", 0.into())
        .with("/accessors/0/count", 3.0.into())
        .with("/nodes/0/mesh", 0.0.into())
        .with("/scenes/-", json!({ "name": "nothing in it" }))
        .with("/samplers", json!([{ "wrapS": 1 }]))
        .with("/extensionsRequired", json!(["KHR_draco_mesh_compression_of_another_name"]));
    assert_eq!(only_mesh(&silent).positions, reference.positions);
}

#[test]
fn compressed_meshes_are_refused_where_they_have_no_other_data() {
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 2, "attributes": { "POSITION": 0 } } });
    let with_data = Document::new()
        .with("/extensionsUsed", json!(["KHR_draco_mesh_compression"]))
        .with("/meshes/0/primitives/0/extensions", draco);
    only_mesh(&with_data);
    let mut alone = with_data;
    alone.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let error = alone.error();
    assert!(error.contains("compressed by KHR_draco_mesh_compression") && error.contains("without compression"));

    let meshopt = json!({ "byteLength": 80, "extensions": { "EXT_meshopt_compression": { "fallback": true } } });
    let error = Document::new().with("/buffers/0", meshopt).error();
    assert!(error.contains("compressed by EXT_meshopt_compression"), "{error}");
}

#[test]
fn cameras_outside_the_scene_stand_behind_those_in_it() {
    let names = |document: &Document| -> Vec<_> {
        document.loaded().description.cameras.into_iter().map(|camera| camera.name).collect()
    };
    let with_another = Document::new()
        .with("/nodes/-", json!({ "name": "rig", "children": [3], "translation": [1, 0, 0] }))
        .with("/nodes/-", json!({ "name": "other", "camera": 0, "translation": [0, 2, 0] }));
    assert_eq!(names(&with_another), ["eye", "other"]);
    assert!(with_another.loaded().warnings.is_empty());
    let outside = with_another.with("/scenes/0/nodes", json!([0]));
    assert_eq!(names(&outside), ["eye", "other"]);
    warning(&outside, "no camera; `eye`, which stands outside of it, is taken");
    assert_eq!(outside.loaded().description.cameras[1].position, DVec3::new(1.0, 2.0, 0.0));
}

#[test]
fn every_index_type_and_none_give_the_same_triangle() {
    let reference = only_mesh(&Document::new());
    assert_eq!(reference.triangles, [[0, 1, 2]]);
    assert_eq!(reference.normals, [Vec3::Z; 3], "normals are made unit");
    for (component, bytes) in [(5121, vec![0, 1, 2]), (5125, vec![0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0])] {
        let document = Document::new().with_view(&bytes).with("/accessors/2/bufferView", 3.into());
        let mesh = only_mesh(&document.with("/accessors/2/componentType", component.into()));
        assert_eq!(mesh.positions, reference.positions);
    }
    let mut document = Document::new();
    document.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    assert_eq!(only_mesh(&document).positions, reference.positions);
}

#[test]
fn strips_and_fans_keep_the_front() {
    let strip = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];
    let fan = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    for (mode, corners) in [(5, strip), (6, fan)] {
        let document = Document::new()
            .with_view(&f32s(&corners))
            .with("/accessors/0/bufferView", 3.into())
            .with("/accessors/0/count", 4.into())
            .with("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "mode": mode }));
        let mesh = only_mesh(&document);
        assert_eq!(mesh.triangles.len(), 2);
        assert!((0..2).all(|t| geometric_normal(&mesh, t) == DVec3::Z));
        assert!(mesh.normals.is_empty());
    }
    for mode in 0..4 {
        warning(&Document::new().with("/meshes/0/primitives/0/mode", mode.into()), "points and lines");
    }
}

#[test]
fn transforms_move_points_and_normals_and_mirroring_keeps_the_front() {
    let nested = Document::new()
        .with("/scenes/0/nodes", json!([1, 2]))
        .with("/nodes/-", json!({ "children": [0], "translation": [10, 0, 0], "rotation": [0, 0.5, 0, 0.5] }))
        .with("/nodes/0/scale", json!([2, 3, -4]));
    let mesh = only_mesh(&nested);
    // Mirrored in z and turned by 90° about y: the front, +z, becomes -z and then -x.
    assert!(geometric_normal(&mesh, 0).distance(DVec3::NEG_X) < 1e-6);
    assert!(mesh.normals.iter().all(|n| n.distance(Vec3::NEG_X) < 1e-6));
    assert!(mesh.positions.iter().any(|p| p.distance(DVec3::new(10.0, 0.0, -2.0)) < 1e-5));

    let sheared = [1., 0., 0.5, 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let mesh = only_mesh(&Document::new().with("/nodes/0/matrix", json!(sheared)));
    let normal = geometric_normal(&mesh, 0);
    assert!(mesh.normals.iter().all(|n| n.as_dvec3().distance(normal) < 1e-6), "normals map by the inverse transpose");
}

#[test]
fn sparse_and_quantised_positions_are_read() {
    let sparse = Document::new().with_view(&[2, 0]).with_view(&f32s(&[0., 5., 0.])).with(
        "/accessors/0/sparse",
        json!({ "count": 1, "indices": { "bufferView": 3, "componentType": 5123 }, "values": { "bufferView": 4 } }),
    );
    assert_eq!(only_mesh(&sparse).positions[2], DVec3::new(0.0, 5.0, 0.0));
    let error = sparse.clone().with("/accessors/0/sparse/indices/byteOffset", 40.into()).error();
    assert!(error.contains("accessors[0]"), "{error}");
    let mut out_of_range = sparse;
    out_of_range.bin[80] = 3;
    assert!(out_of_range.error().contains("sparse index"));

    let quantised = Document::new()
        .with_view(&[0, 0, 0, 0, 127, 0, 0, 0, 0, 129, 0, 0])
        .with("/bufferViews/3/byteStride", 4.into())
        .with(
            "/accessors/0",
            json!({ "bufferView": 3, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3" }),
        )
        .with("/extensionsRequired", json!(["KHR_mesh_quantization"]));
    assert_eq!(only_mesh(&quantised).positions[2], DVec3::NEG_Y);
}

#[test]
fn cameras_stand_where_their_nodes_stand() {
    let turned = json!({ "name": "eye", "camera": 0, "translation": [1, 2, 3], "scale": [2, 2, 2],
                         "rotation": [0, 1, 0, 0] });
    let loaded =
        Document::new().with("/nodes/1", turned).with("/cameras/0/perspective/aspectRatio", 1.5.into()).loaded();
    let camera = &loaded.description.cameras[0];
    assert_eq!(camera.position, DVec3::new(1.0, 2.0, 3.0));
    assert!(camera.forward.distance(Vec3::Z) < 1e-6 && camera.up.distance(Vec3::Y) < 1e-6);
    assert_eq!((camera.lens.vertical_fov(), camera.aspect_ratio, camera.name.as_str()), (Some(1.0), Some(1.5), "eye"));

    let orthographic =
        json!({ "type": "orthographic", "orthographic": { "xmag": 3, "ymag": -2, "znear": 0, "zfar": 9 } });
    let loaded = Document::new().with("/cameras/0", orthographic.clone()).loaded();
    let camera = &loaded.description.cameras[0];
    assert_eq!((camera.lens, camera.aspect_ratio), (Lens::Orthographic { height: 4.0 }, Some(1.5)));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    warning(&Document::new().with("/cameras/0", orthographic).with("/cameras/0/orthographic/ymag", 0.into()), "size");
    warning(&Document::new().with("/cameras/0/perspective/yfov", 4.0.into()), "field of view");
}

/// 50 mm at f/2 is a lens of 25 mm; 36 mm of film are as wide as the image's longer side sees.
#[test]
fn lenses_are_read_from_blenders_names() {
    let wide = Document::new().with("/cameras/0/perspective/aspectRatio", 2.0.into());
    let lens = |extras: Value| wide.clone().with("/cameras/0/extras", extras).loaded().description.cameras[0].lens;
    let expect = |lens: Lens, expected: f64| match lens {
        Lens::Thin { radius, focus, .. } => assert!((radius - expected).abs() < 1e-6 && focus == 3.0, "{lens:?}"),
        other => panic!("{other:?}"),
    };
    expect(lens(json!({ "lens": 50, "aperture_fstop": 2, "focus_distance": 3 })), 0.0125);
    let focal = 0.018 / (2.0 * 0.5f64.tan());
    expect(lens(json!({ "dof": { "use_dof": true, "aperture_fstop": 4, "focus_distance": 3 } })), focal / 8.0);
    let sharp = Lens::Pinhole { vertical_fov: 1.0 };
    for extras in [
        json!({ "dof": { "use_dof": false, "aperture_fstop": 4, "focus_distance": 3 } }),
        json!({ "aperture_fstop": 4 }),
        json!({ "aperture_fstop": "4", "focus_distance": 3 }),
        json!({ "aperture_fstop": 0, "focus_distance": 3 }),
        json!(7),
    ] {
        assert_eq!(lens(extras), sharp);
    }
}

#[test]
fn materials_emit_and_reflect() {
    let material = json!({
        "name": "lamp", "doubleSided": true, "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 20 },
                        "KHR_materials_specular": { "specularFactor": 0 } }
    });
    let loaded = Document::new().with("/materials/0", material).loaded();
    let lamp = &loaded.description.materials[0];
    assert_eq!(lamp.emission, Vec3::new(20.0, 10.0, 0.0));
    assert!(lamp.emits_both_sides);
    assert!(matches!(&lamp.bsdf, Bsdf::Lambert(l) if l.reflectance == Vec3::new(0.5, 0.25, 0.125)));

    let mut document = Document::new();
    document.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    let scene = document.loaded().description;
    assert_eq!((scene.meshes[0].material, scene.materials[1].name.as_str()), (1, "default"));
}

/// A lamp of 1000 W as Blender writes it, a spot and a sun; and what else the numbers may mean.
#[test]
fn punctual_lights_have_the_units_of_their_programs() {
    let light = |kind: &str| {
        let lights = json!([{ "type": kind, "name": "lamp", "intensity": 54351.41, "color": [1, 0.5, 0],
                              "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.6 } }]);
        Document::new()
            .with("/extensions", json!({ "KHR_lights_punctual": { "lights": lights } }))
            .with("/nodes/0/extensions", json!({ "KHR_lights_punctual": { "light": 0 } }))
            .with("/nodes/0/translation", json!([1, 2, 3]))
            .with("/nodes/0/rotation", json!([-1, 0, 0, 1]))
    };
    let only = |document: &Document, units: Option<LightUnits>| {
        let folder = tempfile::TempDir::new().unwrap();
        document.write(folder.path());
        let options = LoadOptions { light_units: units, ..LoadOptions::default() };
        let loaded = mlt_scene::open_within(folder.path().join("scene.gltf"), &options, &Memory::unlimited()).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.description.punctual[0].clone()
    };
    let near = |found: f32, expected: f32| assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    let (point, watts) = (light("point"), 1000.0 / (4.0 * std::f32::consts::PI));
    let blender = point.clone().with("/asset/generator", "Khronos glTF Blender I/O v5".into());
    near(only(&blender, None).emission.x, watts);
    near(only(&blender, None).emission.y, 0.5 * watts);
    near(only(&point, None).emission.x, 54351.41);
    near(only(&blender, Some(LightUnits::Photometric)).emission.x, 54351.41);
    near(only(&point, Some(LightUnits::Raw)).emission.x, 54351.41 / (4.0 * std::f32::consts::PI));
    near(only(&light("directional"), Some(LightUnits::Raw)).emission.x, 54351.41);
    assert_eq!(only(&point, None).kind, Punctual::Point { position: DVec3::new(1., 2., 3.) });
    let Punctual::Spot { axis, cone, .. } = only(&light("spot"), None).kind else { panic!("no spot") };
    assert!(axis.distance(Vec3::NEG_Y) < 1e-6 && cone == [0.2, 0.6], "{axis} {cone:?}");
    let Punctual::Directional { along, angle } = only(&light("directional"), None).kind else { panic!("no sun") };
    assert!(along.distance(Vec3::NEG_Y) < 1e-6 && angle == 0.0, "{along} {angle}");
    let wide = light("directional").with("/extensions/KHR_lights_punctual/lights/0/extras", json!({ "angle": 0.2 }));
    assert!(matches!(only(&wide, None).kind, Punctual::Directional { angle: 0.2, .. }));
    // A radius makes a ball of as much power: its luminance at a distance is π L r² over it.
    let soft = point.clone().with("/nodes/0/extras", json!({ "shadow_soft_size": 0.5 })).loaded().description;
    let (ball, lamp) = (soft.meshes.last().unwrap(), soft.materials.last().unwrap());
    assert!(
        soft.punctual.is_empty()
            && ball.positions.iter().all(|p| (p.distance(DVec3::new(1., 2., 3.)) - 0.5).abs() < 1e-9)
    );
    let intensity = lamp.emission.x * std::f32::consts::PI * 0.25;
    assert!((intensity / 54351.41 - 1.0).abs() < 0.02, "{intensity}");
    // The same of a spot, which emits into its cone alone.
    let soft = light("spot").with("/nodes/0/extras", json!({ "shadow_soft_size": 0.5 })).loaded().description;
    let spot = soft.materials.last().unwrap();
    assert!(soft.punctual.is_empty() && spot.emission == lamp.emission && spot.cone.is_some() && lamp.cone.is_none());
    let dark = point.with("/extensions/KHR_lights_punctual/lights/0/intensity", json!(-1));
    warning(&dark, "not one that a light can have");
}

#[test]
fn what_is_left_out_is_named() {
    let film = json!({ "KHR_materials_dispersion": { "dispersion": 1 }, "KHR_materials_iridescence": { "iridescenceFactor": 1 } });
    let coated = Document::new().with("/materials/0/extensions", film);
    let coated = coated.with("/extensionsUsed", json!(["KHR_materials_iridescence", "EXT_unknown"]));
    warning(&coated, "left out: KHR_materials_dispersion, KHR_materials_iridescence");
    warning(&coated, "extension EXT_unknown");
    let moving = Document::new().with("/animations", json!([{ "channels": [], "samplers": [] }]));
    warning(&moving, "shown as it stands at rest");
    warning(
        &Document::new().with("/materials/0/emissiveFactor", json!([-1, 0, -2])),
        "emission is [-1, 0, -2]; [0, 0, 0]",
    );
}

#[test]
fn glass_that_is_not_as_its_author_may_mean_it_is_named() {
    let glass = |volume: Value, specular: Value| {
        let extensions = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 },
                                 "KHR_materials_volume": volume, "KHR_materials_specular": specular });
        Document::new().with("/materials/0/extensions", extensions)
    };
    warning(&glass(json!({}), json!({})), "`paint`: a volume of thickness 0 is taken for a solid");
    warning(&glass(json!({ "thicknessFactor": 1 }), json!({ "specularFactor": 0.5 })), "KHR_materials_specular");
    assert!(glass(json!({ "thicknessFactor": 1 }), json!({})).loaded().warnings.is_empty());
}

#[test]
fn scenes_need_no_nodes() {
    only_mesh(&Document::new().with("/scenes/-", json!({ "name": "nothing in it" })));
}

#[test]
fn bad_vertices_are_dropped_and_bad_normals_replaced() {
    let mut document = Document::new();
    document.bin[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
    warning(&document, "mesh `thing`: 1 vertices");
    warning(&document, "no triangles");
    let mut document = Document::new();
    document.bin[36..48].copy_from_slice(&f32s(&[f32::NAN, 0., 0.]));
    warning(&document, "1 normals have no direction");
    assert_eq!(document.loaded().description.meshes[0].normals, [Vec3::Z; 3]);
}

/// Each of these once made a loader panic, read a foreign file, or return nonsense.
#[test]
fn what_cannot_be_is_refused_with_a_reason() {
    let cases: &[(&str, Value, &str)] = &[
        ("/asset/version", "1.0".into(), "asset"),
        ("/scene", 7.into(), "scene"),
        ("/nodes/0/mesh", 7.into(), "nodes[0].mesh"),
        ("/nodes/0/children", json!([0]), "nodes[0]"),
        ("/nodes/1/children", json!([0]), "two parents"),
        ("/accessors/0/bufferView", 9.into(), "accessors[0].bufferView"),
        ("/accessors/0/count", 4.into(), "accessors[0]"),
        ("/accessors/0/count", u64::MAX.into(), "accessors[0]"),
        ("/accessors/0/byteOffset", u64::MAX.into(), "accessors[0]"),
        ("/accessors/0/type", "VEC2".into(), "accessors[0]"),
        ("/accessors/0/componentType", 1.into(), "accessors[0]"),
        ("/accessors/2/componentType", 5126.into(), "accessors[2]"),
        ("/accessors/2/type", "VEC2".into(), "accessors[2]"),
        ("/accessors/0", json!({ "componentType": 5126, "count": 3_000_000_000u64, "type": "VEC3" }), "accessors[0]"),
        ("/bufferViews/0/byteLength", 1000.into(), "beyond its buffer"),
        ("/bufferViews/0/byteOffset", u64::MAX.into(), "bufferViews[0]: it ends beyond"),
        ("/buffers/0/byteLength", 81.into(), "81 bytes are announced and 80"),
        ("/buffers/0/uri", "missing.bin".into(), "missing.bin"),
        ("/buffers/0/uri", Value::Null, "buffers[0]"),
        ("/buffers/0/uri", "%ff.bin".into(), "cannot be read"),
        ("/buffers/0/uri", "%f".into(), "cannot be read"),
        ("/buffers/0/uri", "data:,%f".into(), "percent"),
        ("/buffers/0/uri", "a%00b".into(), "cannot be read"),
        ("/buffers/0/uri", "".into(), "regular file"),
        ("/buffers/0/uri", "data:;base64,####".into(), "base64"),
        ("/buffers/0/uri", "data:".into(), "data URI"),
        ("/buffers/0/uri", "/etc/passwd".into(), "outside"),
        ("/buffers/0/uri", "../secret.bin".into(), "outside"),
        ("/buffers/0/uri", "a/../../secret.bin".into(), "outside"),
        ("/buffers/0/uri", "%2e%2e/secret.bin".into(), "outside"),
        ("/buffers/0/uri", "..\\secret.bin".into(), "outside"),
        ("/buffers/0/uri", "file:///etc/passwd".into(), "outside"),
        ("/buffers/0/uri", "http://example.org/a.bin".into(), "outside"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
        ("/meshes/0/primitives/0/mode", 9.into(), "mode"),
        ("/materials/0/name", 3.into(), "does not parse"),
    ];
    for (pointer, value, needle) in cases {
        let error = Document::new().with(pointer, value.clone()).error();
        assert!(error.contains(needle), "{pointer} = {value}: {error}");
    }
    let mut document = Document::new();
    document.bin[72] = 3;
    assert!(document.error().contains("index 3 is beyond its 3 vertices"));
}

#[cfg(unix)]
#[test]
fn a_link_out_of_the_folder_is_refused() {
    let outside = tempfile::NamedTempFile::new().unwrap();
    let folder = tempfile::TempDir::new().unwrap();
    Document::new().write(folder.path());
    std::fs::remove_file(folder.path().join("scene.bin")).unwrap();
    std::os::unix::fs::symlink(outside.path(), folder.path().join("scene.bin")).unwrap();
    let error = mlt_scene::load(&folder.path().join("scene.gltf")).unwrap_err().to_string();
    assert!(error.contains("outside"), "{error}");
}

#[test]
fn a_scene_is_chosen_by_its_name() {
    let document = Document::new()
        .with("/scenes/0/name", "day".into())
        .with("/scenes/-", json!({ "name": "night", "nodes": [2] }))
        .with("/nodes/-", json!({ "name": "lamp", "mesh": 0 }));
    let folder = tempfile::TempDir::new().unwrap();
    document.write(folder.path());
    let open = |name: &str| {
        let options = LoadOptions { scene: Some(name.into()), ..LoadOptions::default() };
        mlt_scene::open_within(folder.path().join("scene.gltf"), &options, &Memory::unlimited())
    };
    let mesh = |name: &str| open(name).unwrap().description.meshes[0].name.clone();
    assert_eq!((mesh("day"), mesh("night")), ("thing".to_owned(), "lamp".to_owned()));
    let error = open("nigth").unwrap_err().to_string();
    assert!(
        error.ends_with("there is no scene \"nigth\"; did you mean \"night\"? it has \"day\", \"night\""),
        "{error}"
    );
    let options = LoadOptions { scene: Some("night".into()), ..LoadOptions::default() };
    assert!(mlt_scene::open_within("cornell", &options, &Memory::unlimited()).is_err());
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    for (name, content, needle) in [
        ("scene.gltf", &b""[..], "does not parse as glTF"),
        ("scene.gltf", b"{}", "does not parse as glTF"),
        ("scene.gltf", b"[[[[", "line 1"),
        (
            "scene.gltf",
            br#"{ "asset": { "version": "1.0" }, "scenes": {} }"#,
            "its version is 1.0, and 2.0 is expected",
        ),
        ("scene.gltf", br#"{ "asset": { "version": "2.0" }, "scenes": {} }"#, "expected a sequence"),
        ("scene.glb", b"glTF", "does not parse as binary glTF"),
        ("scene.glb", b"glTF\x02\0\0\0\0\0\0\0", "scene.glb"),
        ("scene.fbx", b"", "convert"),
        ("scene.", b"", "convert"),
    ] {
        let error = load_files(&[(name, content)]).unwrap_err().to_string();
        crate::support::check_sentence(&error);
        assert!(error.contains(needle), "{name} {content:?}: {error}");
    }
    let deep = "[".repeat(1 << 20);
    assert!(load_files(&[("scene.gltf", deep.as_bytes())]).is_err());
}

#[test]
fn a_chain_of_many_nodes_needs_no_deep_stack() {
    let mut document = Document::new().with("/scenes/0/nodes", json!([2]));
    const DEPTH: usize = 100_000;
    let nodes = document.json["nodes"].as_array_mut().unwrap();
    nodes.extend((3..DEPTH).map(|next| json!({ "children": [next] })));
    nodes.push(json!({ "children": [0, 1] }));
    assert_eq!(document.loaded().description.meshes.len(), 1);
}

/// The first mesh so many times, as meshes of their own: one that stands in all places is held once.
fn crowd(mut document: Document, count: usize) -> Document {
    let (mesh, node) = (document.json["meshes"][0].clone(), document.json["nodes"][0].clone());
    document.json["meshes"].as_array_mut().unwrap().extend(vec![mesh; count]);
    let nodes = document.json["nodes"].as_array_mut().unwrap();
    let first = nodes.len();
    nodes.extend(vec![node; count]);
    (0..count).for_each(|i| nodes[first + i]["mesh"] = (i + 1).into());
    document.with("/scenes/0/nodes", (first..first + count).collect::<Vec<_>>().into())
}

#[test]
fn a_small_file_cannot_ask_for_much_memory() {
    let sparse =
        json!({ "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 0 } });
    for count in [2_000_000u64, 4_000_000_000, u64::MAX / 2] {
        let accessor = json!({ "componentType": 5126, "count": count, "type": "VEC3", "sparse": sparse.clone() });
        assert!(Document::new().with("/accessors/0", accessor).error().contains("exceed the limit"));
        let accessor = json!({ "componentType": 5123, "count": count, "type": "SCALAR", "sparse": sparse.clone() });
        assert!(Document::new().with("/accessors/2", accessor).error().contains("exceed the limit"));
    }
    let accessor = json!({ "componentType": 5125, "count": 1_000_000, "type": "SCALAR", "sparse": sparse });
    let crowd = crowd(Document::new().with("/accessors/2", accessor), 500);
    assert!(crowd.error().contains("triangles exceed the limit"));
}

/// A few vertices of many, in a file of zeros.
#[test]
fn the_work_depends_on_what_is_drawn() {
    const VERTICES: u64 = 1 << 24;
    let accessor =
        json!({ "bufferView": 3, "componentType": 5121, "normalized": true, "count": VERTICES, "type": "VEC3" });
    let mut wide = Document::new()
        .with("/bufferViews/-", json!({ "buffer": 1, "byteStride": 4, "byteLength": 4 * VERTICES }))
        .with("/buffers/-", json!({ "uri": "zeros.bin", "byteLength": 4 * VERTICES }))
        .with("/accessors/0", accessor)
        .with("/accessors/2/componentType", 5125.into())
        .with_view(&[0, (VERTICES - 1) as u32, 1].map(u32::to_le_bytes).concat())
        .with("/accessors/2/bufferView", 4.into());
    wide.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    let thing = wide.json["nodes"][0].clone();
    wide.json["nodes"].as_array_mut().unwrap().extend(vec![thing; 2000]);
    let wide = wide.with("/scenes/0/nodes", (2..2000).collect::<Vec<_>>().into());
    let folder = tempfile::TempDir::new().unwrap();
    wide.write(folder.path());
    std::fs::File::create(folder.path().join("zeros.bin")).unwrap().set_len(4 * VERTICES).unwrap();
    let start = std::time::Instant::now();
    let loaded = mlt_scene::load(&folder.path().join("scene.gltf")).unwrap();
    assert!(loaded.description.meshes.is_empty(), "all of a triangle's corners lie in one place");
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

#[test]
fn a_scene_takes_its_memory_from_the_budget_or_is_refused() {
    let indices = json!({ "componentType": 5125, "count": 999_999, "type": "SCALAR", "sparse":
        { "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 0 } } });
    let crowd = crowd(Document::new().with("/accessors/2", indices), 300);
    let refusal = |document: &Document, bytes| {
        let folder = tempfile::TempDir::new().unwrap();
        document.write(folder.path());
        let error =
            mlt_scene::open_within(folder.path().join("scene.gltf"), &LoadOptions::default(), &Memory::of(bytes))
                .unwrap_err()
                .to_string();
        crate::support::check_sentence(&error);
        error
    };
    let error = refusal(&crowd, 4 << 30);
    assert!(error.contains("the geometry of 99999900 triangles needs 39.1 GiB of memory and 4.0 GiB are"), "{error}");
    let small = Document::new();
    let size = small.json.to_string().len() as u64;
    assert!(refusal(&small, size - 1).contains("the file needs"));
    assert!(refusal(&small, size + 1).contains("the JSON of"));
    let folder = tempfile::TempDir::new().unwrap();
    small.write(folder.path());
    mlt_scene::open_within(folder.path().join("scene.gltf"), &LoadOptions::default(), &Memory::of(1 << 20)).unwrap();
}

#[test]
fn names_in_messages_are_short_and_control_no_terminal() {
    let name = "\u{1b}[31m\n\u{9b}".to_owned() + &"x".repeat(1 << 20);
    let named = Document::new()
        .with("/nodes/0/name", name.clone().into())
        .with("/nodes/0/extensions", json!({ name.clone(): {} }))
        .with("/materials/0", json!({ "name": name, "pbrMetallicRoughness": { "roughnessFactor": 7 } }))
        .with("/extensionsUsed", json!([name]));
    let loaded = named.loaded();
    let scene = &loaded.description;
    for text in loaded.warnings.iter().chain([&scene.meshes[0].name, &scene.materials[0].name]) {
        assert!(text.len() < 300 && text.contains("\\u{1b}[31m\\n\\u{9b}xxx"), "{text}");
    }
    assert_eq!(loaded.warnings.len(), 2);
    for pointer in ["/asset/version", "/scene"] {
        let error = named.clone().with(pointer, name.clone().into()).load().unwrap_err().to_string();
        assert!(error.len() < 1000, "{pointer}: {}", &error[..1000]);
    }
}

#[test]
fn glass_is_solid_with_a_volume_and_thin_without() {
    let glass = |extensions: Value| {
        let pbr = json!({ "metallicFactor": 0, "roughnessFactor": 0 });
        let material = json!({ "pbrMetallicRoughness": pbr, "extensions": extensions });
        let loaded = Document::new().with("/materials/0", material).loaded();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.description.materials[0].bsdf
    };
    let clear = json!({ "transmissionFactor": 1 });
    let thin = glass(json!({ "KHR_materials_transmission": clear }));
    assert!(matches!(thin, Bsdf::Thin(_)));
    let solid = json!({ "KHR_materials_transmission": clear, "KHR_materials_volume": { "thicknessFactor": 1 },
                "KHR_materials_ior": { "ior": 1.7 } });
    assert!(matches!(glass(solid), Bsdf::Dielectric(d) if d.ior == 1.7));
    let mirror = Document::new().with("/materials/0/pbrMetallicRoughness", json!({ "roughnessFactor": 0 })).loaded();
    assert!(matches!(mirror.description.materials[0].bsdf, Bsdf::Mirror(_)));
}
