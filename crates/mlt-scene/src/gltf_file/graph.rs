//! The node graph, flattened.

use super::{CHECK, animation::Pose};
use crate::{SceneError, source::Source, text::shown};
use glam::DMat4;
use gltf::{Document, Node, Scene};

/// A node and its transform to world space.
pub(super) type Placed<'a> = (Node<'a>, DMat4);

/// The node graph, of which each node is reached once.
pub(super) struct Graph<'a> {
    document: &'a Document,
    pose: &'a Pose,
    reached: Vec<bool>,
}

impl<'a> Graph<'a> {
    /// The graph of a document in a pose, of which nothing is reached yet.
    pub(super) fn new(document: &'a Document, pose: &'a Pose) -> Self {
        Self { document, pose, reached: vec![false; document.nodes().len()] }
    }

    /// The nodes of the scene of this name, or of the default one, in the file's order.
    ///
    /// A node that is reached twice makes the graph no tree, which also finds every cycle.
    pub(super) fn shown(&mut self, source: &Source, name: Option<&str>) -> Result<Vec<Placed<'a>>, SceneError> {
        let roots = self.chosen(source, name)?.map_or_else(|| self.roots(), |scene| scene.nodes().collect());
        let reason = "the node has two parents or is its own ancestor";
        self.flatten(roots).map_err(|node| source.invalid(place(&node), reason, CHECK))
    }

    /// The scene of this name, or the default one, if the file has any.
    pub(super) fn chosen(&self, source: &Source, name: Option<&str>) -> Result<Option<Scene<'a>>, SceneError> {
        match name {
            Some(name) => self.scene(source, name).map(Some),
            None => Ok(self.document.default_scene().or_else(|| self.document.scenes().next())),
        }
    }

    fn scene(&self, source: &Source, name: &str) -> Result<Scene<'a>, SceneError> {
        let found = self.document.scenes().find(|scene| scene.name() == Some(name));
        let names = || self.document.scenes().filter_map(|scene| scene.name()).collect::<Vec<_>>();
        found.ok_or_else(|| source.no_scene(name, &names()))
    }

    /// The nodes outside of it; empty where they are no trees.
    pub(super) fn others(&mut self) -> Vec<Placed<'a>> {
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
            let to_world = parent * self.pose.local(&node);
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
