//! Where a shape stands that has coordinates of its own.
//!
//! **Errors.** A ray of the scene is met in the shape's coordinates, with the same t. Let A take the shape to the scene and W be
//! its inverse, ε = 2⁻²⁴, and n the unit normal of a triangle of the shape. Wᵀn is normal to it in the scene, and a distance δ
//! along n is δ/|Wᵀn| there. Positions are mapped in f64 and rounded once. What that costs at a point p is at most ε max|p_j| an
//! axis; what the rounding of a ray costs that comes from as far away is at most ε max|p_j| Σ_j |W_ij| along axis i of the shape.
//! So the bound on a position's error is
//!
//! ```text
//! e / |Wᵀn| + f γ max|p_j|,    γ = Σ_i |n_i| Σ_j |W_ij| / |Wᵀn|,
//! ```
//!
//! e the bound in the shape's coordinates and f the [`ERROR_FACTOR`] that the scene's own triangles have. γ is 1 to 3 where the
//! shape is only turned and scaled, along its own axes as differently as may be; it is large where it is sheared flat.

use super::{ERROR_FACTOR, Ray, Vertex};
use glam::{DAffine3, DVec3, Vec3, Vec3A};

/// Largest product of the lengths of a map and its inverse for the latter to be of use.
const WORST_CONDITION: f64 = 1e9;

/// An invertible affine map from a shape's coordinates to the scene's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    to_scene: DAffine3,
    to_shape: DAffine3,
    /// Σ_j |W_ij| of each axis i of the shape.
    spread: DVec3,
}

impl Placement {
    /// `None`: it cannot be inverted.
    pub(crate) fn new(to_scene: DAffine3) -> Option<Self> {
        let to_shape = to_scene.inverse();
        let [whole, back] =
            [to_scene, to_shape].map(|map| map.matrix3.to_cols_array().map(|x| x * x).iter().sum::<f64>());
        let is_usable =
            to_scene.is_finite() && to_shape.is_finite() && whole * back < WORST_CONDITION * WORST_CONDITION;
        let rows = to_shape.matrix3.transpose();
        let spread = DVec3::from_array([rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.abs().element_sum()));
        is_usable.then_some(Self { to_scene, to_shape, spread })
    }

    /// −1 where left and right change places, else 1.
    pub(crate) fn handedness(&self) -> f32 {
        1f32.copysign(self.to_scene.matrix3.determinant() as f32)
    }

    /// A ray of the scene in the shape's coordinates.
    #[inline]
    pub(crate) fn ray(&self, ray: &Ray) -> Ray {
        let origin = self.to_shape.transform_point3(ray.origin.as_dvec3()).as_vec3();
        let direction = self.to_shape.transform_vector3(ray.direction.as_dvec3()).as_vec3();
        Ray { origin, direction, t_max: ray.t_max }
    }

    /// A point of the scene in the shape's coordinates.
    pub(crate) fn point_in_shape(&self, point: Vec3A) -> Vec3A {
        self.to_shape.transform_point3(point.as_dvec3()).as_vec3a()
    }

    /// A vector along a surface of the shape, in the scene.
    pub(crate) fn vector(&self, vector: Vec3A) -> Vec3A {
        self.to_scene.transform_vector3(vector.as_dvec3()).as_vec3a()
    }

    /// A unit normal of the shape in the scene.
    pub(crate) fn normal(&self, normal: Vec3A) -> Vec3A {
        (self.to_shape.matrix3.transpose() * normal.as_dvec3()).normalize_or_zero().as_vec3a()
    }

    /// A vertex of the shape in the scene. Its shading normal is the triangle's own.
    pub(crate) fn vertex(&self, vertex: Vertex) -> Vertex {
        let normal = self.to_shape.matrix3.transpose() * vertex.geometric_normal.as_dvec3();
        let length = normal.length();
        let position = self.to_scene.transform_point3(vertex.position.as_dvec3()).as_vec3a();
        let gamma = vertex.geometric_normal.as_dvec3().abs().dot(self.spread) / length;
        let error = f64::from(vertex.error) / length + f64::from(ERROR_FACTOR * position.abs().max_element()) * gamma;
        let normal = (normal / length).as_vec3a();
        Vertex { position, geometric_normal: normal, shading_normal: normal, error: error as f32, ..vertex }
    }

    /// The scene's box around a box of the shape, with room for what rounding does to rays.
    pub(crate) fn bounds(&self, [low, high]: [Vec3; 2]) -> [Vec3; 2] {
        let [low, high] = [low, high].map(|corner| corner.as_dvec3());
        let sides = self.to_scene.matrix3;
        let abs = [sides.x_axis, sides.y_axis, sides.z_axis].map(DVec3::abs);
        let reach = |v: DVec3| v.x * abs[0] + v.y * abs[1] + v.z * abs[2];
        let (centre, half) = (self.to_scene.transform_point3(0.5 * (low + high)), reach(0.5 * (high - low)));
        let farthest = centre.abs() + half;
        let room = half + f64::from(ERROR_FACTOR) * farthest.max_element() * reach(self.spread).max(DVec3::ONE);
        [(centre - room).as_vec3(), (centre + room).as_vec3()]
    }
}
