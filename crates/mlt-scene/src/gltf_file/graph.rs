//! The node graph, flattened.

use super::CHECK;
use crate::{SceneError, source::Source};
use glam::{DMat4, DQuat, DVec3};
use gltf::{Document, Node, scene::Transform};

/// The nodes of the scene to show, in the file's order, each with its transform to world space.
///
/// A node that is reached twice makes the graph no tree, which also finds every cycle.
pub(super) fn nodes<'a>(source: &Source, document: &'a Document) -> Result<Vec<(Node<'a>, DMat4)>, SceneError> {
    let mut pending: Vec<_> = roots(document).into_iter().map(|node| (node, DMat4::IDENTITY)).collect();
    pending.reverse();
    let mut reached = vec![false; document.nodes().len()];
    let mut flat = Vec::new();
    while let Some((node, parent)) = pending.pop() {
        if std::mem::replace(&mut reached[node.index()], true) {
            let reason = "the node has two parents or is its own ancestor";
            return Err(source.invalid(place(&node), reason, CHECK));
        }
        let to_world = parent * local(&node);
        let first_child = pending.len();
        pending.extend(node.children().map(|child| (child, to_world)));
        pending[first_child..].reverse();
        flat.push((node, to_world));
    }
    Ok(flat)
}

/// How messages name a node.
pub(super) fn place(node: &Node) -> String {
    match node.name() {
        Some(name) => format!("nodes[{}] `{name}`", node.index()),
        None => format!("nodes[{}]", node.index()),
    }
}

/// The default scene's roots; a file without scenes: every node that is nobody's child.
fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let mut is_root = vec![true; document.nodes().len()];
    document.nodes().flat_map(|n| n.children()).for_each(|child| is_root[child.index()] = false);
    document.nodes().filter(|n| is_root[n.index()]).collect()
}

fn local(node: &Node) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let length = rotation.length();
            let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
            let [translation, scale] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
    }
}
