//! Unidirectional path tracing with next-event estimation.
//!
//! It shares the surfaces with the bidirectional methods and nothing else: a second opinion on their paths' weights.
//!
//! Source: [Veach97], section 9.3 (the two techniques of direct lighting, power heuristic).

use super::Rgb;
use super::kind::{Kind, LightEnd, PathEnd};
use super::light::LightPoint;
use super::path::View;
use super::region::LightRegion;
use super::vertex::Vertex;
use crate::engine::{uniform, uniform_f32};
use glam::{DVec3, Vec2, Vec3};
use rand_pcg::rand_core::Rng;

/// Surfaces that a path meets before roulette may end it.
const CERTAIN_BOUNCES: usize = 3;
/// Bounds of the probability of going on.
const SURVIVAL: (f64, f64) = (0.05, 0.95);

/// The sampler of radiance along camera rays.
#[derive(Clone, Copy)]
pub struct PathTracer<'a> {
    /// Scene and camera.
    pub view: View<'a>,
    /// The lights that are sampled: all of them.
    pub region: &'a LightRegion,
    /// Most edges of a path.
    pub max_edges: usize,
}

/// A path's end, as it grows from the camera.
struct Walk {
    vertex: Vertex,
    to_eye: Vec3,
    /// Product of scattering and cosines over densities.
    throughput: DVec3,
    /// Density per solid angle of the step to `vertex`, over the squared length of the step; `None` if it came from the
    /// camera or by a delta BSDF.
    pdf: Option<f64>,
    edges: usize,
}

impl PathTracer<'_> {
    /// Takes one sample through a point of the image and shows `visit` its parts, whose expected sum is the radiance.
    pub fn sample(&self, image: Vec2, rng: &mut impl Rng, visit: &mut impl FnMut(DVec3, PathEnd)) {
        let camera = self.view.camera.vertex();
        let direction = self.view.camera.direction(image);
        let mut next = self.view.scene.trace(&camera, direction).map(|vertex| Walk {
            vertex,
            to_eye: -direction,
            throughput: DVec3::ONE,
            pdf: None,
            edges: 1,
        });
        while let Some(walk) = next {
            let emitted = self.emitted(&walk);
            if emitted != DVec3::ZERO {
                let kind = Kind::new(walk.edges, walk.edges > 1 && walk.pdf.is_none());
                visit(walk.throughput * emitted, PathEnd { kind, light: LightEnd::Met(&walk.vertex) });
            }
            if walk.edges >= self.max_edges {
                break;
            }
            if !walk.vertex.delta
                && let Some((direct, point)) = self.direct(&walk, rng)
            {
                let kind = Kind::new(walk.edges + 1, false);
                visit(walk.throughput * direct, PathEnd { kind, light: LightEnd::Drawn(&point) });
            }
            next = self.scatter(walk, rng);
        }
    }

    /// Emission met by the last step, weighed against having drawn that point on the light.
    fn emitted(&self, walk: &Walk) -> DVec3 {
        let scene = self.view.scene;
        let emitted = scene.emitted(&walk.vertex, walk.to_eye).as_dvec3();
        match (walk.pdf, scene.lights().of(walk.vertex.primitive)) {
            (Some(pdf), Some(light)) if emitted != DVec3::ZERO => {
                let cos = f64::from(walk.vertex.geometric_normal.dot(walk.to_eye).abs());
                emitted * power_heuristic(pdf * cos, light.exitance() / self.region.power())
            }
            _ => emitted,
        }
    }

    /// Light that arrives from a point drawn on the lights, weighed against meeting that point by scattering; and the point.
    fn direct(&self, walk: &Walk, rng: &mut impl Rng) -> Option<(DVec3, LightPoint)> {
        let scene = self.view.scene;
        let point = self.region.sample(uniform(rng), f64::from(uniform_f32(rng)));
        let (light, source) = scene.light_point(&point);
        let step = source.position - walk.vertex.position;
        let square = step.length_squared();
        let to_light = step / square.sqrt();
        let emitted = scene.emitted(&source, -to_light);
        let scatter = scene.scatter(&walk.vertex, to_light, walk.to_eye).filter(|_| emitted != Rgb::ZERO)?;
        if square <= 0.0 || !scene.visible(&walk.vertex, &source) {
            return None;
        }
        let cos = f64::from(source.geometric_normal.dot(to_light).abs()) / f64::from(square);
        let density = light.exitance() / self.region.power();
        let scattered = f64::from(scene.pdf(&walk.vertex, walk.to_eye, to_light)) * cos;
        let geometric = f64::from(walk.vertex.geometric_normal.dot(to_light).abs()) * cos;
        let weight = geometric / density * power_heuristic(density, scattered);
        Some(((emitted * scatter).as_dvec3() * weight, point))
    }

    /// The next step; `None` where the path ends.
    fn scatter(&self, walk: Walk, rng: &mut impl Rng) -> Option<Walk> {
        let scene = self.view.scene;
        let direction = scene.sample(&walk.vertex, walk.to_eye, rng)?;
        let scatter = scene.scatter(&walk.vertex, direction, walk.to_eye)?;
        let pdf = scene.pdf(&walk.vertex, walk.to_eye, direction);
        let cos = walk.vertex.geometric_normal.dot(direction).abs();
        let mut throughput = walk.throughput * (scatter * (cos / pdf)).as_dvec3();
        if walk.edges >= CERTAIN_BOUNCES {
            let survival = throughput.max_element().clamp(SURVIVAL.0, SURVIVAL.1);
            if uniform(rng) >= survival {
                return None;
            }
            throughput /= survival;
        }
        let vertex = scene.trace(&walk.vertex, direction)?;
        let square = f64::from(vertex.position.distance_squared(walk.vertex.position));
        let pdf = (!walk.vertex.delta).then_some(f64::from(pdf) / square);
        Some(Walk { vertex, to_eye: -direction, throughput, pdf, edges: walk.edges + 1 })
    }
}

/// p² / (p² + q²).
fn power_heuristic(p: f64, q: f64) -> f64 {
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}
