//! Scattering at a vertex: a BSDF about the shading normal, on the geometric surface.
//!
//! A direction counts only if it lies on the same side of the shading and of the geometric normal. In a path the BSDF is
//! f_s |ω·N_s|/|ω·N_g| with ω towards the light: the cosine that the shading normal asks for, over the one that the
//! geometric term holds. Light subpaths evaluate the same function, which is the adjoint correction.
//!
//! Source: [Veach97], section 5.3.

use super::Scene;
use crate::engine::uniform_f32;
use crate::transport::bsdf::{Bsdf, Evaluation};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::cosine_hemisphere;
use glam::{Vec2, Vec3A};
use rand_pcg::rand_core::Rng;
use std::f32::consts::FRAC_1_PI;

/// A direction drawn at a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// Unit vector.
    pub to_light: Vec3A,
    /// f_s |ω·N_s| over the density, ω = to_light: dimensionless.
    pub weight: Rgb,
    /// Density per unit solid angle, sr⁻¹.
    pub pdf: f32,
}

impl Scene {
    /// f_s(to_light → to_eye) |ω·N_s|/|ω·N_g|, sr⁻¹, with ω = to_light; `None` where it is zero.
    #[inline]
    pub fn scatter(&self, vertex: &Vertex, to_light: Vec3A, to_eye: Vec3A) -> Option<Rgb> {
        let (shading, geometric) = cosines(vertex, to_light)?;
        cosines(vertex, to_eye)?;
        let f = self.material(vertex).bsdf.eval(vertex.shading_normal, to_light, to_eye);
        (f != Rgb::ZERO).then(|| f * (shading / geometric))
    }

    /// [`scatter`](Self::scatter) with the densities of either direction, given the other, sr⁻¹.
    #[inline(always)]
    pub fn evaluate(&self, vertex: &Vertex, to_light: Vec3A, to_eye: Vec3A) -> Option<Evaluation> {
        let (shading, geometric) = cosines(vertex, to_light)?;
        cosines(vertex, to_eye)?;
        let found = self.material(vertex).bsdf.evaluate(vertex.shading_normal, to_light, to_eye);
        (found.value != Rgb::ZERO).then(|| Evaluation { value: found.value * (shading / geometric), ..found })
    }

    /// Density per unit solid angle with which [`sample`](Self::sample) draws `sampled`, sr⁻¹.
    #[inline]
    pub fn pdf(&self, vertex: &Vertex, given: Vec3A, sampled: Vec3A) -> f32 {
        self.material(vertex).bsdf.pdf(vertex.shading_normal, given, sampled)
    }

    /// Draws a direction from three random numbers, or from two where no event is chosen; `None`: absorbed.
    #[inline(always)]
    pub fn sample(&self, vertex: &Vertex, given: Vec3A, rng: &mut impl Rng) -> Option<Vec3A> {
        let bsdf = &self.material(vertex).bsdf;
        let (u, v) = (uniform_f32(rng), uniform_f32(rng));
        let sampled = match bsdf {
            Bsdf::Lambert(lambert) => lambert.sample(vertex.shading_normal, given, Vec2::new(u, v)),
            _ => bsdf.sample(vertex.shading_normal, given, [u, v, uniform_f32(rng)])?,
        };
        cosines(vertex, sampled).map(|_| sampled)
    }

    /// Draws a direction towards the light, and says what comes from there.
    #[inline(always)]
    pub fn sample_to_light(&self, vertex: &Vertex, to_eye: Vec3A, rng: &mut impl Rng) -> Option<Sampled> {
        let to_light = self.sample(vertex, to_eye, rng)?;
        if let Bsdf::Lambert(lambert) = &self.material(vertex).bsdf {
            cosines(vertex, to_eye)?;
            let pdf = vertex.shading_normal.dot(to_light).abs() * FRAC_1_PI;
            return Some(Sampled { to_light, weight: lambert.reflectance, pdf });
        }
        let found = self.evaluate(vertex, to_light, to_eye)?;
        let cos = vertex.geometric_normal.dot(to_light).abs();
        Some(Sampled { to_light, weight: found.value * (cos / found.pdf_to_light), pdf: found.pdf_to_light })
    }

    /// The direction that a delta BSDF joins to `given` by reflection or by transmission.
    #[inline]
    pub fn delta_direction(&self, vertex: &Vertex, given: Vec3A, transmit: bool) -> Option<Vec3A> {
        let direction = self.material(vertex).bsdf.delta_direction(vertex.shading_normal, given, transmit)?;
        cosines(vertex, direction).map(|_| direction)
    }

    /// Probability with which a delta BSDF's sampling chooses the event that joins the two directions.
    #[inline]
    pub fn event_probability(&self, vertex: &Vertex, given: Vec3A, sampled: Vec3A) -> f32 {
        self.material(vertex).bsdf.event_probability(vertex.shading_normal, given, sampled)
    }

    /// Draws the direction that a light subpath starts into, with density cosθ/π, or half that on each of two sides.
    #[inline(always)]
    pub(crate) fn sample_emission(&self, vertex: &Vertex, rng: &mut impl Rng) -> Vec3A {
        let u = Vec2::new(uniform_f32(rng), uniform_f32(rng));
        let back = self.material(vertex).emits_both_sides && uniform_f32(rng) < 0.5;
        cosine_hemisphere(if back { -vertex.geometric_normal } else { vertex.geometric_normal }, u)
    }
}

/// |ω·N_s| and |ω·N_g|; `None` if ω is on different sides of the two, or tangent.
#[inline(always)]
fn cosines(vertex: &Vertex, direction: Vec3A) -> Option<(f32, f32)> {
    let shading = vertex.shading_normal.dot(direction);
    let geometric = vertex.geometric_normal.dot(direction);
    (shading * geometric > 0.0).then(|| (shading.abs(), geometric.abs()))
}
