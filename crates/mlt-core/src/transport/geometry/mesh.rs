//! Indexed triangle meshes in world space.

use glam::{DVec3, Vec3};

/// Triangles that share one material; transforms are already applied.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the scene file, for messages.
    pub name: String,
    /// World positions; f64, so that a far-away scene can be moved to the origin without loss.
    pub positions: Vec<DVec3>,
    /// Unit shading normals, one a position; empty: the triangles' own normals.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the scene's materials.
    pub material: u32,
}
