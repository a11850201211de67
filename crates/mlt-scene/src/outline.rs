//! The content of a scene file, as a tree of names.

/// A node of a scene file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// Number of nodes above it.
    pub depth: usize,
    /// Its name, fit for a terminal.
    pub name: String,
    /// The thing that stands there, in words: a mesh, a camera, a light.
    pub parts: Vec<String>,
}

/// A mesh in words.
pub(crate) fn mesh(triangles: usize, materials: &[String], copies: usize) -> String {
    let mut names: Vec<_> = materials.iter().map(|name| format!("\"{name}\"")).collect();
    names.sort();
    names.dedup();
    let of = if names.is_empty() { String::new() } else { format!(" of {}", names.join(", ")) };
    let times = if copies == 1 { String::new() } else { format!(", {copies} times") };
    let plural = if triangles == 1 { "" } else { "s" };
    format!("{triangles} triangle{plural}{of}{times}")
}
