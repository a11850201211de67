//! Indexed triangle meshes.

use glam::{DVec3, Vec2, Vec3, Vec4};

/// Triangles that share one material, in world space, but for those of a [`Prototype`](crate::transport::scene::Prototype).
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the scene file, for messages.
    pub name: String,
    /// Positions; f64, so that a far-away scene can be moved to the origin without loss.
    pub positions: Vec<DVec3>,
    /// Unit shading normals, one a position; empty: the triangles' own normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of two sets, one a position; empty: (0, 0) everywhere.
    pub uv: [Vec<Vec2>; 2],
    /// Linear RGBA, one a position, a factor on base colour and opacity; empty: white.
    pub colours: Vec<Vec4>,
    /// Tangents for normal maps, one a position: direction in which u grows, and the sign of the bitangent; empty: those of the
    /// triangles.
    pub tangents: Vec<Vec4>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the scene's materials.
    pub material: u32,
}

impl Mesh {
    /// Two triangles, counter-clockwise where the corners are.
    pub fn quad(corners: [DVec3; 4]) -> Self {
        Self { positions: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Self::default() }
    }
}

/// The corners of all triangles of some meshes.
pub(crate) fn points(meshes: &[Mesh]) -> impl Iterator<Item = DVec3> + Clone {
    meshes.iter().flat_map(|m| m.triangles.iter().flatten().map(|&i| m.positions[i as usize]))
}
