//! Unidirectional path tracing with next-event estimation.
//!
//! It shares the surfaces with the bidirectional methods and nothing else: a second opinion on their paths' weights.
//!
//! Where a light may be smaller than a pixel, a point of the lights is drawn for the camera too: it crosses the image where it
//! does, and is weighed against camera rays.
//!
//! Source: [Veach97], section 9.3 (the two techniques of direct lighting, power heuristic).

use crate::engine::{uniform, uniform_f32};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::lights::LightSampler;
use crate::transport::methods::independent::ImageSampler;
use crate::transport::methods::sobol::OwenSobol;
use crate::transport::paths::{Edge, Kind, LightEnd, PathEnd};
use crate::transport::scene::{LightPoint, Resolved, Sampled, View};
use glam::{DVec3, Vec2, Vec3A};
use rand_pcg::rand_core::Rng;

/// Surfaces that a path meets before roulette may end it.
const CERTAIN_BOUNCES: usize = 4;
/// Bounds of the probability of going on.
const SURVIVAL: (f32, f32) = (0.05, 0.95);

/// The sampler of radiance along camera rays.
#[derive(Clone, Copy, Debug)]
pub struct PathTracer<'a> {
    /// Scene and camera.
    pub view: View<'a>,
    /// Draws points of the lights.
    pub light_sampler: &'a LightSampler,
    /// Most edges of a path.
    pub max_edges: usize,
    /// Most edges of a path with nothing but specular surfaces between its ends; no fewer.
    pub max_image_edges: usize,
    /// Walks that go on from the first surface; they share what arrives there.
    pub branches: u32,
}

/// A path's end, as it grows from the camera.
#[derive(Clone)]
struct Walk {
    vertex: Vertex,
    to_eye: Vec3A,
    /// Product of scattering and cosines over densities.
    throughput: Rgb,
    /// Density per solid angle of the step to `vertex`, over the squared length of the step unless that is distant; `None` if it could not have been
    /// drawn on a light: by a delta BSDF, or from the camera unless lights are drawn for it.
    pdf: Option<f32>,
    /// Where that step began; for the camera, the middle of its lens.
    before: Vertex,
    edges: usize,
    /// Whether it came here by specular surfaces alone.
    straight: bool,
}

impl ImageSampler for PathTracer<'_> {
    fn size(&self) -> [u32; 2] {
        self.view.camera.size()
    }

    #[inline(always)]
    fn sample(&self, film: Vec2, rng: &mut OwenSobol, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        if self.view.camera.has_tiny_lights() {
            self.see_light(rng, visit);
        }
        self.sample_radiance(film, rng, &mut |radiance, end| visit(None, radiance, end));
    }
}

