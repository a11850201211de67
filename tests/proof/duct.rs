//! A room that is seen only through a periscope of ten mirrors: no path that carries light has fewer than 12 edges.
//!
//! Methods that fix the length of a chain's paths by a bootstrap fail here: the lengths that it missed get no chain, and
//! the image converges to something darker, which differs from seed to seed. Here length is a number like the others.

use glam::{DVec3, Vec3};
use mlt_core::engine::Film;
use mlt_core::transport::bsdf::{Bsdf, Lambert, Mirror};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::image::luminance_and_error;
use mlt_core::transport::render::{Method, Renderer, Settings};
use mlt_core::transport::scene::{Camera, CameraPose, Lens, Material, Scene, SceneDescription, View};
use std::ops::ControlFlow;

const MIRRORS: usize = 10;
const SPACING: f64 = 2.0;
const SIDE: u32 = 8;
const SEEDS: u64 = 60;
const ROUNDS: u64 = 16;
const MIRROR: u32 = 0;
const WHITE: u32 = 1;
const LAMP: u32 = 2;

fn material(name: &str, bsdf: Bsdf, emission: Vec3) -> Material {
    Material { name: name.into(), bsdf, emission, ..Material::default() }
}

/// The parallelogram centre ± a ± b, its front towards a × b.
fn quad(name: &str, material: u32, centre: DVec3, a: DVec3, b: DVec3) -> Mesh {
    Mesh {
        name: name.into(),
        positions: vec![centre - a - b, centre + a - b, centre + a + b, centre - a + b],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

/// A staircase of mirrors, +x and +y in turn, that leads into a white room with a lamp beside the entrance.
fn duct() -> (Scene, Camera) {
    let direction = |i: usize| if i.is_multiple_of(2) { DVec3::X } else { DVec3::Y };
    let mut meshes = Vec::new();
    let mut at = DVec3::ZERO;
    for i in 0..MIRRORS {
        let along = 0.45 * (DVec3::X + DVec3::Y);
        meshes.push(quad("mirror", MIRROR, at, along, 0.6 * DVec3::Z));
        at += SPACING * direction(i + 1);
    }
    // Ten mirrors lead back to +x: the room is a box of half-width 1 around its centre, open where the light leaves.
    let centre = at + DVec3::X;
    for (normal, a, b) in [
        (DVec3::NEG_X, DVec3::Y, DVec3::Z),
        (DVec3::NEG_Y, DVec3::Z, DVec3::X),
        (DVec3::Y, DVec3::Z, DVec3::X),
        (DVec3::NEG_Z, DVec3::X, DVec3::Y),
        (DVec3::Z, DVec3::X, DVec3::Y),
    ] {
        meshes.push(quad("wall", WHITE, centre - normal, a, b));
    }
    meshes.push(quad("lamp", LAMP, centre + DVec3::new(-0.5, 0.95, 0.0), 0.3 * DVec3::X, 0.3 * DVec3::Z));
    let description = SceneDescription {
        meshes,
        materials: vec![
            material("mirror", Bsdf::Mirror(Mirror { f0: Vec3::ONE }), Vec3::ZERO),
            material("white", Bsdf::Lambert(Lambert { reflectance: Vec3::splat(0.8) }), Vec3::ZERO),
            material("lamp", Bsdf::Black, Vec3::ONE),
        ],
        ..SceneDescription::default()
    };
    let pose = CameraPose {
        name: "eye".into(),
        position: DVec3::new(-1.0, 0.0, 0.0),
        forward: Vec3::X,
        up: Vec3::Z,
        lens: Lens::Pinhole { vertical_fov: 2f32.to_radians() },
        aspect_ratio: None,
    };
    let scene = Scene::new(description).expect("valid");
    let camera = scene.camera(&pose, [SIDE; 2]);
    (scene, camera)
}

fn mean(film: &Film<3>) -> f64 {
    (0..film.sites() as usize).map(|i| luminance_and_error(film, i).0).sum::<f64>() / f64::from(film.sites())
}

/// Mean luminance of the image over rounds, and its standard error.
fn estimate(view: View, method: Method, max_edges: usize, per_pixel: f64, seed: u64) -> (f64, f64) {
    let settings = Settings::new(method, per_pixel).with(|s| (s.max_edges, s.seed) = (Some(max_edges), seed));
    let renderer = Renderer::new(view, settings);
    let round = |r: u64| {
        let mut sums = renderer.sums();
        renderer.render(r..r + 1, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        mean(sums.film())
    };
    let rounds: Vec<f64> = (0..ROUNDS).map(round).collect();
    let n = ROUNDS as f64;
    let mean = rounds.iter().sum::<f64>() / n;
    let variance = rounds.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// (estimate − reference) / standard error for every seed, and for the mean over the seeds.
fn scores(view: View, method: Method, max_edges: usize, per_pixel: f64, reference: (f64, f64)) -> (Vec<f64>, f64) {
    let score = |(m, e): (f64, f64)| (m - reference.0) / (e * e + reference.1 * reference.1).sqrt();
    let estimates: Vec<_> = (0..SEEDS).map(|seed| estimate(view, method, max_edges, per_pixel, seed)).collect();
    let n = SEEDS as f64;
    let mean = estimates.iter().map(|e| e.0).sum::<f64>() / n;
    let error = (estimates.iter().map(|e| (e.0 - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    (estimates.into_iter().map(score).collect(), score((mean, error)))
}

#[test]
fn no_path_with_fewer_than_twelve_edges_carries_light() {
    let (scene, camera) = duct();
    let view = View { scene: &scene, camera: &camera };
    assert_eq!(estimate(view, Method::Bidirectional, 11, 16.0, 1).0, 0.0);
    assert!(estimate(view, Method::Bidirectional, 12, 16.0, 1).0 > 0.0);
}

#[test]
fn no_seed_misses_a_length() {
    let (scene, camera) = duct();
    let view = View { scene: &scene, camera: &camera };
    let reference = estimate(view, Method::Bidirectional, 40, 256.0, 1);
    assert!(reference.1 < 0.005 * reference.0, "{reference:?}");
    for (method, per_pixel) in [(Method::Multiplexed, 128.0), (Method::PrimaryBidirectional, 8.0)] {
        let (each, all) = scores(view, method, 40, per_pixel, reference);
        let worst = each.iter().fold(0.0f64, |worst, z| worst.max(z.abs()));
        // t with 15 degrees of freedom, two-sided p = 0.01 over 60 seeds.
        assert!(worst < 5.0, "{method:?}: {each:?}");
        assert!(all.abs() < 4.0, "{method:?}: mean over the seeds: z = {all}");
    }
    let (each, all) = scores(view, Method::Multiplexed, 13, 128.0, reference);
    let dark = each.iter().filter(|z| **z < -5.0).count();
    assert!(all < -6.0 && dark > 0, "the control, without long paths, goes unnoticed: z = {all}, {dark} seeds");
}
