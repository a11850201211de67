//! glTF's copies of meshes, skins, morph targets and animations.

use crate::support::{Document, f32s};
use glam::DVec3;
use mlt_core::memory::Memory;
use mlt_core::transport::geometry::Mesh;
use mlt_scene::{LoadOptions, Loaded, MovingScene, SceneError};
use serde_json::{Value, json};

fn at(document: &Document, time: f64) -> Loaded {
    let folder = tempfile::TempDir::new().unwrap();
    document.write(folder.path());
    let options = LoadOptions { time_in_animation: Some(time), ..LoadOptions::default() };
    let loaded = mlt_scene::open_within(folder.path().join("scene.gltf"), &options, &Memory::unlimited());
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

fn only_mesh(loaded: Loaded) -> Mesh {
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.description.meshes[0].clone()
}

/// The document with an accessor of floats behind its others.
fn with_floats(document: Document, values: &[f32], kind: &str, components: usize) -> Document {
    let view = document.json["bufferViews"].as_array().unwrap().len();
    document.with_view(&f32s(values)).with(
        "/accessors/-",
        json!({ "bufferView": view, "componentType": 5126, "count": values.len() / components, "type": kind }),
    )
}

fn copies(attributes: Value) -> Value {
    json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } })
}

#[test]
fn copies_stand_where_they_are_put() {
    let document = with_floats(Document::new(), &[0., 0., 1., 5., 0., 0.], "VEC3", 3);
    let document = with_floats(document, &[0., 0., 0., 1., 0., 0., 2., 0.], "VEC4", 4);
    let document = with_floats(document, &[1., 1., 1., 2., 2., -2.], "VEC3", 3)
        .with("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]))
        .with("/nodes/0/extensions", copies(json!({ "TRANSLATION": 3, "ROTATION": 4, "SCALE": 5 })))
        .with("/nodes/0/translation", json!([0, 10, 0]));
    let loaded = document.loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let [a, b] = &loaded.description.meshes[..] else { panic!("{} meshes", loaded.description.meshes.len()) };
    assert_eq!(a.positions[1], DVec3::new(1., 10., 1.));
    // A mirrored copy faces the other way, and so its corners are turned.
    assert!(b.positions[2].distance(DVec3::new(3., 10., 0.)) < 1e-6 && b.normals[0].z < -0.9, "{b:?}");

    let loaded = document.clone().with("/nodes/0/extensions", copies(json!({ "TRANSLATION": 99 }))).loaded();
    assert!(loaded.description.meshes.len() == 1 && loaded.warnings[0].contains("where its copies are"));
}

/// A million copies of a triangle, of which the file holds none.
#[test]
fn copies_are_counted_before_they_are_made() {
    let crowd = Document::new()
        .with("/accessors/-", json!({ "componentType": 5126, "count": 1 << 20, "type": "VEC3" }))
        .with("/nodes/0/extensions", copies(json!({ "TRANSLATION": 3 })));
    let error = within(&crowd, &Memory::of(64 << 20)).unwrap_err();
    assert!(error.to_string().contains("the geometry of 1048576 triangles"), "{error}");
}

/// 20,000 copies in one place of 64 triangles.
fn large_crowd(attributes: Value) -> Document {
    let indices = [0u8, 0, 1, 0, 2, 0].repeat(64);
    Document::new()
        .with_view(&indices)
        .with("/accessors/2", json!({ "bufferView": 3, "componentType": 5123, "count": 192, "type": "SCALAR" }))
        .with("/accessors/-", json!({ "componentType": 5126, "count": 20_000, "type": "VEC3" }))
        .with("/nodes/0/extensions", copies(attributes))
}

fn within(document: &Document, memory: &Memory) -> Result<Loaded, SceneError> {
    let folder = tempfile::TempDir::new().unwrap();
    document.write(folder.path());
    mlt_scene::open_within(folder.path().join("scene.gltf"), &LoadOptions::default(), memory)
}

#[test]
fn copies_of_a_large_crowd_share_their_mesh() {
    let crowd = large_crowd(json!({ "TRANSLATION": 3 }));
    let memory = || Memory::of(64 << 20);
    let shared = within(&crowd, &memory()).unwrap().description;
    assert!(shared.meshes.is_empty() && shared.prototypes.len() == 1);
    assert_eq!((shared.prototypes[0].triangles(), shared.prototypes[0].places.len()), (64, 20_000));

    // What shines, or has its own shape in each place, is made in the world.
    let lit = crowd.clone().with("/materials/0/emissiveFactor", json!([1, 1, 1]));
    let shaped = crowd.with("/meshes/0/primitives/0/targets", json!([{ "POSITION": 0 }]));
    for document in [lit, shaped] {
        let error = within(&document, &memory()).unwrap_err().to_string();
        assert!(error.contains("the geometry of 1280000 triangles"), "{error}");
    }

    let vanished = within(&large_crowd(json!({ "SCALE": 3 })), &memory()).unwrap();
    assert!(vanished.description.prototypes.is_empty());
    assert!(vanished.warnings[0].contains("20000 of its 20000 copies have no extent"), "{:?}", vanished.warnings);
}

/// The triangle with two joints: one stays, one is moved; the weights of the last vertex are not normalised.
fn skinned() -> Document {
    let document = Document::new()
        .with_view(&[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0])
        .with("/accessors/-", json!({ "bufferView": 3, "componentType": 5121, "count": 3, "type": "VEC4" }));
    let document = with_floats(document, &[1., 0., 0., 0., 0., 1., 0., 0., 1., 1., 0., 0.], "VEC4", 4);
    let axes = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0.];
    let bound = [&axes[..], &[0., 0., 0., 1.], &axes[..], &[0., -1., 0., 1.]].concat();
    with_floats(document, &bound, "MAT4", 16)
        .with("/meshes/0/primitives/0/attributes/JOINTS_0", 3.into())
        .with("/meshes/0/primitives/0/attributes/WEIGHTS_0", 4.into())
        .with("/skins", json!([{ "joints": [2, 3], "inverseBindMatrices": 5 }]))
        .with("/nodes/0/skin", 0.into())
        .with("/nodes/0/translation", json!([99, 0, 0]))
        .with("/nodes/-", json!({ "name": "still" }))
        .with("/nodes/-", json!({ "name": "moved", "translation": [0, 3, 0] }))
        .with("/scenes/0/nodes", json!([0, 1, 2, 3]))
}

