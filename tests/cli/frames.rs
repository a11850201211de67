//! Animations, from outside: each frame is the render of its moment.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use base64::{Engine, prelude::BASE64_STANDARD};
use mlt_cli::output::exr::read;
use serde_json::{Value, json};

const RENDER: &str = "render room.gltf --size 16x12 --method pt --samples-per-pixel 8 --threads 1";

/// The Cornell box, in which for one second from 0.1 s on a node moves along x.
pub(crate) fn with_animation(folder: &Path, node: usize, along: f32) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mlt-scene/scenes/cornell");
    let mut root: Value = serde_json::from_slice(&fs::read(scene.join("cornell.gltf")).expect("there")).expect("JSON");
    let matrix = root["nodes"][node].as_object_mut().expect("a node").remove("matrix");
    let place = |i: usize| matrix.as_ref().map_or(0.0, |matrix| matrix[i].as_f64().expect("a number") as f32);
    let [x, y, z] = [12, 13, 14].map(place);
    if matrix.is_some() {
        root["nodes"][node]["rotation"] = json!([0, 1, 0, 0]);
        root["nodes"][node]["translation"] = json!([x, y, z]);
    }
    let numbers = [0.1, 1.1, x, y, z, x + along, y, z];
    let bytes: Vec<u8> = numbers.iter().flat_map(|number: &f32| number.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let mut push = |list: &str, value: Value| root[list].as_array_mut().expect("a list").push(value);
    push("buffers", json!({ "uri": uri, "byteLength": 32 }));
    push("bufferViews", json!({ "buffer": 1, "byteLength": 8 }));
    push("bufferViews", json!({ "buffer": 1, "byteOffset": 8, "byteLength": 24 }));
    push(
        "accessors",
        json!({ "bufferView": 16, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0.1], "max": [1.1] }),
    );
    push("accessors", json!({ "bufferView": 17, "componentType": 5126, "count": 2, "type": "VEC3" }));
    root["animations"] = json!([{
        "samplers": [{ "input": 16, "output": 17 }],
        "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }],
    }]);
    fs::copy(scene.join("cornell.bin"), folder.join("cornell.bin")).expect("copied");
    fs::write(folder.join("room.gltf"), root.to_string()).expect("written");
}

fn run(folder: &Path, line: &str) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_mlt")).current_dir(folder).args(line.split_whitespace()).output();
    output.expect("mlt starts")
}

fn made(folder: &Path, line: &str) -> Vec<u8> {
    let output = run(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn refused(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(2), "{line}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A camera moves, so that the acceleration structure is used again, or a block, so that it is not.
#[test]
fn each_frame_has_the_bits_of_its_own_render() {
    for (node, along) in [(0, 1.0), (5, -0.5)] {
        let folder = tempfile::tempdir().expect("a folder");
        let image = |name: &str| read(&folder.path().join(name)).expect("an EXR").image;
        with_animation(folder.path(), node, along);
        let json = made(folder.path(), &format!("{RENDER} --frames 2-4 --fps 4 -o f.##.exr --json"));
        let reports: Value = serde_json::from_slice(&json).expect("JSON");
        assert_eq!([0, 1, 2].map(|i| reports[i]["frame"].as_u64()), [Some(2), Some(3), Some(4)]);
        assert_eq!((&reports[1]["time_in_animation"], &reports[2]["outputs"][0]), (&0.75.into(), &"f.04.exr".into()));
        assert!(reports[1]["relative_error"].as_f64().is_some_and(|error| error > 0.0));
        for (frame, seconds) in [(2, 0.5), (3, 0.75), (4, 1.0)] {
            made(folder.path(), &format!("{RENDER} --time-in-animation {seconds} -o alone.exr -q"));
            assert!(image(&format!("f.0{frame}.exr")).same_bits(&image("alone.exr")), "node {node}, frame {frame}");
        }
        assert!(!image("f.02.exr").same_bits(&image("f.03.exr")), "node {node} does not move");
        made(folder.path(), &format!("{RENDER} --frames 3 --fps 4 --frame-seeds own --seed 5 -o own.#.exr -q"));
        made(folder.path(), &format!("{RENDER} --time-in-animation 0.75 --seed 8 -o alone.exr -q"));
        assert!(image("own.3.exr").same_bits(&image("alone.exr")));
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    with_animation(folder.path(), 0, 1.0);
    for (options, part) in [
        ("--frames 1-3 -o a.exr", "write #### where the frame's number goes"),
        ("--frames 3-1 -o a.#.exr", "as in 1-240"),
        ("--frames 1-3 -o -", "write ####"),
        ("--frames 1-3 -o a.#.exr --resume b.mltp", "cannot be used with"),
        ("--frames 1-3 -o a.#.exr --time-in-animation 1", "cannot be used with"),
        ("--frames 1-3 -o none/a.#.exr", "the folder none does not exist"),
        ("--fps 30 -o a.exr", "--frames"),
    ] {
        let message = refused(folder.path(), &format!("{RENDER} {options}"));
        assert!(message.contains(part), "{options}: {message}");
    }
}

#[test]
fn frames_are_named_after_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    with_animation(folder.path(), 0, 1.0);
    let lines = String::from_utf8(made(folder.path(), &format!("{RENDER} --frames 9-10"))).expect("text");
    assert!(lines.contains("frame 10 at 0.417 s: error "), "{lines}");
    assert!(["room.0009.exr", "room.0010.png"].iter().all(|name| folder.path().join(name).is_file()));
}
