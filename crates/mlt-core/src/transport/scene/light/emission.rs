//! Emission of a vertex on a light: a surface's is the same radiance in every direction of its front, or of both of its sides, or in those
//! of a cone.

use super::super::cone::Cone;
use super::uneven::Uneven;
use super::{Area, Light, LightPoint, Shape, Source};
use crate::engine::uniform_f32;
use crate::transport::colour::{Rgb, luminance};
use crate::transport::geometry::math::{cosine_hemisphere, unit};
use crate::transport::geometry::{ERROR_FACTOR, LIGHT, Place, Vertex};
use crate::transport::scene::Scene;
use glam::{Vec2, Vec3A};
use rand_pcg::rand_core::Rng;
use std::f32::consts::FRAC_1_PI;

impl Scene {
    /// The light and the vertex at a point of the lights.
    #[inline(always)]
    pub(crate) fn light_point(&self, point: &LightPoint) -> (&Light, Vertex) {
        let light = &self.lights.lights[point.light as usize];
        let vertex = match &light.shape {
            Shape::Area(area) => self.point_on_surface(area, point),
            Shape::Environment(around) => self.distant(point.light, around.direction(point.u, point.v)),
            Shape::Sun(sun) => self.distant(point.light, sun.direction(point.u, point.v)),
            Shape::Direction(rays) => Vertex { place: Place::Direction, ..self.distant(point.light, rays.towards) },
            Shape::Point(source) => Vertex::free(point.light, [source.position.into(), source.cone.axis], self.black()),
        };
        (light, vertex)
    }

    /// The vertex at a point of a surface that emits.
    #[inline(always)]
    fn point_on_surface(&self, area: &Area, point: &LightPoint) -> Vertex {
        let (primitive, position) = area.at(point.u, point.v);
        let p = &self.triangles.primitives[primitive as usize];
        let vertex = p.vertex(primitive, position.into());
        // It is interpolated in f32, not found in f64.
        if p.coarse { Vertex { error: vertex.error.max(ERROR_FACTOR * p.reach()), ..vertex } } else { vertex }
    }

    /// Radiance that a vertex emits into a direction; intensity of a light at a point, irradiance of one in a direction. Zero where
    /// another surface is seen in its place.
    #[inline(always)]
    pub fn emitted(&self, vertex: &Vertex, direction: Vec3A) -> Rgb {
        if vertex.place != Place::Surface {
            return self.emitted_without_surface(*vertex, direction);
        }
        let material = self.material(vertex);
        let lit = material.emits_both_sides || vertex.geometric_normal.dot(direction) > 0.0;
        if lit && !self.is_hidden(vertex, direction) { self.emission(vertex, direction) } else { Rgb::ZERO }
    }

    /// Radiance of the lit side into a direction.
    #[inline(always)]
    fn emission(&self, vertex: &Vertex, direction: Vec3A) -> Rgb {
        let material = self.material(vertex);
        let radiance = if self.needs.textured && material.textured.is_some() {
            self.varying_emission(*vertex)
        } else {
            material.emission
        };
        self.cone(vertex).map_or(radiance, |cone| radiance * cone.share(direction))
    }

    /// The cone that a surface emits into, if it does.
    #[inline(always)]
    fn cone(&self, vertex: &Vertex) -> Option<&Cone> {
        if self.needs.cones { self.material(vertex).cone.as_ref() } else { None }
    }

    #[inline(never)]
    fn varying_emission(&self, vertex: Vertex) -> Rgb {
        let place = self.coordinates(&vertex);
        let material = self.material(&vertex);
        if material.opacity_at(&self.textures, &place) > 0.0 {
            material.emission_at(&self.textures, &place)
        } else {
            Rgb::ZERO
        }
    }

    /// M at a vertex on a light.
    #[inline(always)]
    pub(crate) fn exitance(&self, light: &Light, vertex: &Vertex) -> f64 {
        let emitted = if vertex.place == Place::Distant {
            self.emitted_without_surface(*vertex, vertex.geometric_normal)
        } else {
            light.emission
        };
        light.mean_exitance() * self.relative_exitance(light, vertex, emitted)
    }

    /// M over its light's mean, at a vertex that emits the radiance `emitted`, which is not zero.
    #[inline(always)]
    pub(crate) fn relative_exitance(&self, light: &Light, vertex: &Vertex, emitted: Rgb) -> f64 {
        match &light.shape {
            Shape::Area(Area::Uneven(uneven)) => self.uneven_exitance(uneven, *vertex),
            Shape::Environment(_) => f64::from(luminance(emitted)) / f64::from(luminance(light.emission)),
            Shape::Area(_) | Shape::Sun(_) | Shape::Point(_) | Shape::Direction(_) => 1.0,
        }
    }

