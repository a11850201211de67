//! Texture coordinates, colours and tangents of a scene's vertices.

use crate::transport::colour::Rgb;
use crate::transport::geometry::Mesh;
use glam::{Vec2, Vec3A, Vec4, Vec4Swizzles};

/// Coordinates that a mesh's textures are placed by, interpolated to one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinates {
    /// Of both sets; (0, 0) where the mesh has none.
    pub uv: [Vec2; 2],
    /// Factor on the base colour and on the opacity.
    pub colour: Vec4,
}

/// Attributes of the vertices of all meshes, beyond their positions and normals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Attributes {
    meshes: Vec<MeshAttributes>,
    /// The mesh of each triangle.
    mesh_of: Vec<u32>,
}

#[derive(Clone, Debug, Default)]
struct MeshAttributes {
    /// Number of its first triangle in the scene.
    first: u32,
    triangles: Vec<[u32; 3]>,
    uv: [Vec<Vec2>; 2],
    colours: Vec<Vec4>,
    tangents: Vec<Vec4>,
}

impl Attributes {
    /// Those of some meshes, from which they are taken away.
    pub(crate) fn take<'a>(meshes: impl Iterator<Item = &'a mut Mesh>) -> Self {
        let mut all = Self::default();
        for (number, mesh) in (0..).zip(meshes) {
            let Mesh { triangles, uv, colours, tangents, .. } = std::mem::take(mesh);
            let first = all.mesh_of.len() as u32;
            all.mesh_of.extend(std::iter::repeat_n(number, triangles.len()));
            all.meshes.push(MeshAttributes { first, triangles, uv, colours, tangents });
        }
        all
    }

    /// Memory that they take, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let of_mesh = |mesh: &MeshAttributes| {
            let uv: usize = mesh.uv.iter().map(|set| size_of_val(&set[..])).sum();
            uv + size_of_val(&mesh.triangles[..]) + size_of_val(&mesh.colours[..]) + size_of_val(&mesh.tangents[..])
        };
        size_of_val(&self.mesh_of[..]) + self.meshes.iter().map(of_mesh).sum::<usize>()
    }

    /// On a mesh that is not taken yet, at barycentric weights of a triangle's second and third vertex.
    pub(crate) fn on(mesh: &Mesh, corners: [u32; 3], weights: [f32; 2]) -> Coordinates {
        coordinates(&mesh.uv, &mesh.colours, corners, weights)
    }

    /// At the point of a triangle where its second and third vertex have these barycentric weights.
    #[inline]
    pub(crate) fn at(&self, primitive: u32, weights: [f32; 2]) -> Coordinates {
        let (mesh, corners) = self.corners(primitive);
        coordinates(&mesh.uv, &mesh.colours, corners, weights)
    }

    /// Tangent, along which u grows, of any length, and the sign of the bitangent, along which v falls as it does in an image, at a point
    /// of a triangle with these edges from its first vertex: the file's, or else those of the triangle; `None`: there are no coordinates.
    pub(crate) fn tangent(
        &self,
        primitive: u32,
        weights: [f32; 2],
        set: usize,
        [e, f]: [Vec3A; 2],
    ) -> Option<(Vec3A, f32)> {
        let (mesh, corners) = self.corners(primitive);
        if let Some(tangent) = interpolated(&mesh.tangents, corners, weights) {
            return Some((tangent.xyz().into(), tangent.w.signum()));
        }
        let uv = corners.map(|corner| mesh.uv[set].get(corner as usize).copied());
        let [a, b, c] = [uv[0]?, uv[1]?, uv[2]?];
        let [p, q] = [b - a, c - a];
        let area = p.perp_dot(q);
        // In glTF v grows downwards, and a normal map's y upwards.
        let sign = 1f32.copysign(area);
        let along = sign * (q.y * e - p.y * f);
        (along.length_squared() > 0.0).then_some((along, -sign))
    }

    #[inline]
    fn corners(&self, primitive: u32) -> (&MeshAttributes, [u32; 3]) {
        let mesh = &self.meshes[self.mesh_of[primitive as usize] as usize];
        (mesh, mesh.triangles[(primitive - mesh.first) as usize])
    }
}

#[inline]
fn coordinates(uv: &[Vec<Vec2>; 2], colours: &[Vec4], corners: [u32; 3], weights: [f32; 2]) -> Coordinates {
    let uv = uv.each_ref().map(|set| interpolated(set, corners, weights).unwrap_or_default());
    Coordinates { uv, colour: interpolated(colours, corners, weights).unwrap_or(Vec4::ONE) }
}

/// `None`: the mesh has no such attribute.
#[inline]
fn interpolated<T>(values: &[T], corners: [u32; 3], [u, v]: [f32; 2]) -> Option<T>
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    let [a, b, c] = corners.map(|corner| values.get(corner as usize).copied());
    Some(a? * (1.0 - u - v) + b? * u + c? * v)
}

impl Coordinates {
    /// The vertices' colour.
    pub(crate) fn rgb(&self) -> Rgb {
        self.colour.xyz()
    }
}
