//! Tracing of subpaths, one vertex at a time.
//!
//! Both kinds fill slots of one array in the order of the finished path: a light subpath grows towards larger indices,
//! a camera subpath towards smaller ones. A finished path needs no turning round.

use super::edge::Edge;
use super::path_vertex::{PathVertex, set_edge};
use crate::engine::{uniform, uniform_f32};
use crate::transport::geometry::Vertex;
use crate::transport::lights::{LightRegion, Receiver};
use crate::transport::scene::{Light, LightPoint, Resolved, View};
use glam::{Vec2, Vec3A};
use rand_pcg::rand_core::Rng;

/// Draws the numbers that x_0 is made from.
#[inline(always)]
pub(crate) fn light_numbers(rng: &mut impl Rng) -> [f64; 2] {
    [uniform(rng), f64::from(uniform_f32(rng))]
}

/// Draws x_0 on `region` by power, with density M/power per area; of a distant x_0 per solid angle.
#[inline(always)]
pub(crate) fn start_at_light(view: &View, region: &LightRegion, [u, v]: [f64; 2]) -> (PathVertex, LightPoint) {
    let point = region.sample(u, v);
    (start_at(view, &point).0, point)
}

/// Draws x_0 on `region` for x_1, with density λ M/power per area or, of a distant x_0, per solid angle; returns λ, the region's
/// [`preference`](LightRegion::preference), as well.
#[inline(always)]
pub(crate) fn start_near(
    view: &View,
    region: &LightRegion,
    x_1: &PathVertex,
    numbers: [f64; 2],
) -> (PathVertex, LightPoint, f64) {
    let receiver = Receiver { scene: view.scene, vertex: x_1.vertex, towards: x_1.to_eye };
    let (point, density) = region.light_sampler().sample(&receiver, numbers);
    let (x, light) = start_at(view, &point);
    (x, point, region.preference_of(density, light.mean_exitance()))
}

#[inline(always)]
fn start_at<'a>(view: &View<'a>, point: &LightPoint) -> (PathVertex, &'a Light) {
    let (light, vertex) = view.scene.light_point(point);
    let mut x = PathVertex::new(vertex);
    x.forward = view.scene.exitance(light, &vertex);
    (x, light)
}

/// Draws x_{i+1} from x_i, and sets the edge between them. The edge from x_{i−1} must be set.
#[inline(always)]
pub(crate) fn step_from_light(vertices: &mut [PathVertex], i: usize, view: &View, rng: &mut impl Rng) -> Option<()> {
    let x = &vertices[i].vertex;
    let ray = match i {
        0 => view.scene.sample_emission(x, rng),
        _ => x.ray(view.scene.surface(x, &mut Resolved::default()).sample(-vertices[i - 1].to_eye, rng)?),
    };
    follow_from_light(vertices, i, ray, view, rng)
}

/// Follows a ray, given by its origin and its direction, from x_i to x_{i+1}, and sets the edge between them. Light that leaves the
/// scene lights nothing.
#[inline(always)]
pub(crate) fn follow_from_light(
    vertices: &mut [PathVertex],
    i: usize,
    (origin, direction): (Vec3A, Vec3A),
    view: &View,
    rng: &mut impl Rng,
) -> Option<()> {
    let (seen, passed) = view.scene.follow_ray(origin, direction, rng).filter(|(seen, _)| !seen.is_distant())?;
    vertices[i + 1] = PathVertex::new(seen);
    let x = &mut vertices[i];
    set_edge(x, Edge::along(direction, &x.vertex, &seen).veiled(passed));
    Some(())
}

/// Follows the ray through a film point from x_i, on the lens, to x_{i−1}, and sets the edge between them.
#[inline(always)]
pub(crate) fn start_at_eye(
    vertices: &mut [PathVertex],
    i: usize,
    film: Vec2,
    view: &View,
    rng: &mut impl Rng,
) -> Option<()> {
    let ray = view.camera.sample(film, &vertices[i].vertex);
    let direction = ray.direction();
    let seen = view.scene.follow_camera_ray(ray.origin, direction, rng)?;
    add_towards_light(vertices, i, direction, seen);
    Some(())
}

/// Draws x_{i−1} from x_i, a surface, and sets the edge between them. The edge to x_{i+1} must be set.
#[inline(always)]
pub(crate) fn step_from_eye(vertices: &mut [PathVertex], i: usize, view: &View, rng: &mut impl Rng) -> Option<()> {
    let x = &vertices[i];
    let direction = view.scene.surface(&x.vertex, &mut Resolved::default()).sample(x.to_eye, rng)?;
    follow_from_eye(vertices, i, direction, view, rng)
}

/// Follows a direction from x_i to x_{i−1}, and sets the edge between them.
#[inline(always)]
pub(crate) fn follow_from_eye(
    vertices: &mut [PathVertex],
    i: usize,
    direction: Vec3A,
    view: &View,
    rng: &mut impl Rng,
) -> Option<()> {
    let seen = view.scene.follow(&vertices[i].vertex, direction, rng)?;
    add_towards_light(vertices, i, direction, seen);
    Some(())
}

/// Sets x_{i−1}, seen from x_i in a direction through what lets a share pass, and the edge between them.
#[inline(always)]
fn add_towards_light(vertices: &mut [PathVertex], i: usize, direction: Vec3A, (seen, passed): (Vertex, f32)) {
    let mut x = PathVertex::new(seen);
    set_edge(&mut x, Edge::along(-direction, &seen, &vertices[i].vertex).veiled(passed));
    vertices[i - 1] = x;
}
