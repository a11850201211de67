//! Copies of a node's mesh (EXT_mesh_gpu_instancing).

use super::accessor::{Reader, Vectors};
use super::graph::{Placed, place};
use super::rotation::rotation;
use crate::SceneError;
use glam::{DMat4, DQuat, DVec3};
use gltf::{Accessor, Document, Node};
use serde_json::Value;
use std::rc::Rc;

/// The extension's name.
pub(super) const NAME: &str = "EXT_mesh_gpu_instancing";

/// The accessor of one of the copies' properties.
fn property<'a>(document: &'a Document, node: &Node, name: &str) -> Option<Accessor<'a>> {
    let index = node.extension_value(NAME)?.get("attributes")?.get(name).and_then(Value::as_u64)?;
    document.accessors().nth(usize::try_from(index).ok()?)
}

/// Number of copies at a node, known without their data.
pub(super) fn count(document: &Document, node: &Node) -> usize {
    let counts = ["TRANSLATION", "ROTATION", "SCALE"].map(|name| property(document, node, name).map(|a| a.count()));
    counts.into_iter().flatten().min().unwrap_or(1)
}

/// Where copies of a node's mesh stand: at the node itself if it has none.
pub(super) fn places(
    reader: &mut Reader,
    document: &Document,
    (node, to_world): &Placed,
    warnings: &mut Vec<String>,
) -> Result<Vec<DMat4>, SceneError> {
    if node.extension_value(NAME).is_none() {
        return Ok(vec![*to_world]);
    }
    let mut read = |name: &str| -> Result<Option<Rc<Vectors>>, SceneError> {
        property(document, node, name).map(|accessor| reader.any_vectors(&accessor)).transpose()
    };
    let [translations, rotations, scales] = [read("TRANSLATION")?, read("ROTATION")?, read("SCALE")?];
    if [&translations, &rotations, &scales].iter().all(|found| found.is_none()) {
        warnings.push(format!("{}: {NAME} does not say where its copies are; there is one, at the node", place(node)));
        return Ok(vec![*to_world]);
    }
    let vector = |found: &Option<Rc<Vectors>>, i: u32, usual: DVec3| {
        found.as_ref().map_or(usual, |found| DVec3::from_array(found.at::<3>(i).map(f64::from)))
    };
    let copy = |i: u32| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |found| rotation(found.at::<4>(i)));
        let (scale, translation) = (vector(&scales, i, DVec3::ONE), vector(&translations, i, DVec3::ZERO));
        *to_world * DMat4::from_scale_rotation_translation(scale, rotation, translation)
    };
    Ok((0..count(document, node) as u32).map(copy).collect())
}
