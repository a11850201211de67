//! glTF files as programs write them, cameras that stand elsewhere, winding against normals, and scenes too large.

use super::support::{data, refusal, render};
use serde_json::{Value, json};
use std::{fs, path::Path};

const PLAIN: &str = "--size 64x64 --samples-per-pixel 32 --method pt --threads 1";

fn document(case: &str) -> Value {
    serde_json::from_slice(&fs::read(data(case).join("scene.gltf")).expect("a scene")).expect("JSON")
}

fn save(folder: &Path, document: &Value) -> String {
    let path = folder.join("scene.gltf");
    fs::write(&path, document.to_string()).expect("written");
    path.display().to_string()
}

#[test]
fn a_file_as_programs_write_it_has_the_value_of_a_plain_one() {
    for case in [
        "gl-glb-nulpad/scene.glb",
        "gl-uri-newlines/scene.gltf",
        "gl-uri-spaces/scene.gltf",
        "gl-unused-buffer-missing/scene.gltf",
    ] {
        let render = render(case, PLAIN);
        render.expect_b(0.1148, 5e-4);
        assert!(!render.said.contains("not supported"), "{case}: {}", render.said);
    }
}

#[test]
fn a_camera_outside_the_scene_is_used_and_named() {
    let render = render("gl-camera-not-in-scene/scene.gltf", PLAIN);
    render.expect_b(0.1148, 5e-4);
    assert!(render.said.contains("`camera`, which stands outside of it, is taken"), "{}", render.said);
}

#[test]
fn a_view_that_no_camera_has_is_said_to_be_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut without = document("gl-base");
    without["nodes"][0].as_object_mut().expect("a node").remove("camera");
    let said = render(&save(folder.path(), &without), "--size 8x8 --samples-per-pixel 1 --threads 1").said;
    assert!(said.contains("no camera in the file can be used, so the scene is framed whole"), "{said}");
}

#[test]
fn what_is_not_rendered_is_named() {
    for (file, word) in [
        ("animation-pointer", "animated and shown as it stands at rest"),
        ("ktx2-texture", "KHR_texture_basisu is not supported"),
    ] {
        let said = render(&format!("files/{file}.gltf"), "--size 8x8 --samples-per-pixel 1 --threads 1").said;
        assert!(said.contains(word), "{file}: {said}");
    }
    let said = refusal("files/box-draco.gltf", "");
    assert!(said.contains("compressed by KHR_draco_mesh_compression"), "{said}");
}

/// Truths are those of both methods in long renders; a copy less is 0.0727. What glass makes of a spot, pt does not find, and says so.
#[test]
fn lights_and_copies_are_rendered() {
    let settings = "--size 64x64 --samples-per-pixel 32 --threads 1";
    for (file, truth) in [("default-cube.glb", 0.01704), ("instancing.gltf", 0.07516)] {
        for method in ["pt", "bdpt"] {
            render(&format!("files/{file}"), &format!("{settings} --method {method}")).expect_b(truth, 3e-5);
        }
    }
    let glass = "files/spot-glass.glb";
    render(glass, &format!("{settings} --method bdpt")).expect_b(0.0569, 1e-4);
    let missed = render(glass, &format!("{settings} --method pt"));
    assert!(missed.b().0 < 0.056 && missed.said.contains("pt finds nothing of what glass"), "{}", missed.said);
}

/// The truth is that of the same ball with its winding mended; the control has no normals, so the winding decides.
#[test]
fn normals_decide_the_outside_of_glass_where_the_winding_opposes_them() {
    const TRUTH: f64 = 0.183;
    let glass = "--size 64x64 --samples-per-pixel 64 --method pt --threads 1";
    let right = render("right-winding-glass/scene.gltf", glass);
    let opposed = render("opposed-winding-glass/scene.gltf", glass);
    right.expect_b(TRUTH, 1e-3);
    opposed.expect_b(TRUTH, 1e-3);
    assert!(!right.said.contains("winding"), "{}", right.said);
    assert!(
        opposed.said.contains("`o2`: the normals of 224 of its 224 triangles oppose their winding"),
        "{}",
        opposed.said
    );

    let folder = tempfile::tempdir().expect("a folder");
    let mut flat = document("opposed-winding-glass");
    for mesh in flat["meshes"].as_array_mut().expect("meshes") {
        mesh["primitives"][0]["attributes"].as_object_mut().expect("attributes").remove("NORMAL");
    }
    let (b, stderr) = render(&save(folder.path(), &flat), glass).b();
    assert!((b - TRUTH).abs() > 0.03 + 4.5 * stderr, "the control is caught: {b}");
}