#[test]
fn a_skin_moves_vertices_by_its_joints_and_not_by_their_node() {
    let positions = only_mesh(skinned().loaded()).positions;
    assert_eq!(positions[..], [DVec3::ZERO, DVec3::new(1., 2., 0.), DVec3::new(0., 2., 0.)]);
    let lost = skinned().with("/skins/0/joints", json!([2, 77])).loaded();
    assert!(lost.warnings[0].contains("joints that are not there"), "{:?}", lost.warnings);
    assert_eq!(lost.description.meshes[0].positions[0], DVec3::new(99., 0., 0.));
}

#[test]
fn morph_targets_count_by_their_weights() {
    let target = with_floats(Document::new(), &[0., 0., 1., 0., 0., 2., 0., 4., 0.], "VEC3", 3)
        .with("/meshes/0/primitives/0/targets", json!([{ "POSITION": 3 }]));
    let at_rest = |document: &Document| only_mesh(document.loaded()).positions[2];
    assert_eq!(at_rest(&target), DVec3::new(0., 1., 0.));
    let weighed = target.with("/meshes/0/weights", json!([0.5]));
    assert_eq!(at_rest(&weighed), DVec3::new(0., 3., 0.));
    assert_eq!(at_rest(&weighed.with("/nodes/0/weights", json!([0.25]))), DVec3::new(0., 2., 0.));
}

fn animated(path: &str, interpolation: &str, values: &[f32], kind: &str, components: usize) -> Document {
    let document = with_floats(Document::new(), &[1., 3.], "SCALAR", 1);
    with_floats(document, values, kind, components).with(
        "/animations",
        json!([{ "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }],
                 "samplers": [{ "input": 3, "output": 4, "interpolation": interpolation }] }]),
    )
}

