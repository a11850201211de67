//! The share of light that a surface reflects, as denoisers want it.
//!
//! Source: Intel Open Image Denoise's documentation, "Albedos": reflectance for rough surfaces; for perfectly smooth ones Fresnel's blend
//! of the albedos seen by reflection and through them, both followed instead of one by chance, and 1 where that takes too many steps.

use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::methods::OwenSobol;
use crate::transport::scene::{Resolved, Scene};
use glam::Vec3A;

/// Directions that are drawn to find the reflectance of a rough surface.
const DIRECTIONS: u32 = 4;
/// Smooth surfaces, one seen in the other, that are followed both ways.
const MOST_SMOOTH: u32 = 4;

/// ∫ f |cosθ| dω over the directions of light for one to the eye, of what is seen at a vertex on a surface.
pub(super) fn albedo(scene: &Scene, vertex: &Vertex, to_eye: Vec3A, rng: &mut OwenSobol) -> Rgb {
    seen(scene, vertex, to_eye, MOST_SMOOTH, rng)
}

fn seen(scene: &Scene, vertex: &Vertex, to_eye: Vec3A, smooth: u32, rng: &mut OwenSobol) -> Rgb {
    match (vertex.delta, smooth) {
        (false, _) => reflectance(scene, vertex, to_eye, rng),
        (true, 0) => Rgb::ONE,
        (true, _) => {
            let way = |transmit| beyond(scene, vertex, (to_eye, transmit), smooth - 1, rng).unwrap_or(Rgb::ZERO);
            [false, true].map(way).into_iter().sum()
        }
    }
}

/// The share of a smooth surface's albedo that comes by reflection or through it; `None`: nothing does.
fn beyond(
    scene: &Scene,
    vertex: &Vertex,
    (to_eye, transmit): (Vec3A, bool),
    smooth: u32,
    rng: &mut OwenSobol,
) -> Option<Rgb> {
    let mut room = Resolved::default();
    let surface = scene.surface(vertex, &mut room);
    let direction = surface.delta_direction(to_eye, transmit)?;
    let found = surface.evaluate(direction, to_eye)?;
    let cos = vertex.geometric_normal.dot(direction).abs();
    let share = found.value * (surface.event_probability(to_eye, direction) * cos / found.pdf_to_light);
    Some(match scene.follow(vertex, direction, rng) {
        Some((next, _)) if !next.is_distant() => share * seen(scene, &next, -direction, smooth, rng),
        _ => share,
    })
}

/// Of a surface that is not smooth; of a diffuse one without chance.
fn reflectance(scene: &Scene, vertex: &Vertex, to_eye: Vec3A, rng: &mut OwenSobol) -> Rgb {
    let mut drawn = || {
        let mut room = Resolved::default();
        let sampled = scene.surface(vertex, &mut room).sample_to_light(to_eye, rng);
        sampled.map_or(Rgb::ZERO, |sampled| sampled.weight)
    };
    (0..DIRECTIONS).map(|_| drawn()).sum::<Rgb>() / DIRECTIONS as f32
}