/// Mirroring a node turns its winding and its normals alike.
#[test]
fn a_mirrored_ball_of_glass_keeps_its_outside() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mirrored = document("right-winding-glass");
    let ball = mirrored["nodes"].as_array_mut().expect("nodes").iter_mut().find(|node| node["name"] == "o2");
    ball.expect("the ball")["scale"] = json!([-1, 1, 1]);
    let render = render(&save(folder.path(), &mirrored), "--size 64x64 --samples-per-pixel 64 --method pt --threads 1");
    render.expect_b(0.183, 1e-3);
    assert!(!render.said.contains("winding"), "{}", render.said);
}

#[test]
fn a_name_controls_no_terminal_and_floods_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut named = document("gl-base");
    let name = "\u{1b}]0;pwned\u{7}\u{1b}[31m\u{9b}2J".to_owned() + &"x".repeat(1 << 20);
    named["materials"][0]["name"] = name.clone().into();
    named["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 5.into();
    named["nodes"][0]["name"] = name.into();
    let first = named["nodes"].as_array().expect("nodes").len();
    let unknown = vec![json!({ "extensions": { "UNKNOWN": {} } }); 19];
    named["nodes"].as_array_mut().expect("nodes").extend(unknown);
    named["scenes"][0]["nodes"] = (0..first + 19).collect::<Vec<_>>().into();
    let scene = save(folder.path(), &named);
    let said = render(&scene, "--size 8x8 --samples-per-pixel 1 --threads 1").said;
    assert!(said.contains("\\u{1b}]0;pwned\\u{7}") && said.contains("further warnings"), "{said}");
    let said = said + &refusal(&scene, "--camera none");
    assert!(said.chars().all(|c| c == '\n' || !c.is_control()) && said.len() < 20_000, "{}", said.len());
}

/// A file of 60 KB that draws a hundred million triangles, where 2 GB may be allocated.
#[cfg(target_os = "linux")]
#[test]
fn a_scene_that_does_not_fit_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut crowd = document("gl-base");
    let sparse =
        json!({ "count": 1, "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 0 } });
    let accessors = crowd["accessors"].as_array_mut().expect("accessors");
    accessors.push(json!({ "componentType": 5125, "count": 999_999, "type": "SCALAR", "sparse": sparse }));
    let indices = accessors.len() - 1;
    crowd["meshes"][0]["primitives"][0]["indices"] = indices.into();
    // Meshes of their own: one that stands in all places would be held once.
    let meshes = crowd["meshes"].as_array_mut().expect("meshes");
    let (others, mesh) = (meshes.len(), meshes[0].clone());
    meshes.extend(vec![mesh; 300]);
    let nodes: Vec<_> = (others..others + 300).map(|mesh| json!({ "mesh": mesh })).collect();
    let first = crowd["nodes"].as_array().expect("nodes").len();
    crowd["nodes"].as_array_mut().expect("nodes").extend(nodes);
    crowd["scenes"][0]["nodes"] = (0..first + 300).collect::<Vec<_>>().into();
    let scene = save(folder.path(), &crowd);
    let command = format!("ulimit -v 2000000; exec {} render {scene} -o image.exr", env!("CARGO_BIN_EXE_mlt"));
    let output = std::process::Command::new("sh").args(["-c", &command]).current_dir(folder.path()).output();
    let output = output.expect("sh starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("triangles needs") && said.contains("GiB of memory and 1.") && said.lines().count() == 1,
        "{said}"
    );
}
