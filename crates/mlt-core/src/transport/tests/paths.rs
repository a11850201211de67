//! Weights of techniques, and the values that a path carries.

use super::worlds::{World, glass, quad, walls, worlds};
use crate::engine::{Purpose, generator, uniform, uniform_f32};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::methods::Bidirectional;
use crate::transport::paths::mis::Ends;
use crate::transport::paths::path_vertex::set_edge;
use crate::transport::paths::{Edge, LightPath, PathVertex, mis};
use crate::transport::scene::Scene;
use glam::{DVec3, Vec2, Vec3A};
use std::collections::BTreeMap;

/// Shows the connected paths of `samples` samples.
fn visit_paths(world: &World, samples: u64, visit: impl FnMut(&LightPath, f64)) {
    visit_paths_from(&LightRegion::whole(world.scene.lights()), world, samples, visit);
}

/// Shows those of light subpaths that start in a region.
fn visit_paths_from(region: &LightRegion, world: &World, samples: u64, mut visit: impl FnMut(&LightPath, f64)) {
    let sampler = Bidirectional { view: world.view(), region, max_edges: 12 };
    for i in 0..samples {
        sampler.sample_paths(&mut generator(7, Purpose::Sample, 0, 0, i), &mut visit);
    }
}

/// All lights, and a few parts of them.
fn regions(world: &World) -> impl Iterator<Item = LightRegion> {
    let cuts = [Stratification::None, Stratification::Count(3), Stratification::Grid(2, 1)];
    cuts.into_iter().flat_map(|cut| LightStrata::new(world.scene.lights(), cut).regions().to_vec())
}

#[test]
fn weights_of_all_techniques_of_a_path_sum_to_one() {
    for ((name, world), region) in worlds().iter().flat_map(|world| regions(&world.1).map(move |r| (world, r))) {
        let mut paths = 0;
        visit_paths_from(&region, world, 1000, |path, _| {
            let ends = Ends::new(path, &world.view(), &region, 0.3);
            let vertices = path.vertices();
            let density = |s: usize| if mis::connectible(vertices, s) { mis::density(vertices, s, ends) } else { 0.0 };
            let densities: Vec<f64> = (0..vertices.len()).map(density).collect();
            let squares: f64 = densities.iter().map(|p| p * p).sum();
            let mut sum = 0.0;
            for (s, p) in densities.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                let weight = mis::weight(vertices, s, ends);
                assert!((weight - p * p / squares).abs() < 1e-9, "{name}: technique {s} of {}", vertices.len());
                sum += weight;
            }
            assert!((sum - 1.0).abs() < 1e-9, "{name}: {sum} over {} vertices", vertices.len());
            paths += 1;
        });
        assert!(paths > 500, "{name}: {paths} paths");
    }
}

/// A path between diffuse surfaces whose geometric terms are about 10^`exponent` each.
pub(crate) fn long_path(edges: usize, exponent: f64, seed: u64) -> LightPath {
    let mut rng = generator(seed, Purpose::Sample, 0, 0, 0);
    let mut vertices = vec![PathVertex::new(Vertex::camera(Vec3A::ZERO, Vec3A::Z)); edges + 1];
    for i in 0..edges {
        let cosines = [(); 2].map(|()| 0.5 + 0.5 * uniform(&mut rng));
        let per_square = libm::exp10(exponent + uniform(&mut rng) - 0.5);
        let [here, there] = &mut vertices[i..i + 2] else { unreachable!() };
        here.geometric_term = cosines[0] * cosines[1] * per_square;
        [here.reverse, there.forward] = [here.geometric_term; 2];
    }
    vertices.iter_mut().for_each(|x| x.scatter = Rgb::splat(0.9));
    (vertices[0].forward, vertices[edges].reverse) = (1.0, 1.0);
    LightPath { vertices, ..LightPath::default() }
}

/// 200 edges in a room that is small or large for its unit of length. The plain products are the control.
#[test]
fn long_paths_stay_finite_in_any_unit() {
    for exponent in [-9.0, 0.0, 9.0] {
        let mut path = long_path(200, exponent, 1);
        let ends = Ends { power: 2.0, preference: 1.0, area: 1.0 };
        path.contribution = path.product();
        let first = path.vertices[0].geometric_term;
        let expected = 0.9f64.powi(201) * first;
        assert!((path.contribution.x / expected - 1.0).abs() < 1e-4, "{exponent}: {}", path.contribution.x / expected);
        let vertices = path.vertices();
        let weights: f64 = (0..=200).map(|s| mis::weight(vertices, s, ends)).sum();
        assert!((weights - 1.0).abs() < 1e-9, "{exponent}: {weights}");
        assert!((0..=200).all(|s| mis::density(vertices, s, ends).is_normal()), "{exponent}");
        let plain: f64 = vertices.iter().map(|x| x.geometric_term).take(200).product();
        assert_eq!(plain.is_normal(), exponent == 0.0, "{exponent}: {plain}");
    }
}

