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
use crate::transport::lights::{LightSampler, Receiver};
use crate::transport::methods::independent::ImageSampler;
use crate::transport::methods::sobol::OwenSobol;
use crate::transport::paths::{Edge, Kind, LightEnd, LightPath, PathEnd};
use crate::transport::scene::{LightPoint, Resolved, Sampled, Surface, View};
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
    edges: usize,
    /// Whether it came here by specular surfaces alone.
    straight: bool,
    /// Probability with which roulette let the last step be made.
    survival: f32,
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
        let walk = Walk { vertex, to_eye: -direction, throughput, edges: 1, straight: true, survival: 1.0 };
        self.show_emitted(&walk, &camera.vertex(), pdf, visit);
        if self.branches == 1 {
            self.go_on(walk, rng, visit);
        } else {
            self.go_apart(walk, rng, visit);
        }
    }

    /// Grows the path until it ends.
    #[inline(always)]
    fn go_on(&self, mut walk: Walk, rng: &mut OwenSobol, visit: &mut impl FnMut(DVec3, PathEnd)) {
        while self.may_go_on(&walk) {
            let mut room = Resolved::default();
            let surface = self.view.scene.surface(&walk.vertex, &mut room);
            self.show_direct(&walk, surface, rng, visit);
            let Some(sampled) = surface.sample_to_light(walk.to_eye, rng) else { return };
            if self.step(&mut walk, sampled, rng, visit).is_none() {
                return;
            }
        }
    }

    /// Grows several paths from the first surface on. What the lights send there they share.
    fn go_apart(&self, walk: Walk, rng: &mut OwenSobol, visit: &mut impl FnMut(DVec3, PathEnd)) {
        if !self.may_go_on(&walk) {
            return;
        }
        let mut room = Resolved::default();
        let surface = self.view.scene.surface(&walk.vertex, &mut room);
        self.show_direct(&walk, surface, rng, visit);
        let share = 1.0 / f64::from(self.branches);
        let mut visit = |radiance, end: PathEnd| visit(radiance * share, PathEnd { scale: end.scale / share, ..end });
        for i in 0..self.branches {
            let (mut walk, rng) = (walk.clone(), rng.branch(i, self.branches));
            let Some(sampled) = surface.sample_to_light(walk.to_eye, rng) else { continue };
            if self.step(&mut walk, sampled, rng, &mut visit).is_some() {
                self.go_on(walk, rng, &mut visit);
            }
        }
    }

    #[inline(always)]
    fn may_go_on(&self, walk: &Walk) -> bool {
        let image = walk.straight && walk.vertex.delta;
        walk.edges < if image { self.max_image_edges } else { self.max_edges }
    }

    /// Shows what a path's end emits. The step to it began at `from` (of the camera, in the middle of its lens) with the density `pdf` per
    /// solid angle, over its squared length unless the end is distant; `None` if it could not have been drawn on a light: by a delta BSDF,
    /// or from the camera unless lights are drawn for it.
    #[inline(always)]
    fn show_emitted(&self, walk: &Walk, from: &Vertex, pdf: Option<f32>, visit: &mut impl FnMut(DVec3, PathEnd)) {
        if walk.vertex.emits {
            let kind = match walk {
                Walk { edges: 1, .. } => Kind::new(1, false),
                Walk { straight: true, .. } => Kind::IMAGE,
                _ => Kind::new(walk.edges, pdf.is_none()),
            };
            let (emitted, weight) = self.emitted([*from, walk.vertex], walk.to_eye, pdf);
            let radiance = walk.throughput * (emitted * weight);
            visit(
                radiance.as_dvec3(),
                PathEnd {
                    kind,
                    light: LightEnd::Met(&walk.vertex),
                    scale: f64::from(walk.survival) / f64::from(weight).sqrt(),
                },
            );
        }
    }

    /// Shows what the lights send to a path's end, which is on this surface.
    #[inline(always)]
    fn show_direct(&self, walk: &Walk, surface: Surface, rng: &mut OwenSobol, visit: &mut impl FnMut(DVec3, PathEnd)) {
        if walk.edges < self.max_edges
            && !(walk.vertex.delta | walk.vertex.is_distant())
            && let Some((direct, weight, point)) = self.direct(walk, surface, rng)
        {
            let kind = Kind::new(walk.edges + 1, false);
            let end = PathEnd { kind, light: LightEnd::Drawn(&point), scale: 1.0 / f64::from(weight).sqrt() };
            visit((walk.throughput * direct).as_dvec3(), end);
        }
    }

    /// Emission met by a step to x, and its weight against having drawn that point on the light. Takes vertices by value: references would keep
    /// them out of registers.
    fn emitted(&self, [from, x]: [Vertex; 2], to_eye: Vec3A, pdf: Option<f32>) -> (Rgb, f32) {
        let scene = self.view.scene;
        let emitted = scene.emitted(&x, to_eye);
        let lights = scene.lights();
        if let (Some(pdf), Some(number)) = (pdf, lights.number(x.primitive))
            && emitted != Rgb::ZERO
        {
            let cos = x.geometric_normal.dot(to_eye).abs();
            let light = &lights.lights[number.0 as usize];
            let relative = scene.relative_exitance(light, &x, emitted);
            let receiver = Receiver { scene, vertex: from, towards: -to_eye };
            let place = || light.coordinates(number.1, x.position.into()).into();
            let drawn = self.light_sampler.density(&receiver, number, place) * relative;
            return (emitted, power_heuristic(pdf * cos, drawn as f32));
        }
        (emitted, 1.0)
    }

    /// Light that arrives from a point drawn on the lights, weighed against meeting that point by scattering; that weight, and the point.
    #[inline(always)]
    fn direct(&self, walk: &Walk, surface: Surface, rng: &mut impl Rng) -> Option<(Rgb, f32, LightPoint)> {
        let scene = self.view.scene;
        let receiver = Receiver { scene, vertex: walk.vertex, towards: walk.to_eye };
        let (point, density) = self.light_sampler.sample(&receiver, [uniform(rng), f64::from(uniform_f32(rng))]);
        let (light, source) = scene.light_point(&point);
        let edge = Edge::between(&source, &walk.vertex)?;
        let (to_light, [leaving, arriving]) = (-edge.direction, edge.cosines);
        let emitted = scene.emitted(&source, edge.direction);
        if emitted == Rgb::ZERO {
            return None;
        }
        let density = (density * scene.relative_exitance(light, &source, emitted)) as f32;
        let found = surface.evaluate(to_light, walk.to_eye)?;
        let passed = scene.transmittance(&walk.vertex, &source)?;
        let cos = leaving * edge.inverse_square * passed;
        let geometric = arriving * cos;
        let met = if source.can_be_met() { found.pdf_to_light * cos } else { 0.0 };
        let weight = power_heuristic(density, met);
        let arriving = emitted * found.value * (geometric / density * weight);
        Some((scene.attenuated(arriving, &source, &walk.vertex), weight, point))
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
        let receiver = Receiver { scene, vertex: middle, towards: middle.geometric_normal };
        let (point, density) = self.light_sampler.sample(&receiver, [uniform(rng), f64::from(uniform_f32(rng))]);
        let (light, source) = scene.light_point(&point);
        let edge = Edge::between(&source, &eye)?;
        let direction = -edge.direction;
        let pixel = camera.pixel(camera.project(&eye, &source, direction)?);
        let emitted = scene.emitted(&source, edge.direction);
        if emitted == Rgb::ZERO {
            return None;
        }
        let density = density * scene.relative_exitance(light, &source, emitted);
        let passed = scene.transmittance(&eye, &source)?;
        let cos = eye.geometric_normal.dot(direction);
        let there = edge.cosines[0] * passed * edge.inverse_square;
        let weight = power_heuristic(density as f32, camera.pdf(direction) * there);
        let emitted = scene.attenuated(emitted, &source, &eye);
        let value = emitted.as_dvec3() * (f64::from(camera.w_e(direction) * cos * there * weight) / density);
        let scale = 1.0 / f64::from(weight).sqrt();
        visit(Some(pixel), value, PathEnd { kind: Kind::new(1, false), light: LightEnd::Drawn(&point), scale });
        Some(())
    }

    /// Goes the next step, into a direction drawn, and shows what is emitted there; `None` where the path ends.
    #[inline(always)]
    fn step(
        &self,
        walk: &mut Walk,
        sampled: Sampled,
        rng: &mut impl Rng,
        visit: &mut impl FnMut(DVec3, PathEnd),
    ) -> Option<()> {
        let scene = self.view.scene;
        let Sampled { to_light: direction, weight, pdf } = sampled;
        walk.throughput *= weight;
        let mut survival = 1.0;
        if walk.edges >= CERTAIN_BOUNCES {
            // The root makes paths longer than their throughput alone: less noise for the time (docs/log/performance.md).
            survival = survival_of(walk.throughput.max_element());
            if uniform_f32(rng) >= survival {
                return None;
            }
            walk.throughput /= survival;
        }
        let (vertex, passed) = scene.follow(&walk.vertex, direction, rng)?;
        let from = walk.vertex;
        let pdf = (!from.delta).then_some(pdf * passed / vertex.distance_squared(&from));
        *walk = Walk {
            vertex,
            to_eye: -direction,
            throughput: scene.attenuated(walk.throughput, &vertex, &from),
            edges: walk.edges + 1,
            straight: walk.straight & from.delta,
            survival,
        };
        self.show_emitted(walk, &from, pdf, visit);
        Some(())
    }
}

#[inline(always)]
fn survival_of(throughput: f32) -> f32 {
    throughput.sqrt().clamp(SURVIVAL.0, SURVIVAL.1)
}

/// Probability with which roulette lets a walk come to x_1 of a path.
pub(crate) fn survival(path: &LightPath, view: &View) -> f64 {
    let x = path.vertices();
    let last = path.edges();
    let (mut throughput, mut all) =
        (view.scene.attenuated(Rgb::ONE, &x[last - 1].vertex, &x[last].vertex).as_dvec3(), 1.0);
    for i in (2..last).rev() {
        let passed = view.scene.attenuated(Rgb::ONE, &x[i - 1].vertex, &x[i].vertex).as_dvec3();
        throughput *= x[i].scatter.as_dvec3() * (x[i - 1].geometric_term / x[i - 1].reverse);
        if last - i >= CERTAIN_BOUNCES {
            let survival = f64::from(survival_of((throughput / passed).max_element() as f32));
            throughput /= survival;
            all *= survival;
        }
    }
    all
}

/// p² / (p² + q²).
#[inline]
fn power_heuristic(p: f32, q: f32) -> f32 {
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}
