//! `mlt inspect`: what a scene holds.

use std::process::Command;

use serde_json::{Value, json};

/// Water over a basin.
const POOL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/stability/pool/scene.gltf");

fn inspected(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_mlt")).arg("inspect").args(arguments).output().expect("mlt starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

fn object(arguments: &[&str]) -> Value {
    serde_json::from_str(&inspected(&[arguments, &["--json"]].concat())).expect("JSON")
}

/// Whether the scene has the feature that is called so.
fn has(inspection: &Value, name: &str) -> bool {
    let features = inspection["features"].as_array().expect("a list");
    let feature = features.iter().find(|feature| feature["name"] == name).expect(name);
    feature["present"] == true
}

#[test]
fn a_scene_is_told_as_it_is_rendered() {
    let text = inspected(&["cornell", "--size", "64x48"]);
    for part in [
        "cornell: 32 triangles",
        "\n  a render takes \"camera\", the file's only one; pinhole",
        "\n  counted: 1 glowing surface\n",
        "\n  no  textures ",
        "  materials are constants\n",
        "\nMemory at 64x48\n",
        "\nRender it:  mlt render cornell\n",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("Warnings"));
}

#[test]
fn what_a_scene_has_and_lacks_is_told_apart() {
    let (cornell, pool) = (object(&["cornell"]), object(&[POOL]));
    assert_eq!((&cornell["triangles"], &cornell["size"]), (&json!(32), &json!([512, 512])));
    assert!(cornell["nodes"].as_array().is_some_and(|nodes| nodes.iter().any(|node| node["parts"][0] == "camera")));
    assert!(!has(&cornell, "mirrors and clear glass") && has(&pool, "mirrors and clear glass"));
    assert!(!has(&cornell, "light from all around"));
    assert!(has(&object(&["cornell", "--environment", "sky"]), "light from all around"));
    let lens = object(&["cornell", "--aperture", "0.1", "--focus", "3"]);
    assert!(has(&lens, "depth of field") && !has(&cornell, "depth of field"));
    for name in ["geometry", "acceleration", "image", "peak", "available"] {
        assert!(cornell["memory"][name].as_u64().is_some_and(|bytes| bytes > 0), "{name}");
    }
    let larger = object(&["cornell", "--size", "1024x1024"]);
    assert_eq!(larger["memory"]["image"].as_u64(), cornell["memory"]["image"].as_u64().map(|bytes| 4 * bytes));
}

#[test]
fn lights_that_give_none_are_counted_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let light = |name: &str, intensity: f64| json!({ "type": "point", "name": name, "intensity": intensity });
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [light("on", 5.0), light("off", 0.0)] } },
        "buffers": [{ "byteLength": 36, "uri":
            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
        "materials": [{ "name": "grey" }, { "name": "spare lamp", "emissiveFactor": [1, 1, 1] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "nodes": [
            { "name": "group", "children": [1, 2] },
            { "name": "wall", "mesh": 0 },
            { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "extensions": { "KHR_lights_punctual": { "light": 1 } } }
        ],
        "scenes": [{ "nodes": [0, 3] }]
    });
    let file = folder.path().join("room.gltf");
    std::fs::write(&file, document.to_string()).expect("written");
    let file = file.to_str().expect("text");
    let found = object(&[file]);
    let expected = [("points", 1), ("spots", 0), ("suns", 0), ("surfaces", 0), ("dark", 1), ("unused", 1)];
    for (name, count) in expected {
        assert_eq!(found["lights"][name], count, "{name}");
    }
    let text = inspected(&[file]);
    for part in [
        "  group\n    wall  (1 triangle of \"grey\")\n    lamp  (point light)\n  node 3  (point light)\n",
        "  counted: 1 point\n  ignored: 1 light and 1 glowing material, of no intensity",
        "a render takes \"framing\", around the whole scene",
        "no camera in the file can be used",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn what_cannot_be_read_is_refused() {
    let output = Command::new(env!("CARGO_BIN_EXE_mlt")).args(["inspect", "corneel"]).output().expect("mlt starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && message.contains("did you mean cornell?"), "{message}");
}
