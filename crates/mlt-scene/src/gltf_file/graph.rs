//! The node graph, flattened.

use super::CHECK;
use crate::{SceneError, source::Source, text::shown};
use glam::{DMat4, DQuat, DVec3};
use gltf::{Document, Node, Scene, scene::Transform};

/// A node and its transform to world space.
pub(super) type Placed<'a> = (Node<'a>, DMat4);

/// The node graph, of which each node is reached once.
pub(super) struct Graph<'a> {
    document: &'a Document,
    reached: Vec<bool>,
}

impl<'a> Graph<'a> {
    /// The graph of a document, of which nothing is reached yet.
    pub fn new(document: &'a Document) -> Self {
        Self { document, reached: vec![false; document.nodes().len()] }
    }

    /// The nodes of the scene of this name, or of the default one, in the file's order.
    ///
    /// A node that is reached twice makes the graph no tree, which also finds every cycle.
    pub fn shown(&mut self, source: &Source, name: Option<&str>) -> Result<Vec<Placed<'a>>, SceneError> {
        let scene = match name {
            Some(name) => Some(self.scene(source, name)?),
            None => self.document.default_scene().or_else(|| self.document.scenes().next()),
        };
        let roots = scene.map_or_else(|| self.roots(), |scene| scene.nodes().collect());
        let reason = "the node has two parents or is its own ancestor";
        self.flatten(roots).map_err(|node| source.invalid(place(&node), reason, CHECK))
    }

    fn scene(&self, source: &Source, name: &str) -> Result<Scene<'a>, SceneError> {
        let found = self.document.scenes().find(|scene| scene.name() == Some(name));
        let names = || self.document.scenes().filter_map(|scene| scene.name()).collect::<Vec<_>>();
        found.ok_or_else(|| source.no_scene(name, &names()))
    }

    /// The nodes outside of it; empty where they are no trees.
    pub fn others(&mut self) -> Vec<Placed<'a>> {
        let mut roots = self.roots();
        roots.retain(|root| !self.reached[root.index()]);
        self.flatten(roots).unwrap_or_default()
    }

    /// Every node that is nobody's child.
    fn roots(&self) -> Vec<Node<'a>> {
        let mut is_root = vec![true; self.reached.len()];
        self.document.nodes().flat_map(|n| n.children()).for_each(|child| is_root[child.index()] = false);
        self.document.nodes().filter(|n| is_root[n.index()]).collect()
    }

    /// The trees below some roots, depth first; or the node at which they are no trees.
    fn flatten(&mut self, roots: Vec<Node<'a>>) -> Result<Vec<Placed<'a>>, Node<'a>> {
        let mut pending: Vec<_> = roots.into_iter().map(|node| (node, DMat4::IDENTITY)).collect();
        pending.reverse();
        let mut flat = Vec::new();
        while let Some((node, parent)) = pending.pop() {
            if std::mem::replace(&mut self.reached[node.index()], true) {
                return Err(node);
            }
            let to_world = parent * local(&node);
            let first_child = pending.len();
            pending.extend(node.children().map(|child| (child, to_world)));
            pending[first_child..].reverse();
            flat.push((node, to_world));
        }
        Ok(flat)
    }
}

/// How messages name a node.
pub(super) fn place(node: &Node) -> String {
    match node.name() {
        Some(name) => format!("nodes[{}] `{}`", node.index(), shown(name)),
        None => format!("nodes[{}]", node.index()),
    }
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