    /// Of an uneven light, whose points are drawn by area, not by that times opacity.
    #[inline(never)]
    fn uneven_exitance(&self, uneven: &Uneven, vertex: Vertex) -> f64 {
        let index = self.lights.number(vertex.primitive).map_or(0, |(_, index)| index);
        let opacity = self.opacity(&vertex);
        let by_area = uneven.relative(index, vertex.position.into());
        if opacity > 0.0 { by_area / f64::from(opacity) } else { by_area }
    }

    /// Draws the ray that a light subpath starts with: its origin and its direction.
    #[inline(always)]
    pub(crate) fn sample_emission(&self, vertex: &Vertex, rng: &mut impl Rng) -> (Vec3A, Vec3A) {
        let u = Vec2::new(uniform_f32(rng), uniform_f32(rng));
        if vertex.place != Place::Surface {
            return self.ray_without_surface(*vertex, u);
        }
        if let Some(cone) = self.cone(vertex) {
            return vertex.ray(cone.direction(u));
        }
        let back = self.material(vertex).emits_both_sides && uniform_f32(rng) < 0.5;
        vertex.ray(cosine_hemisphere(if back { -vertex.geometric_normal } else { vertex.geometric_normal }, u))
    }

    /// Density of that ray: of its direction, sr⁻¹, cosθ/π, or half that on each of two sides; uniform in a cone; from a
    /// distant vertex of the ray's point on the disc that faces the scene, per area.
    #[inline(always)]
    pub(crate) fn pdf_emission(&self, vertex: &Vertex, direction: Vec3A) -> f32 {
        if vertex.place != Place::Surface {
            return self.pdf_without_surface(*vertex);
        }
        if let Some(cone) = self.cone(vertex) {
            return cone.pdf();
        }
        let cos = vertex.geometric_normal.dot(direction);
        if self.material(vertex).emits_both_sides { 0.5 * cos.abs() * FRAC_1_PI } else { cos.max(0.0) * FRAC_1_PI }
    }

    /// The vertex of a distant light that a ray meets which meets nothing else.
    #[cold]
    pub(in crate::transport::scene) fn beyond(&self, direction: Vec3A) -> Option<Vertex> {
        if self.needs.environment | self.needs.suns { self.distant_in(unit(direction)) } else { None }
    }

    #[inline(never)]
    fn distant_in(&self, direction: Vec3A) -> Option<Vertex> {
        self.lights.in_direction(direction).next().map(|(light, _)| self.distant(light, direction))
    }

    /// Radiance from a direction, of a vertex on a distant light: where several are seen in one direction, all of their light is that of the
    /// first.
    fn radiance_from(&self, vertex: &Vertex) -> Rgb {
        let mut seen = self.lights.in_direction(vertex.position).peekable();
        match seen.peek() {
            Some(&(first, _)) if LIGHT + first == vertex.primitive => {
                seen.map(|(_, light)| light.radiance(vertex.position)).sum()
            }
            _ => Rgb::ZERO,
        }
    }

    #[inline(always)]
    fn distant(&self, light: u32, towards: Vec3A) -> Vertex {
        Vertex::distant(light, towards, self.black())
    }

    /// The last material, where lights have no surface.
    #[inline(always)]
    fn black(&self) -> u32 {
        self.materials.len() as u32 - 1
    }

    /// The point that a vertex on no surface stands for, if it is not distant.
    fn source(&self, vertex: &Vertex) -> Option<&Source> {
        match self.lights.of(vertex.primitive).map(|light| &light.shape) {
            Some(Shape::Point(source)) => Some(source),
            _ => None,
        }
    }

    #[cold]
    fn ray_without_surface(&self, vertex: Vertex, u: Vec2) -> (Vec3A, Vec3A) {
        match self.source(&vertex) {
            Some(source) => (vertex.position, source.cone.direction(u)),
            None => self.sphere.ray_along(-vertex.position, u),
        }
    }

    #[cold]
    fn pdf_without_surface(&self, vertex: Vertex) -> f32 {
        self.source(&vertex).map_or(self.sphere.pdf(), |source| source.cone.pdf())
    }

    #[cold]
    fn emitted_without_surface(&self, vertex: Vertex, direction: Vec3A) -> Rgb {
        let Some(light) = self.lights.of(vertex.primitive) else { return Rgb::ZERO };
        match &light.shape {
            Shape::Environment(_) | Shape::Sun(_) => self.radiance_from(&vertex),
            Shape::Point(source) => light.emission * source.cone.share(direction),
            Shape::Direction(_) => light.emission,
            Shape::Area(_) => Rgb::ZERO,
        }
    }
}
