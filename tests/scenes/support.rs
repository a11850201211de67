//! Small scene files, made as the tests need them.

use mlt_scene::{Loaded, SceneError, load};
use serde_json::{Value, json};
use std::{fs, path::Path};
use tempfile::TempDir;

/// A glTF document with its buffer: one triangle in the xy plane that faces +z, with normals, u16 indices and a camera.
#[derive(Clone)]
pub(crate) struct Document {
    pub json: Value,
    pub bin: Vec<u8>,
}

pub(crate) fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

impl Document {
    pub(crate) fn new() -> Self {
        let mut bin = f32s(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        bin.extend(f32s(&[0., 0., 2., 0., 0., 2., 0., 0., 2.]));
        bin.extend([0, 0, 1, 0, 2, 0, 0, 0]);
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0, 1] }],
            "nodes": [{ "name": "thing", "mesh": 0 }, { "name": "eye", "camera": 0 }],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }],
            "materials": [{ "name": "paint" }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
                { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
                { "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" }
            ],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
                { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
                { "buffer": 0, "byteOffset": 72, "byteLength": 6 }
            ],
            "buffers": [{ "uri": "scene.bin", "byteLength": 80 }]
        });
        Self { json, bin }
    }

    /// The document with `value` at a JSON pointer, whose parent must exist.
    pub(crate) fn with(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = self.json.pointer_mut(parent).unwrap_or_else(|| panic!("nothing at {parent}"));
        match parent {
            Value::Array(items) if key == "-" => items.push(value),
            Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
            object => object[key] = value,
        }
        self
    }

    /// The document with `bytes` behind its buffer, in a buffer view of their own.
    pub(crate) fn with_view(mut self, bytes: &[u8]) -> Self {
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        let length = self.bin.len();
        self.json["buffers"][0]["byteLength"] = length.into();
        self.with("/bufferViews/-", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub(crate) fn write(&self, folder: &Path) {
        fs::write(folder.join("scene.gltf"), self.json.to_string()).unwrap();
        fs::write(folder.join("scene.bin"), &self.bin).unwrap();
    }

    /// As binary glTF; the buffer is the binary chunk.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0].as_object_mut().unwrap().remove("uri");
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let u32s = |values: [usize; 2]| values.map(|v| (v as u32).to_le_bytes()).concat();
        let mut glb = b"glTF".to_vec();
        glb.extend(u32s([2, 12 + 8 + json.len() + 8 + bin.len()]));
        glb.extend((json.len() as u32).to_le_bytes());
        glb.extend(b"JSON");
        glb.extend(json);
        glb.extend((bin.len() as u32).to_le_bytes());
        glb.extend(b"BIN\0");
        glb.extend(bin);
        glb
    }

    pub(crate) fn load(&self) -> Result<Loaded, SceneError> {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        load(&folder.path().join("scene.gltf"))
    }

    pub(crate) fn loaded(&self) -> Loaded {
        self.load().unwrap_or_else(|error| panic!("{error}"))
    }

    /// The error, after checks that hold for each: it is one sentence and names the file.
    pub(crate) fn error(&self) -> String {
        let error = self.load().map(|l| l.warnings).unwrap_err().to_string();
        check_sentence(&error);
        error
    }
}

/// One line that names a file and a remedy.
pub(crate) fn check_sentence(error: &str) {
    assert!(!error.contains('\n') && !error.ends_with('.'), "{error}");
    assert!(error.contains("scene.") || error.starts_with('/'), "names no file: {error}");
    assert!(error.contains(';'), "offers no remedy: {error}");
}

/// Writes the files into a new folder and loads the first.
pub(crate) fn load_files(files: &[(&str, &[u8])]) -> Result<Loaded, SceneError> {
    let folder = TempDir::new().unwrap();
    for (name, content) in files {
        fs::write(folder.path().join(name), content).unwrap();
    }
    load(&folder.path().join(files[0].0))
}