impl PathTracer<'_> {
    /// Takes one sample through a film point and shows `visit` its parts, whose expected sum is the radiance.
    #[inline(always)]
    pub fn sample_radiance(&self, film: Vec2, rng: &mut OwenSobol, visit: &mut impl FnMut(DVec3, PathEnd)) {
        let View { scene, camera } = self.view;
        let lens = camera.sample_lens(rng);
        let ray = camera.sample(film, &lens);
        let Some((vertex, passed)) = scene.follow_camera_ray(ray.origin, ray.step, rng) else { return };
        let direction = ray.direction();
        let drawn = camera.has_tiny_lights() && !vertex.is_met_by_one_ray(&lens);
        let pdf = drawn.then(|| camera.pdf(direction) * passed / vertex.distance_squared(&lens));
        let throughput = scene.attenuated(Rgb::ONE, &vertex, &lens);
        let walk =
            Walk { vertex, to_eye: -direction, throughput, pdf, before: camera.vertex(), edges: 1, straight: true };
        self.gather(&walk, rng, visit);
        if self.branches == 1 {
            self.go_on(walk, rng, visit);
            return;
        }
        let share = 1.0 / f64::from(self.branches);
        let mut visit = |radiance, end: PathEnd| visit(radiance * share, end);
        (0..self.branches).for_each(|i| self.go_on(walk.clone(), rng.branch(i, self.branches), &mut visit));
    }

    /// Grows the path until it ends.
    #[inline(always)]
    fn go_on(&self, mut walk: Walk, rng: &mut OwenSobol, visit: &mut impl FnMut(DVec3, PathEnd)) {
        while self.may_go_on(&walk) && self.scatter(&mut walk, rng).is_some() {
            self.gather(&walk, rng, visit);
        }
    }

    #[inline(always)]
    fn may_go_on(&self, walk: &Walk) -> bool {
        let image = walk.straight && walk.vertex.delta;
        walk.edges < if image { self.max_image_edges } else { self.max_edges }
    }

    /// Shows the light that a path brings: what its end emits and what the lights send there.
    #[inline(always)]
    fn gather(&self, walk: &Walk, rng: &mut OwenSobol, visit: &mut impl FnMut(DVec3, PathEnd)) {
        if walk.vertex.emits {
            let kind = match walk {
                Walk { edges: 1, .. } => Kind::new(1, false),
                Walk { straight: true, .. } => Kind::IMAGE,
                _ => Kind::new(walk.edges, walk.pdf.is_none()),
            };
            let radiance = walk.throughput * self.emitted(walk);
            visit(radiance.as_dvec3(), PathEnd { kind, light: LightEnd::Met(&walk.vertex) });
        }
        if walk.edges < self.max_edges
            && !(walk.vertex.delta | walk.vertex.is_distant())
            && let Some((direct, point)) = self.direct(walk, rng)
        {
            let kind = Kind::new(walk.edges + 1, false);
            visit((walk.throughput * direct).as_dvec3(), PathEnd { kind, light: LightEnd::Drawn(&point) });
        }
    }

    /// Emission met by the last step, weighed against having drawn that point on the light.
    fn emitted(&self, walk: &Walk) -> Rgb {
        let scene = self.view.scene;
        let emitted = scene.emitted(&walk.vertex, walk.to_eye);
        let (lights, x) = (scene.lights(), &walk.vertex);
        if let (Some(pdf), Some(number)) = (walk.pdf, lights.number(x.primitive))
            && emitted != Rgb::ZERO
            && let Some(point) = lights.point(x.primitive, x.position)
        {
            let cos = x.geometric_normal.dot(walk.to_eye).abs();
            let relative = scene.relative_exitance(&lights.lights[number.0 as usize], x, emitted);
            let drawn = self.light_sampler.density(&walk.before, number, &point) * relative;
            return emitted * power_heuristic(pdf * cos, drawn as f32);
        }
        emitted
    }

    /// Light that arrives from a point drawn on the lights, weighed against meeting that point by scattering; and the point.
    #[inline(always)]
    fn direct(&self, walk: &Walk, rng: &mut impl Rng) -> Option<(Rgb, LightPoint)> {
        let scene = self.view.scene;
        let (point, density) = self.light_sampler.sample(&walk.vertex, uniform(rng), f64::from(uniform_f32(rng)));
        let (light, source) = scene.light_point(&point);
        let edge = Edge::between(&source, &walk.vertex)?;
        let (to_light, [leaving, arriving]) = (-edge.direction, edge.cosines);
        let emitted = scene.emitted(&source, edge.direction);
        if emitted == Rgb::ZERO {
            return None;
        }
        let density = (density * scene.relative_exitance(light, &source, emitted)) as f32;
        let found = scene.surface(&walk.vertex, &mut Resolved::default()).evaluate(to_light, walk.to_eye)?;
        let passed = scene.transmittance(&walk.vertex, &source);
        if passed == 0.0 {
            return None;
        }
        let cos = leaving * edge.inverse_square * passed;
        let geometric = arriving * cos;
        let met = if source.can_be_met() { found.pdf_to_light * cos } else { 0.0 };
        let weight = geometric / density * power_heuristic(density, met);
        Some((scene.attenuated(emitted * found.value * weight, &source, &walk.vertex), point))
    }

    /// Draws a point on the lights for the camera, and shows it with the pixel where it crosses the image, weighed against the
    /// ray through that point: L W_e G/p.
    pub(crate) fn see_light(
        &self,
        rng: &mut impl Rng,
        visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd),
    ) -> Option<()> {
        let View { scene, camera } = self.view;
        let (middle, eye) = (camera.vertex(), camera.sample_lens(rng));
        let (point, density) = self.light_sampler.sample(&middle, uniform(rng), f64::from(uniform_f32(rng)));
        let (light, source) = scene.light_point(&point);
        let edge = Edge::between(&source, &eye)?;
        let direction = -edge.direction;
        let pixel = camera.pixel(camera.project(&eye, &source, direction)?);
        let emitted = scene.emitted(&source, edge.direction);
        if emitted == Rgb::ZERO {
            return None;
        }
        let density = density * scene.relative_exitance(light, &source, emitted);
        let passed = scene.transmittance(&eye, &source);
        if passed == 0.0 {
            return None;
        }
        let cos = eye.geometric_normal.dot(direction);
        let there = edge.cosines[0] * passed * edge.inverse_square;
        let weight = power_heuristic(density as f32, camera.pdf(direction) * there);
        let emitted = scene.attenuated(emitted, &source, &eye);
        let value = emitted.as_dvec3() * (f64::from(camera.w_e(direction) * cos * there * weight) / density);
        visit(Some(pixel), value, PathEnd { kind: Kind::new(1, false), light: LightEnd::Drawn(&point) });
        Some(())
    }

    /// The next step; `None` where the path ends.
    #[inline(always)]
    fn scatter(&self, walk: &mut Walk, rng: &mut impl Rng) -> Option<()> {
        let scene = self.view.scene;
        let Sampled { to_light: direction, weight, pdf } =
            scene.surface(&walk.vertex, &mut Resolved::default()).sample_to_light(walk.to_eye, rng)?;
        walk.throughput *= weight;
        if walk.edges >= CERTAIN_BOUNCES {
            // The root makes paths longer than their throughput alone: less noise for the time (docs/log/performance.md).
            let survival = walk.throughput.max_element().sqrt().clamp(SURVIVAL.0, SURVIVAL.1);
            if uniform_f32(rng) >= survival {
                return None;
            }
            walk.throughput /= survival;
        }
        let (vertex, passed) = scene.follow(&walk.vertex, direction, rng)?;
        let square = vertex.distance_squared(&walk.vertex);
        walk.pdf = (!walk.vertex.delta).then_some(pdf * passed / square);
        walk.throughput = scene.attenuated(walk.throughput, &vertex, &walk.vertex);
        walk.straight &= walk.vertex.delta;
        walk.before = std::mem::replace(&mut walk.vertex, vertex);
        walk.to_eye = -direction;
        walk.edges += 1;
        Some(())
    }
}

/// p² / (p² + q²).
#[inline]
fn power_heuristic(p: f32, q: f32) -> f32 {
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}
