//! Rays per second: our acceleration structure beside obvhs's own traversals, on the same rays in the same run.
//!
//! `cargo bench -p mlt-benches --bench traversal`; the million-triangle scene takes a while: name another to skip it,
//! `… -- interior/incoherent`.

use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use glam::{Vec3, Vec3A};
use mlt_core::transport::{accel::Accel, math, ray::Ray};
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::{BvhBuildParams, ray::Ray as ObvhsRay, ray::RayHit, triangle::Triangle};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::f32::consts::{PI, TAU};
use std::time::Duration;

/// Camera rays along each side of the image.
const RESOLUTION: usize = 128;

/// What obvhs's own traversals need.
struct Obvhs {
    bvh2: Bvh2,
    bvh2_triangles: Vec<Triangle>,
    cwbvh: CwBvh,
    cwbvh_triangles: Vec<Triangle>,
}

impl Obvhs {
    fn new(triangles: &[[Vec3; 3]]) -> Self {
        let triangles: Vec<_> =
            triangles.iter().map(|t| Triangle { v0: t[0].into(), v1: t[1].into(), v2: t[2].into() }).collect();
        let mut time = Duration::default();
        let bvh2 = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut time);
        let cwbvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut time);
        let in_order = |indices: &[u32]| indices.iter().map(|&i| triangles[i as usize]).collect();
        let (bvh2_triangles, cwbvh_triangles) = (in_order(&bvh2.primitive_indices), in_order(&cwbvh.primitive_indices));
        Self { bvh2, bvh2_triangles, cwbvh, cwbvh_triangles }
    }
}

fn obvhs_ray(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(Vec3A::from(ray.origin), Vec3A::from(ray.direction), 0.0, ray.t_max)
}

/// Triangles and where the camera and the light are.
struct Scene {
    name: &'static str,
    triangles: Vec<[Vec3; 3]>,
    eye: Vec3,
    light: Vec3,
}

/// A smooth closed surface of 4n² triangles about `centre`, its radius a few waves.
fn blob(n: usize, centre: Vec3, radius: f32) -> Vec<[Vec3; 3]> {
    let point = |i: usize, j: usize| {
        let (theta, phi) = (PI * i as f32 / n as f32, TAU * (j % (2 * n)) as f32 / (2 * n) as f32);
        let direction = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        centre + radius * (1.0 + 0.2 * (5.0 * theta).sin() * (3.0 * phi).cos()) * direction
    };
    let quad = |(i, j): (usize, usize)| {
        let (a, b, c, d) = (point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))).flat_map(quad).collect()
}