/// Through a pane no thicker than a few rounding errors of its position light goes on in parallel. The direction from one face to
/// the other, by their points, is the control.
#[test]
fn light_leaves_a_thin_pane_as_it_came() {
    let face = |y: f64, x: f64| quad([[-x, 0.9], [x, 0.9], [x, -0.9], [-x, -0.9]].map(|[x, z]| DVec3::new(x, y, z)));
    let world = walls().surface(face(0.3, -0.9), glass(0.0)).surface(face(0.30001, 0.9), glass(0.0)).seen(
        DVec3::new(0.2, 0.1, 3.4),
        DVec3::ZERO,
        38.0,
        [16, 16],
    );
    let (mut turns, mut inside) = (0f32, 0f32);
    visit_paths(&world, 2000, |path, _| {
        for [before, a, b] in path.vertices().array_windows() {
            let through = before.to_eye.y * a.to_eye.y > 0.0 && a.to_eye.y * b.to_eye.y > 0.0;
            if through && a.vertex.delta && b.vertex.delta {
                turns = turns.max(before.to_eye.distance(b.to_eye));
                let step = b.vertex.position - a.vertex.position;
                inside = inside.max(a.to_eye.distance(step.normalize_or_zero()));
            }
        }
    });
    assert!(turns < 1e-5 && inside > 1e-3, "{turns} and {inside}");
}

#[test]
fn cached_values_equal_recomputed_ones() {
    for (name, world) in worlds() {
        visit_paths(&world, 2000, |path, _| check_recomputed(name, path, &world));
    }
}

/// Without paths, the same subpaths give every pixel the same.
#[test]
fn samples_for_the_image_are_those_of_paths() {
    for ((name, world), region) in worlds().iter().flat_map(|world| regions(&world.1).map(move |r| (world, r))) {
        let sampler = Bidirectional { view: world.view(), region: &region, max_edges: 12 };
        let mut lit = 0;
        for i in 0..1000 {
            let rng = || generator(8, Purpose::Sample, 0, 0, i);
            let [mut paths, mut image] = [BTreeMap::new(), BTreeMap::new()];
            sampler.sample_paths(&mut rng(), &mut |path, weight| {
                *paths.entry(path.pixel).or_insert(DVec3::ZERO) += path.contribution * weight;
            });
            let mut rng = rng();
            let point = Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng));
            let here = world.camera.pixel(point);
            sampler.sample_image(point, &mut rng, &mut |pixel, value, _| {
                *image.entry(pixel.unwrap_or(here)).or_insert(DVec3::ZERO) += value;
            });
            image.retain(|_, value| *value != DVec3::ZERO);
            lit += image.len();
            assert_eq!(paths.len(), image.len(), "{name}, sample {i}");
            for ((p, a), (q, b)) in paths.iter().zip(&image) {
                assert!(p == q && (a - b).length() < 1e-5 * a.length(), "{name}, sample {i}: {a} and {b} in {p}");
            }
        }
        assert!(lit > 500, "{name}: {lit}");
    }
}

/// Computes the edges from their ends and directions, and from what passes.
pub(crate) fn set_edges_anew(path: &mut LightPath, scene: &Scene) {
    for i in 0..path.edges() {
        let [x, y] = [0, 1].map(|end| path.vertices[i + end].vertex);
        let edge = Edge::along(path.vertices[i].to_eye, &x, &y).veiled(scene.transmittance(&x, &y).unwrap_or(0.0));
        set_edge(&mut path.vertices[i], edge);
    }
}

/// Whether everything a path carries follows from its vertices and the directions between them.
pub(crate) fn check_recomputed(name: &str, path: &LightPath, world: &World) {
    let mut again = path.clone();
    again.vertices.iter_mut().for_each(|v| *v = PathVertex { to_eye: v.to_eye, ..PathVertex::new(v.vertex) });
    let last = path.edges();
    set_edges_anew(&mut again, &world.scene);
    again.update(&world.view(), 0..=last).unwrap();
    assert_eq!(path.contribution, again.contribution, "{name}");
    // The film point is the one that was drawn; its ray leads back there but for rounding.
    let crossed = world
        .camera
        .project(&again.vertices[last].vertex, &again.vertices[last - 1].vertex, -again.vertices[last - 1].to_eye)
        .unwrap();
    assert!(path.film.distance(crossed) < 1e-5, "{name}: {} and {crossed}", path.film);
    assert_eq!(path.pixel, world.camera.pixel(path.film), "{name}");
    for (i, (a, b)) in path.vertices().iter().zip(again.vertices()).enumerate() {
        assert_eq!(a.scatter, b.scatter, "{name}: scatter of {i} in {last}");
        // The camera is never drawn.
        assert!(i == last || a.forward == b.forward, "{name}: forward of {i} in {last}");
        assert_eq!(a.reverse, b.reverse, "{name}: reverse of {i} in {last}");
    }
    let x = &path.vertices()[0].vertex;
    let point = world.scene.lights().point(x.primitive, x.position).unwrap();
    let near = |a: f64, b: f64| !x.can_be_met() || (a - b).abs() < 1e-4;
    assert!(point.light == path.light.light && near(point.u, path.light.u) && near(point.v, path.light.v), "{name}");
}