#[test]
fn animations_are_read_at_a_time_by_their_interpolation() {
    let corner = |document: &Document, time: f64| only_mesh(at(document, time)).positions[1];
    let line = animated("translation", "LINEAR", &[0., 0., 0., 0., 4., 0.], "VEC3", 3);
    for (time, y) in [(0.0, 0.0), (1.0, 0.0), (1.5, 1.0), (3.0, 4.0), (9.0, 4.0)] {
        assert!(corner(&line, time).distance(DVec3::new(1., y, 0.)) < 1e-9, "{time}");
    }
    let step = animated("scale", "STEP", &[2., 1., 1., 5., 1., 1.], "VEC3", 3);
    assert_eq!([1.0, 2.9, 3.0].map(|time| corner(&step, time).x), [2.0, 2.0, 5.0]);
    // Half of a quarter turn about z, and the same with the other quaternion of its end.
    let h = 0.5f32.sqrt();
    for sign in [1.0, -1.0] {
        let turn = animated("rotation", "LINEAR", &[0., 0., 0., 1., 0., 0., sign * h, sign * h], "VEC4", 4);
        let half = f64::from(h);
        assert!(corner(&turn, 2.0).distance(DVec3::new(half, half, 0.)) < 1e-6, "{}", corner(&turn, 2.0));
    }
    // In the middle a Hermite spline is the mean of the values, and an eighth of 2 s times the difference of the slopes.
    let slopes = [[0.; 3], [0.; 3], [0., 8., 0.], [0.; 3], [0., 2., 0.], [0.; 3]].concat();
    let cubic = animated("translation", "CUBICSPLINE", &slopes, "VEC3", 3);
    assert!((corner(&cubic, 2.0).y - 3.0).abs() < 1e-9, "{}", corner(&cubic, 2.0));
    let control = animated("translation", "LINEAR", &slopes, "VEC3", 3);
    assert!((corner(&control, 2.0).y - 3.0).abs() > 1.0);
}

#[test]
fn what_is_the_same_at_all_times_is_read_once() {
    let line = animated("translation", "LINEAR", &[0., 0., 0., 0., 4., 0.], "VEC3", 3);
    let folder = tempfile::TempDir::new().unwrap();
    line.write(folder.path());
    let path = folder.path().join("scene.gltf");
    let mut scene = MovingScene::new(&path, LoadOptions::default());
    for time in [1.5, 3.0, 0.0] {
        let [moving, alone] = [scene.at(time, &Memory::unlimited()).unwrap(), at(&line, time)];
        assert_eq!(moving.description.meshes[0].positions, alone.description.meshes[0].positions, "{time}");
        assert_eq!((moving.digest, moving.warnings), (alone.digest, alone.warnings), "{time}");
    }
    std::fs::write(&path, "no JSON").unwrap();
    assert!(scene.at(2.0, &Memory::unlimited()).is_ok());
    assert!(MovingScene::new(&path, LoadOptions::default()).at(2.0, &Memory::unlimited()).is_err());
}

#[test]
fn animated_weights_shape_a_mesh() {
    let document = animated("weights", "LINEAR", &[0., 1.], "SCALAR", 1);
    let document = with_floats(document, &[0., 0., 1., 0., 0., 2., 0., 4., 0.], "VEC3", 3)
        .with("/meshes/0/primitives/0/targets", json!([{ "POSITION": 5 }]));
    assert_eq!(only_mesh(at(&document, 2.0)).positions[2], DVec3::new(0., 3., 0.));
}

#[test]
fn animations_that_cannot_be_read_are_said_and_left_at_rest() {
    let sound = animated("translation", "LINEAR", &[0., 0., 0., 0., 4., 0.], "VEC3", 3);
    let pointer = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/x" } } });
    for (place, value) in [
        ("/animations/0/samplers/0/input", json!(77)),
        ("/animations/0/samplers/0/output", json!(3)),
        ("/animations/0/channels/0/sampler", json!(5)),
        ("/animations/0/channels/0/target/node", json!(1 << 30)),
        ("/animations/0/channels/0/target", pointer),
        ("/animations/0", Value::from(3)),
    ] {
        let loaded = at(&sound.clone().with(place, value), 3.0);
        assert_eq!(loaded.description.meshes[0].positions[1], DVec3::X, "{place}: {:?}", loaded.warnings);
    }
}
