//! Surfaces that are not opaque.
//!
//! A surface of opacity α is there for the share α of what comes, and for the rest it is not: light goes straight on. Between
//! two points passes τ(x, y) = Π (1 − α), over the surfaces that the segment crosses.
//!
//! Area is measured as dA′ = α dA on every surface. Then f has the factor τ on each edge and none at the vertices; a ray that
//! stops at each surface with probability α comes to y with density p_ω |cosθ| τ / d² per A′, so τ cancels in f/p; and a light
//! of area A has the area α A. docs/theory.md, "Opacity".

use super::primitive::Primitive;
use super::way::Way;
use super::{RAYS, Scene};
use crate::engine::uniform_f32;
use crate::transport::geometry::Vertex;
use glam::Vec3A;
use rand_pcg::rand_core::Rng;

impl Scene {
    /// α at a vertex.
    #[inline]
    pub(super) fn opacity(&self, vertex: &Vertex) -> f32 {
        let material = self.material(vertex);
        match &material.textured {
            Some(textured) if textured.has_opacity() => material.opacity_at(&self.textures, &self.coordinates(vertex)),
            _ => material.opacity,
        }
    }

    /// α of the surface that is seen in a veil's place from its other side, if that is another one: what passes has to pass both, or more
    /// would pass to one side than to the other. `direction`: along which the veil is passed.
    #[inline]
    fn opacity_behind(&self, veil: &Vertex, direction: Vec3A) -> f32 {
        if !veil.shared {
            return 0.0;
        }
        let primitive = self.triangles.seen(&self.materials, veil.primitive, veil.position, direction);
        let Primitive { material, .. } = self.triangles.primitives[primitive as usize];
        if primitive == veil.primitive { 0.0 } else { self.opacity(&Vertex { primitive, material, ..*veil }) }
    }

    /// The surface at which light along a direction, of any length, stops, or a distant light beyond all surfaces; and τ of those that
    /// it passes. A random number is drawn for each surface that is not opaque.
    #[inline(always)]
    pub fn follow(&self, from: &Vertex, direction: Vec3A, rng: &mut impl Rng) -> Option<(Vertex, f32)> {
        self.follow_ray(from.origin(direction), direction, rng)
    }

    /// The same from the camera, which may not see what is beyond all surfaces.
    #[inline(always)]
    pub(crate) fn follow_camera_ray(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        rng: &mut impl Rng,
    ) -> Option<(Vertex, f32)> {
        let (vertex, passed) = self.follow_ray(origin, direction, rng)?;
        (!vertex.is_distant() || self.background).then_some((vertex, passed))
    }

    /// The same from a point that is on no surface.
    #[inline(always)]
    pub(crate) fn follow_ray(&self, origin: Vec3A, direction: Vec3A, rng: &mut impl Rng) -> Option<(Vertex, f32)> {
        // Taken apart: what a call returns as a whole stays in memory.
        let (vertex, passed) = match self.needs.veils {
            false => (self.first_vertex(origin, direction)?, 1.0),
            true => self.follow_through_veils(origin, direction, rng)?,
        };
        Some((vertex, passed))
    }

    /// The first surface along a ray, or the environment beyond all surfaces.
    #[inline(always)]
    fn first_vertex(&self, origin: Vec3A, direction: Vec3A) -> Option<Vertex> {
        let vertex = match self.trace_ray(origin, direction) {
            Some(vertex) => vertex,
            None => self.beyond(direction)?,
        };
        Some(vertex)
    }

    /// [`follow_ray`](Self::follow_ray) where surfaces may not be opaque.
    #[inline(never)]
    fn follow_through_veils(&self, mut origin: Vec3A, direction: Vec3A, rng: &mut impl Rng) -> Option<(Vertex, f32)> {
        let mut passed = 1.0;
        loop {
            // The environment is opaque.
            let vertex = self.first_vertex(origin, direction)?;
            let opacity = self.opacity(&vertex);
            if opacity >= 1.0 || uniform_f32(rng) < opacity {
                return Some((vertex, passed));
            }
            let behind = self.opacity_behind(&vertex, direction);
            if behind > 0.0 && uniform_f32(rng) < behind {
                return None;
            }
            passed *= (1.0 - opacity) * (1.0 - behind);
            origin = vertex.origin(direction);
        }
    }

    /// τ between two vertices; `None` if an opaque surface stands there, and between the camera and what it does not see beyond all
    /// surfaces.
    #[inline(always)]
    pub fn transmittance(&self, a: &Vertex, b: &Vertex) -> Option<f32> {
        if !Vertex::are_on_surfaces(a, b) {
            return self.transmittance_of_others(*a, *b);
        }
        self.transmittance_along(Way::segment(a, b))
    }

    /// The same where an end is not on a surface. Takes vertices by value: a reference would keep them out of registers.
    #[cold]
    fn transmittance_of_others(&self, a: Vertex, b: Vertex) -> Option<f32> {
        let way = Way::between(&a, &b);
        if way.endless && !self.background && (a.is_camera() || b.is_camera()) {
            return None;
        }
        self.transmittance_along(way)
    }

    #[inline(always)]
    fn transmittance_along(&self, way: Way) -> Option<f32> {
        if self.needs.veils { self.veils_along(way) } else { self.is_clear(&way.ray()).then_some(1.0) }
    }

    #[inline(never)]
    fn veils_along(&self, mut way: Way) -> Option<f32> {
        let mut passed = 1.0;
        loop {
            RAYS.set(RAYS.get() + 1);
            let ray = way.ray();
            let Some(hit) = self.accel.closest(&ray) else {
                return Some(passed);
            };
            let veil = self.vertex(&hit, &ray)?;
            passed *= (1.0 - self.opacity(&veil)) * (1.0 - self.opacity_behind(&veil, way.step()));
            if passed <= 0.0 {
                return None;
            }
            let Some(rest) = way.behind(&veil) else {
                return Some(passed);
            };
            way = rest;
        }
    }
}
