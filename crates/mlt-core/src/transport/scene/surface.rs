//! Scattering at a vertex: a BSDF about the shading normal, on the geometric surface.
//!
//! A direction counts only if it lies on the same side of the shading and of the geometric normal. In a path the BSDF is
//! f_s |ω·N_s|/|ω·N_g| with ω towards the light: the cosine that the shading normal asks for, over the one that the
//! geometric term holds. Light subpaths evaluate the same function, which is the adjoint correction.
//!
//! Where a normal map bends the normal, that quotient has no bound: light is cut off along a line where N_g still faces it, and
//! little before it f_s is largest. There it has the factor S = g + g² − g³ of g = min(1, |ω·N_g|/(|ω·N_s| N_s·N_g)), which is at
//! most 1 and 1 wherever N_g sees no less of the light than N_s does. docs/theory-surfaces.md, "Normal maps".
//!
//! Sources: [Veach97], section 5.3; Chiang et al., "Taming the Shadow Terminator", SIGGRAPH talks, 2019.

use super::{Scene, Textured};
use crate::engine::uniform_f32;
use crate::transport::bsdf::{Bsdf, Evaluation, NarrowLobe};
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
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    vertex: &'a Vertex,
    bsdf: &'a Bsdf,
    /// Whether a normal map bends the shading normal of a BSDF that is not delta.
    bent: bool,
}

/// Room for the BSDF of one point of a textured surface: the caller's, so that nothing is allocated, and nothing copied where nothing is
/// textured.
#[derive(Debug, Default)]
pub struct Resolved(Option<Bsdf>);

impl Scene {
    /// The surface at a vertex.
    #[inline(always)]
    pub fn surface<'a>(&'a self, vertex: &'a Vertex, room: &'a mut Resolved) -> Surface<'a> {
        let material = self.material(vertex);
        if self.needs.textured
            && let Some(textured) = &material.textured
        {
            let bsdf = self.resolve(textured, *vertex, room);
            return Surface { vertex, bsdf, bent: textured.maps.normal.is_some() && !bsdf.is_delta() };
        }
        Surface { vertex, bsdf: &material.bsdf, bent: false }
    }

    /// The BSDF of a textured surface at a vertex. Takes vertices by value: a reference would keep them out of registers.
    #[inline(never)]
    fn resolve<'a>(&self, textured: &Textured, vertex: Vertex, room: &'a mut Resolved) -> &'a Bsdf {
        room.0.insert(self.textured_bsdf(textured, &vertex))
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
        let mut scale = shading / geometric;
        if self.bent {
            scale *= terminator(self.vertex, shading, geometric);
        }
        (found.value != Rgb::ZERO).then(|| Evaluation { value: found.value * scale, ..found })
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
        if let Bsdf::Lambert(lambert) = self.bsdf
            && !self.bent
        {
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

    /// The narrow lobe of a BSDF that is not delta.
    #[inline]
    pub fn narrow_lobe(self) -> Option<NarrowLobe> {
        self.bsdf.narrow_lobe()
    }

    /// Probability with which a delta BSDF's sampling chooses the event that joins the two directions.
    #[inline]
    pub fn event_probability(self, given: Vec3A, sampled: Vec3A) -> f32 {
        self.bsdf.event_probability(self.vertex.shading_normal, given, sampled)
    }
}

/// S of a direction to the light with these cosines to the shading and to the geometric normal.
#[inline]
fn terminator(vertex: &Vertex, shading: f32, geometric: f32) -> f32 {
    let g = (geometric / (shading * vertex.shading_normal.dot(vertex.geometric_normal))).min(1.0);
    g * (1.0 + g * (1.0 - g))
}

/// |ω·N_s| and |ω·N_g|; `None` if ω is on different sides of the two, or tangent.
#[inline(always)]
fn cosines(vertex: &Vertex, direction: Vec3A) -> Option<(f32, f32)> {
    let shading = vertex.shading_normal.dot(direction);
    let geometric = vertex.geometric_normal.dot(direction);
    (shading * geometric > 0.0).then(|| (shading.abs(), geometric.abs()))
}
