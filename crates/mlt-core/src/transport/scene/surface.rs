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

/// The surface at a vertex, as it scatters there.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    vertex: &'a Vertex,
    bsdf: &'a Bsdf,
}

impl Scene {
    /// The surface at a vertex.
    #[inline(always)]
    pub fn surface<'a>(&'a self, vertex: &'a Vertex) -> Surface<'a> {
        Surface { vertex, bsdf: &self.material(vertex).bsdf }
    }
}

impl Surface<'_> {
    /// f_s(to_light → to_eye) |ω·N_s|/|ω·N_g|, sr⁻¹, with ω = to_light, and the densities of either direction, given the other,
    /// sr⁻¹; `None` where it is zero.
    #[inline(always)]
    pub fn evaluate(self, to_light: Vec3A, to_eye: Vec3A) -> Option<Evaluation> {
        let (shading, geometric) = cosines(self.vertex, to_light)?;
        cosines(self.vertex, to_eye)?;
        let found = self.bsdf.evaluate(self.vertex.shading_normal, to_light, to_eye);
        (found.value != Rgb::ZERO).then(|| Evaluation { value: found.value * (shading / geometric), ..found })
    }

    /// Draws a direction from three random numbers, or from two where no event is chosen; `None`: absorbed.
    #[inline(always)]
    pub fn sample(self, given: Vec3A, rng: &mut impl Rng) -> Option<Vec3A> {
        let (u, v) = (uniform_f32(rng), uniform_f32(rng));
        let sampled = match self.bsdf {
            Bsdf::Lambert(lambert) => lambert.sample(self.vertex.shading_normal, given, Vec2::new(u, v)),
            bsdf => bsdf.sample(self.vertex.shading_normal, given, [u, v, uniform_f32(rng)])?,
        };
        cosines(self.vertex, sampled).map(|_| sampled)
    }

    /// Draws a direction towards the light, and says what comes from there.
    #[inline(always)]
    pub fn sample_to_light(self, to_eye: Vec3A, rng: &mut impl Rng) -> Option<Sampled> {
        let to_light = self.sample(to_eye, rng)?;
        if let Bsdf::Lambert(lambert) = self.bsdf {
            cosines(self.vertex, to_eye)?;
            let pdf = self.vertex.shading_normal.dot(to_light).abs() * FRAC_1_PI;
            return Some(Sampled { to_light, weight: lambert.reflectance, pdf });
        }
        let found = self.evaluate(to_light, to_eye)?;
        let cos = self.vertex.geometric_normal.dot(to_light).abs();
        Some(Sampled { to_light, weight: found.value * (cos / found.pdf_to_light), pdf: found.pdf_to_light })
    }

    /// The direction that a delta BSDF joins to `given` by reflection or by transmission.
    #[inline]
    pub fn delta_direction(self, given: Vec3A, transmit: bool) -> Option<Vec3A> {
        let direction = self.bsdf.delta_direction(self.vertex.shading_normal, given, transmit)?;
        cosines(self.vertex, direction).map(|_| direction)
    }

    /// Probability with which a delta BSDF's sampling chooses the event that joins the two directions.
    #[inline]
    pub fn event_probability(self, given: Vec3A, sampled: Vec3A) -> f32 {
        self.bsdf.event_probability(self.vertex.shading_normal, given, sampled)
    }
}

/// |ω·N_s| and |ω·N_g|; `None` if ω is on different sides of the two, or tangent.
#[inline(always)]
fn cosines(vertex: &Vertex, direction: Vec3A) -> Option<(f32, f32)> {
    let shading = vertex.shading_normal.dot(direction);
    let geometric = vertex.geometric_normal.dot(direction);
    (shading * geometric > 0.0).then(|| (shading.abs(), geometric.abs()))
}
