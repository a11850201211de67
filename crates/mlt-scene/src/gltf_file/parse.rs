//! The JSON of a glTF file.

use super::{CHECK, glb};
use crate::{
    SceneError,
    source::Source,
    text::{printable, shown},
};
use gltf::{
    Document,
    json::{
        Path, Root,
        validation::{Error, Validate},
    },
};
use serde_json::{Value, json};
use std::ops::Range;

/// The extension that hides the geometry from a reader who does not know it.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Bytes that a JSON object takes once it is parsed: a node, the largest that there can be many of.
const BYTES_PER_OBJECT: u64 = 512;

/// A glTF file.
#[derive(Debug)]
pub(super) struct Parsed {
    /// Its JSON, parsed.
    pub document: Document,
    bytes: Vec<u8>,
    binary: Option<Range<usize>>,
}

impl Parsed {
    /// The binary chunk of a GLB.
    pub(super) fn binary(&self) -> Option<&[u8]> {
        self.binary.clone().map(|chunk| &self.bytes[chunk])
    }
}

/// Reads, parses and validates the file.
pub(super) fn parse(source: &Source) -> Result<Parsed, SceneError> {
    let bytes = source.read()?;
    let is_binary = bytes.starts_with(b"glTF");
    let format = if is_binary { "binary glTF" } else { "glTF" };
    let syntax =
        |reason: String| SceneError::Syntax { path: source.path.clone(), format, reason: printable(&reason, 200) };
    let (json, binary) = match is_binary {
        true => glb::chunks(&bytes).map(|chunks| (chunks.json, chunks.binary)).map_err(syntax)?,
        false => (0..bytes.len(), None),
    };
    let text = trimmed(&bytes[json]);
    let objects = text.iter().filter(|&&byte| byte == b'{').count() as u64;
    source.take(objects * BYTES_PER_OBJECT, format!("the JSON of {objects} objects"))?;
    let root = root(text).map_err(|error| syntax(reason(text, &error)))?;
    if root.extensions_required.iter().any(|extension| extension == DRACO) {
        return Err(source.compressed(DRACO));
    }
    validate(source, &root)?;
    Ok(Parsed { document: Document::from_json_without_validation(root), bytes, binary })
}

/// Without a byte order mark, and without the NULs that some programs fill a GLB's chunk up with.
fn trimmed(json: &[u8]) -> &[u8] {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    json.iter().rposition(|&byte| byte != 0).map_or(&[], |last| &json[..=last])
}

/// The parser that the library was compiled with: another one of JSON values would be as large as the rest of this crate.
fn root(json: &[u8]) -> Result<Root, serde_json::Error> {
    Root::from_slice(json).or_else(|error| relaxed(json).ok_or(error))
}

/// Why a document is not glTF 2.0: it may be of the first version, which has another shape, or else as the parser says.
fn reason(json: &[u8], error: &serde_json::Error) -> String {
    let document = serde_json::from_slice::<Value>(json).unwrap_or_default();
    match document.pointer("/asset/version").map(|version| version.to_string().replace('"', "")) {
        Some(version) if version.starts_with('1') => format!("its version is {version}, and 2.0 is expected"),
        _ => error.to_string(),
    }
}

/// The document with what is right by the specification, or an extension to it, and unknown to the parser: a scene without
/// nodes, an animation of what is no node, an integer that is written with a point.
fn relaxed(json: &[u8]) -> Option<Root> {
    let mut document: Value = serde_json::from_slice(json).ok()?;
    let mut each = |list: &str, change: fn(&mut Value)| {
        document.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().for_each(change);
    };
    each("scenes", |scene| {
        if let Value::Object(scene) = scene {
            scene.entry("nodes").or_insert_with(|| json!([]));
        }
    });
    each("animations", |animation| {
        let channels = animation.get_mut("channels").and_then(Value::as_array_mut);
        channels.into_iter().for_each(|channels| channels.retain(moves_a_node));
    });
    write_integers(&mut document);
    let again = |document: &Value| Root::from_slice(&serde_json::to_vec(document).ok()?).ok();
    again(&document).or_else(|| again(&at_rest(document)))
}

/// Whether a channel of an animation moves a node; others move what extensions say.
fn moves_a_node(channel: &Value) -> bool {
    channel.pointer("/target/node").is_some_and(Value::is_number)
}

/// The document without its animations and skins, for the `gltf` crate: `animation.rs` and `shape.rs` read them from the document itself.
fn at_rest(mut document: Value) -> Value {
    for (list, none) in [("animations", json!({ "channels": [], "samplers": [] })), ("skins", json!({ "joints": [] }))]
    {
        let each = document.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten();
        each.for_each(|item| *item = none.clone());
    }
    document
}

/// Writes 3 for 3.0, everywhere.
fn write_integers(value: &mut Value) {
    const EXACT: f64 = (1u64 << 53) as f64;
    match value {
        Value::Array(items) => items.iter_mut().for_each(write_integers),
        Value::Object(fields) => fields.values_mut().for_each(write_integers),
        Value::Number(number) => {
            if let Some(whole) = number.as_f64().filter(|x| x.fract() == 0.0 && x.abs() < EXACT) {
                *value = (whole as i64).into();
            }
        }
        _ => {}
    }
}

/// Checks what the `gltf` crate relies on.
fn validate(source: &Source, root: &Root) -> Result<(), SceneError> {
    if !root.asset.version.starts_with("2.") {
        let reason = format!("the version is `{}`", shown(&root.asset.version));
        return Err(source.invalid("asset", reason, "export the scene as glTF 2.0"));
    }
    let mut first = None;
    root.validate(root, Path::new, &mut |path, error| {
        let path = path().to_string();
        if first.is_none() && matters(&path, error) {
            first = Some((path, error));
        }
    });
    first.map_or(Ok(()), |(path, error)| {
        let reason = error.to_string().to_lowercase();
        Err(source.invalid(path, reason, CHECK))
    })
}

/// Whether the renderer relies on what the validator objects to.
///
/// Animations, skins, images and textures are checked where they are read, and one that is broken is a warning; an accessor's data,
/// type and bounds are, too. Of unknown attributes it asks nothing.
fn matters(path: &str, error: Error) -> bool {
    const READ_LENIENTLY: &[&str] = &["animations", "images", "samplers", "skins", "textures"];
    const CHECKED_LATER: &[&str] = &[".bufferView", ".componentType", ".type", ".min", ".max"];
    let lenient = READ_LENIENTLY.iter().any(|part| path.starts_with(part)) || path.contains("<invalid semantic name>");
    let later = path.starts_with("accessors")
        && CHECKED_LATER.iter().any(|end| path.ends_with(end))
        && error != Error::IndexOutOfBounds;
    let bounds = path.contains("[\"POSITION\"].m");
    !(error == Error::Unsupported || lenient || later || bounds)
}
