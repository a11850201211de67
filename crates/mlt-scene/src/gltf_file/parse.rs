//! The JSON of a glTF file.

use super::CHECK;
use crate::{SceneError, source::Source};
use gltf::{
    Document, Glb,
    json::{
        Path, Root, deserialize,
        validation::{Error, Validate},
    },
};
use serde_json::Value;

/// Extensions that hide the geometry from a reader who does not know them.
const COMPRESSION: &[&str] = &["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Parses and validates the document; the second value is a GLB's binary chunk.
pub(super) fn parse(source: &Source) -> Result<(Document, Option<Vec<u8>>), SceneError> {
    let syntax = |format| {
        let path = source.path.clone();
        move |e: &dyn std::fmt::Display| SceneError::Syntax { path, format, reason: e.to_string() }
    };
    let bytes = source.read()?;
    let (root, blob) = if bytes.starts_with(b"glTF") {
        let glb = Glb::from_slice(&bytes).map_err(|e| syntax("binary glTF")(&e))?;
        let root = root(&glb.json).map_err(|e| syntax("binary glTF")(&e))?;
        (root, glb.bin.map(|bin| bin.into_owned()))
    } else {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        (root(text).map_err(|e| syntax("glTF")(&e))?, None)
    };
    if let Some(extension) = root.extensions_required.iter().find(|e| COMPRESSION.contains(&e.as_str())) {
        return Err(SceneError::Compressed { path: source.path.clone(), extension: extension.clone() });
    }
    validate(source, &root)?;
    Ok((Document::from_json_without_validation(root), blob))
}

/// The document as it stands. Scenes may lack a list of nodes, by the specification but not by the parser.
fn root(json: &[u8]) -> Result<Root, serde_json::Error> {
    deserialize::from_slice(json).or_else(|error| with_nodes(json).ok_or(error))
}

/// The same with an empty list for each scene that has none.
fn with_nodes(json: &[u8]) -> Option<Root> {
    let mut document: Value = serde_json::from_slice(json).ok()?;
    for scene in document.get_mut("scenes")?.as_array_mut()? {
        scene.as_object_mut()?.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
    deserialize::from_value(document).ok()
}

/// Checks what the `gltf` crate relies on; extensions and bounds of positions, which it also checks, are not needed here.
fn validate(source: &Source, root: &Root) -> Result<(), SceneError> {
    if !root.asset.version.starts_with("2.") {
        let reason = format!("the version is `{}`", root.asset.version);
        return Err(source.invalid("asset", reason, "export the scene as glTF 2.0"));
    }
    let mut first = None;
    root.validate(root, Path::new, &mut |path, error| {
        let path = path().to_string();
        let optional = error == Error::Missing && (path.ends_with(".min") || path.ends_with(".max"));
        if error != Error::Unsupported && !optional && first.is_none() {
            first = Some((path, error));
        }
    });
    first.map_or(Ok(()), |(path, error)| {
        let reason = error.to_string().to_lowercase();
        Err(source.invalid(path, reason, CHECK))
    })
}