/// The twelve triangles of a box turned about the vertical.
fn cuboid(centre: Vec3, half: Vec3, angle: f32) -> Vec<[Vec3; 3]> {
    let turn = glam::Mat3::from_rotation_y(angle);
    let corner = |signs: Vec3| centre + turn * (half * signs);
    (0..6)
        .flat_map(|face| {
            let (axis, side) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
            let at = |u: f32, v: f32| {
                let mut signs = Vec3::splat(side);
                (signs[(axis + 1) % 3], signs[(axis + 2) % 3]) = (u, v);
                corner(signs)
            };
            let [a, b, c, d] = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// A room with two blocks, 36 triangles.
fn room() -> Vec<[Vec3; 3]> {
    let walls = cuboid(Vec3::ZERO, Vec3::ONE, 0.0);
    let tall = cuboid(Vec3::new(-0.35, -0.4, -0.3), Vec3::new(0.3, 0.6, 0.3), 0.3);
    let low = cuboid(Vec3::new(0.35, -0.7, 0.3), Vec3::splat(0.3), -0.3);
    [walls, tall, low].concat()
}

/// The room with shelves of small blobs: a mixture of huge and tiny triangles.
fn interior() -> Vec<[Vec3; 3]> {
    let mut triangles = room();
    for k in 0..16 {
        let (x, y, z) = (k % 4, k / 4 % 2, k / 8);
        let centre = Vec3::new(0.45 * x as f32 - 0.7, 0.5 * y as f32 + 0.2, 0.8 * z as f32 - 0.6);
        triangles.extend(blob(30, centre, 0.15));
    }
    triangles
}

fn scenes() -> [Scene; 4] {
    let (inside, above) = (Vec3::new(0.0, 0.0, 0.95), Vec3::new(0.0, 0.95, 0.0));
    let (outside, lamp) = (Vec3::new(0.0, 0.5, 3.0), Vec3::new(2.0, 3.0, 2.0));
    [
        Scene { name: "box", triangles: room(), eye: inside, light: above },
        Scene { name: "blob", triangles: blob(64, Vec3::ZERO, 1.0), eye: outside, light: lamp },
        Scene { name: "interior", triangles: interior(), eye: inside, light: above },
        Scene { name: "million", triangles: blob(500, Vec3::ZERO, 1.0), eye: outside, light: lamp },
    ]
}

fn uniform(rng: &mut Pcg32) -> f32 {
    (rng.next_u32() >> 8) as f32 / 16_777_216.0
}

fn primary_rays(eye: Vec3) -> Vec<Ray> {
    let at = |k: usize| 0.7 * (2.0 * (k as f32 + 0.5) / RESOLUTION as f32 - 1.0);
    let forward = (-0.3 * eye.y * Vec3::Y - Vec3::Z).normalize();
    let direction = |x, y| (forward + at(x) * Vec3::X + at(y) * Vec3::Y).normalize();
    (0..RESOLUTION * RESOLUTION).map(|k| Ray::new(eye, direction(k % RESOLUTION, k / RESOLUTION))).collect()
}

/// From what the camera sees: one ray in a cosine-weighted direction, one segment to a point of the light.
fn secondary_rays(scene: &Scene, accel: &Accel, primary: &[Ray]) -> (Vec<Ray>, Vec<Ray>) {
    let mut rng = Pcg32::seed_from_u64(1);
    let mut rays = (Vec::new(), Vec::new());
    for ray in primary {
        let Some(hit) = accel.closest(ray) else { continue };
        let [a, b, c] = scene.triangles[hit.primitive as usize];
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let origin = ray.origin + hit.t * ray.direction + 1e-4 * normal;
        let u = glam::Vec2::new(uniform(&mut rng), uniform(&mut rng));
        rays.0.push(Ray::new(origin, math::cosine_hemisphere(normal, u)));
        let target = scene.light + 0.2 * Vec3::new(uniform(&mut rng) - 0.5, 0.0, uniform(&mut rng) - 0.5);
        rays.1.push(Ray { origin, direction: target - origin, t_max: 0.999 });
    }
    rays
}

fn nearest_hits(group: &mut BenchmarkGroup<WallTime>, rays: &[Ray], ours: &Accel, obvhs: &Obvhs) {
    let theirs: Vec<_> = rays.iter().map(obvhs_ray).collect();
    group.throughput(Throughput::Elements(rays.len() as u64));
    group.bench_function(BenchmarkId::from_parameter("ours"), |b| {
        b.iter(|| rays.iter().filter_map(|ray| ours.closest(ray)).map(|hit| hit.t).sum::<f32>())
    });
    group.bench_function(BenchmarkId::from_parameter("obvhs_bvh2"), |b| {
        b.iter(|| {
            let nearest = |ray: &ObvhsRay| {
                let mut hit = RayHit::none();
                let found = obvhs.bvh2.ray_traverse(*ray, &mut hit, |ray, i| obvhs.bvh2_triangles[i].intersect(ray));
                if found { hit.t } else { 0.0 }
            };
            theirs.iter().map(nearest).sum::<f32>()
        })
    });
    group.bench_function(BenchmarkId::from_parameter("obvhs_cwbvh"), |b| {
        b.iter(|| {
            let nearest = |ray: &ObvhsRay| {
                let mut hit = RayHit::none();
                let found = obvhs.cwbvh.ray_traverse(*ray, &mut hit, |ray, i| obvhs.cwbvh_triangles[i].intersect(ray));
                if found { hit.t } else { 0.0 }
            };
            theirs.iter().map(nearest).sum::<f32>()
        })
    });
}

fn any_hits(group: &mut BenchmarkGroup<WallTime>, rays: &[Ray], ours: &Accel, obvhs: &Obvhs) {
    let theirs: Vec<_> = rays.iter().map(obvhs_ray).collect();
    group.throughput(Throughput::Elements(rays.len() as u64));
    group.bench_function(BenchmarkId::from_parameter("ours"), |b| {
        b.iter(|| rays.iter().filter(|ray| ours.occluded(ray)).count())
    });
    group.bench_function(BenchmarkId::from_parameter("obvhs_bvh2"), |b| {
        let free =
            |ray: &&ObvhsRay| obvhs.bvh2.ray_traverse_miss(**ray, |ray, i| obvhs.bvh2_triangles[i].intersect(ray));
        b.iter(|| theirs.iter().filter(free).count())
    });
    group.bench_function(BenchmarkId::from_parameter("obvhs_cwbvh"), |b| {
        let free =
            |ray: &&ObvhsRay| obvhs.cwbvh.ray_traverse_miss(**ray, |ray, i| obvhs.cwbvh_triangles[i].intersect(ray));
        b.iter(|| theirs.iter().filter(free).count())
    });
}

fn traversal(criterion: &mut Criterion) {
    for scene in scenes() {
        let (ours, obvhs) = (Accel::new(&scene.triangles), Obvhs::new(&scene.triangles));
        let primary = primary_rays(scene.eye);
        let (incoherent, shadow) = secondary_rays(&scene, &ours, &primary);
        let mut group = |kind: &str, run: &dyn Fn(&mut BenchmarkGroup<WallTime>)| {
            run(&mut criterion.benchmark_group(format!("{}/{kind}", scene.name)));
        };
        group("primary", &|group| nearest_hits(group, &primary, &ours, &obvhs));
        group("incoherent", &|group| nearest_hits(group, &incoherent, &ours, &obvhs));
        group("shadow", &|group| any_hits(group, &shadow, &ours, &obvhs));
    }
}

fn quick() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
}

criterion_group! { name = benches; config = quick(); targets = traversal }
criterion_main!(benches);
