//! Emission of a vertex on a light: the same radiance in every direction of its front, or of both of its sides.

use crate::engine::uniform_f32;
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::cosine_hemisphere;
use crate::transport::scene::Scene;
use glam::{Vec2, Vec3A};
use rand_pcg::rand_core::Rng;
use std::f32::consts::FRAC_1_PI;

impl Scene {
    /// Radiance that a vertex emits into a direction; none where another surface is seen in its place.
    #[inline(always)]
    pub fn emitted(&self, vertex: &Vertex, direction: Vec3A) -> Rgb {
        let material = self.material(vertex);
        let lit = material.emits_both_sides || vertex.geometric_normal.dot(direction) > 0.0;
        if lit && !self.is_hidden(vertex, direction) { material.emission } else { Rgb::ZERO }
    }

    /// Draws the direction that a light subpath starts into.
    #[inline(always)]
    pub(crate) fn sample_emission(&self, vertex: &Vertex, rng: &mut impl Rng) -> Vec3A {
        let u = Vec2::new(uniform_f32(rng), uniform_f32(rng));
        let back = self.material(vertex).emits_both_sides && uniform_f32(rng) < 0.5;
        cosine_hemisphere(if back { -vertex.geometric_normal } else { vertex.geometric_normal }, u)
    }

    /// Density of that direction, sr⁻¹: cosθ/π, or half that on each of two sides.
    #[inline(always)]
    pub(crate) fn pdf_emission(&self, vertex: &Vertex, direction: Vec3A) -> f32 {
        let cos = vertex.geometric_normal.dot(direction);
        if self.material(vertex).emits_both_sides { 0.5 * cos.abs() * FRAC_1_PI } else { cos.max(0.0) * FRAC_1_PI }
    }
}
