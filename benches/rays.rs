//! Rays of four kinds, and rays per CPU-second of several tracers on each, in turns.

use crate::contest::{median, median_ratio, take_turns};
use crate::stage::{Eye, Stage};
use crate::tracer::Tracer;
use glam::{Vec2, Vec3};
use mlt_core::transport::accel::Accel;
use mlt_core::transport::geometry::{Ray, math};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Camera rays along each side of the image.
const RESOLUTION: usize = 256;
/// Turns of each tracer on each set of rays.
const SLICES: usize = 31;

/// Where rays come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nearest hits from the camera, pixel by pixel.
    Primary,
    /// Nearest hits from what the camera sees, pixel by pixel, in cosine-weighted directions.
    Bounced,
    /// Nearest hits after three bounces, pixels in random order.
    Incoherent,
    /// Any hit between what the camera sees and the lamp, pixel by pixel.
    Shadow,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Bounced, Self::Incoherent, Self::Shadow];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Bounced => "bounced",
            Self::Incoherent => "incoherent",
            Self::Shadow => "shadow",
        }
    }

    /// One ray a pixel where there is one.
    pub fn rays(self, stage: &Stage, accel: &Accel) -> Vec<Ray> {
        let mut rng = Pcg32::seed_from_u64(1);
        let mut pixels: Vec<usize> = (0..RESOLUTION * RESOLUTION).collect();
        if self == Self::Incoherent {
            (1..pixels.len()).rev().for_each(|i| pixels.swap(i, rng.next_u32() as usize % (i + 1)));
        }
        let ray = |pixel| {
            let primary = camera_ray(&stage.eye, pixel);
            match self {
                Self::Primary => Some(primary),
                Self::Bounced => bounce(stage, accel, &primary, &mut rng),
                Self::Incoherent => (0..3).try_fold(primary, |ray, _| bounce(stage, accel, &ray, &mut rng)),
                Self::Shadow => shadow(stage, accel, &primary, &mut rng),
            }
        };
        pixels.into_iter().filter_map(ray).collect()
    }
}

fn uniform(rng: &mut Pcg32) -> f32 {
    (rng.next_u32() >> 8) as f32 / 16_777_216.0
}

fn camera_ray(eye: &Eye, pixel: usize) -> Ray {
    let at = |k: usize| 2.0 * (k as f32 + 0.5) / RESOLUTION as f32 - 1.0;
    let direction = eye.forward + at(pixel % RESOLUTION) * eye.right + at(pixel / RESOLUTION) * eye.down;
    Ray::new(eye.position, direction.normalize())
}

/// The point that a ray hits, moved a little off the surface, and the normal on the ray's side.
fn hit(stage: &Stage, accel: &Accel, ray: &Ray) -> Option<(Vec3, Vec3)> {
    let hit = accel.closest(ray)?;
    let [a, b, c] = stage.triangles[hit.primitive as usize];
    let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
    let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
    Some((ray.origin + hit.t * ray.direction + 1e-4 * normal, normal))
}

fn bounce(stage: &Stage, accel: &Accel, ray: &Ray, rng: &mut Pcg32) -> Option<Ray> {
    let (origin, normal) = hit(stage, accel, ray)?;
    let direction = math::cosine_hemisphere(normal.into(), Vec2::new(uniform(rng), uniform(rng)));
    Some(Ray::new(origin, direction.into()))
}

fn shadow(stage: &Stage, accel: &Accel, ray: &Ray, rng: &mut Pcg32) -> Option<Ray> {
    let (origin, _) = hit(stage, accel, ray)?;
    let [a, b, c] = stage.lamp[rng.next_u32() as usize % stage.lamp.len()];
    let u = uniform(rng).sqrt();
    let target = a + u * (b - a) + u * uniform(rng) * (c - b);
    Some(Ray { origin, direction: target - origin, t_max: 0.999 })
}

/// One scene and kind of ray.
pub struct Cell {
    /// Rays per CPU-second of our accelerator.
    pub rate: f64,
    /// Ours over each other tracer's, the median over the slices.
    pub ratios: Vec<f64>,
}

/// Traces rays by ours and by the others in turns.
///
/// # Panics
/// If one finds clearly more or fewer hits than ours: it would not do the same work.
pub fn compare(kind: Kind, rays: &[Ray], ours: &Accel, others: &[&dyn Tracer]) -> Cell {
    let tracers: Vec<&dyn Tracer> = [ours as &dyn Tracer].into_iter().chain(others.iter().copied()).collect();
    let count = |tracer: &dyn Tracer| match kind {
        Kind::Shadow => tracer.count_occluded(rays),
        _ => tracer.count_nearest(rays),
    };
    let hits = count(ours);
    for (i, other) in others.iter().enumerate() {
        let difference = count(*other).abs_diff(hits);
        assert!(difference <= rays.len() / 1000, "tracer {i}: {difference} of {} hits differ", rays.len());
    }
    let times = take_turns(tracers.len(), SLICES, |i| {
        std::hint::black_box(count(tracers[i]));
    });
    let ratios = times[1..].iter().map(|theirs| median_ratio(theirs, &times[0], |time| time.cpu)).collect();
    Cell { rate: rays.len() as f64 / median(times[0].iter().map(|time| time.cpu)), ratios }
}

/// The geometric mean.
pub fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|x| x.ln()).sum::<f64>() / values.len() as f64).exp()
}
