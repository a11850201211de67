//! Scattering at a vertex: a BSDF about the shading normal, on the geometric surface.
//!
//! A direction counts only if it lies on the same side of the shading and of the geometric normal. In a path the BSDF is
//! f_s |ω·N_s|/|ω·N_g| with ω towards the light: the cosine that the shading normal asks for, over the one that the
//! geometric term holds. Light subpaths evaluate the same function, which is the adjoint correction.
//!
//! Source: [Veach97], section 5.3.

use super::Rgb;
use super::math::cosine_hemisphere;
use super::scene::Scene;
use super::vertex::Vertex;
use crate::engine::uniform_f32;
use glam::{Vec2, Vec3};
use rand_pcg::rand_core::Rng;

impl Scene {
    /// f_s(to_light → to_eye) |ω·N_s|/|ω·N_g|, sr⁻¹, with ω = to_light; `None` where it is zero.
    #[inline]
    pub fn scatter(&self, vertex: &Vertex, to_light: Vec3, to_eye: Vec3) -> Option<Rgb> {
        let (shading, geometric) = cosines(vertex, to_light)?;
        cosines(vertex, to_eye)?;
        let f = self.material(vertex).bsdf.eval(vertex.shading_normal, to_light, to_eye);
        (f != Rgb::ZERO).then(|| f * (shading / geometric))
    }

    /// Density per unit solid angle with which [`sample`](Self::sample) draws `sampled`, sr⁻¹.
    #[inline]
    pub fn pdf(&self, vertex: &Vertex, given: Vec3, sampled: Vec3) -> f32 {
        self.material(vertex).bsdf.pdf(vertex.shading_normal, given, sampled)
    }

    /// Draws a direction from three random numbers; `None`: absorbed.
    #[inline]
    pub fn sample(&self, vertex: &Vertex, given: Vec3, rng: &mut impl Rng) -> Option<Vec3> {
        let u = [uniform_f32(rng), uniform_f32(rng), uniform_f32(rng)];
        let sampled = self.material(vertex).bsdf.sample(vertex.shading_normal, given, u)?;
        cosines(vertex, sampled).map(|_| sampled)
    }

    /// The direction that a delta BSDF joins to `given` by reflection or by transmission.
    #[inline]
    pub fn delta_direction(&self, vertex: &Vertex, given: Vec3, transmit: bool) -> Option<Vec3> {
        let direction = self.material(vertex).bsdf.delta_direction(vertex.shading_normal, given, transmit)?;
        cosines(vertex, direction).map(|_| direction)
    }

    /// Probability with which a delta BSDF's sampling chooses the event that joins the two directions.
    #[inline]
    pub fn event_probability(&self, vertex: &Vertex, given: Vec3, sampled: Vec3) -> f32 {
        self.material(vertex).bsdf.event_probability(vertex.shading_normal, given, sampled)
    }

    /// Draws the direction that a light subpath starts into, with density cosθ/π, or half that on each of two sides.
    #[inline]
    pub(super) fn sample_emission(&self, vertex: &Vertex, rng: &mut impl Rng) -> Vec3 {
        let u = [uniform_f32(rng), uniform_f32(rng), uniform_f32(rng)];
        let back = self.material(vertex).emits_both_sides && u[2] < 0.5;
        let n = if back { -vertex.geometric_normal } else { vertex.geometric_normal };
        cosine_hemisphere(n, Vec2::new(u[0], u[1]))
    }
}

/// |ω·N_s| and |ω·N_g|; `None` if ω is on different sides of the two, or tangent.
#[inline]
fn cosines(vertex: &Vertex, direction: Vec3) -> Option<(f32, f32)> {
    let shading = vertex.shading_normal.dot(direction);
    let geometric = vertex.geometric_normal.dot(direction);
    (shading * geometric > 0.0).then(|| (shading.abs(), geometric.abs()))
}
