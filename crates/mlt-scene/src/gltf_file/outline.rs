//! The nodes of a document, as a tree of names.

use super::graph::Placed;
use super::{instance, primitive};
use crate::{
    outline::{Entry, mesh},
    text::shown,
};
use gltf::{Document, Node, khr_lights_punctual::Kind};
use std::collections::HashMap;

/// The tree of nodes that are given depth first.
pub(super) fn outline(document: &Document, nodes: &[Placed]) -> Vec<Entry> {
    let mut depths = HashMap::new();
    let entry = |(node, _): &Placed| {
        let depth = depths.remove(&node.index()).unwrap_or(0);
        depths.extend(node.children().map(|child| (child.index(), depth + 1)));
        let name = node.name().or_else(|| node.mesh()?.name()).map_or_else(|| format!("node {}", node.index()), shown);
        Entry { depth, name, parts: parts(document, node) }
    };
    nodes.iter().map(entry).collect()
}

fn parts(document: &Document, node: &Node) -> Vec<String> {
    let mesh = node.mesh().map(|found| {
        let triangles = found.primitives().map(|p| primitive::triangle_count(&p)).sum();
        let materials: Vec<_> = found.primitives().filter_map(|p| p.material().name().map(shown)).collect();
        mesh(triangles, &materials, instance::count(document, node))
    });
    let light = node.light().map(|light| match light.kind() {
        Kind::Directional => "sun".to_owned(),
        Kind::Point => "point light".to_owned(),
        Kind::Spot { .. } => "spot light".to_owned(),
    });
    let camera = node.camera().map(|_| "camera".to_owned());
    mesh.into_iter().chain(camera).chain(light).collect()
}
