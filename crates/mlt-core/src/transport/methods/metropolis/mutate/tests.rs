//! One step of each perturbation alone leaves a distribution stationary; with a wrong ratio it does not.
//!
//! The distribution is π(x) = Σ_s p_s(x), the sum of the densities with which the bidirectional sampler makes x, so that its
//! samples have weights near 1: w_s π / p_s ≤ √n. Stationarity is E_π[a(x→y) (g(y) − g(x))] = 0 for every function g.

use super::event::microfacet;
use super::{PathMutation, Perturbations};
use crate::engine::{Mutation, Purpose, generator};
use crate::transport::bsdf::microfacet::Ggx;
use crate::transport::bsdf::{Bsdf, Conductor, Dielectric, Lambert, Mirror, RoughDielectric};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Mesh;
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::methods::metropolis::stratum::LightStratum;
use crate::transport::paths::mis::Ends;
use crate::transport::paths::{LightPath, mis};
use crate::transport::scene::{CameraPose, Lens, Material, Resolved, Scene, SceneDescription, View};
use crate::transport::tests::paths::set_edges_anew;
use crate::transport::tests::worlds::{World, cloudy, lambert, mirror, room};
use glam::{DVec3, Vec3A};
use std::f64::consts::{PI, TAU};

const MOST_EDGES: usize = 6;

fn quad(corners: [[f64; 3]; 4], material: u32) -> Mesh {
    Mesh { material, ..Mesh::quad(corners.map(DVec3::from)) }
}

fn ball(centre: DVec3, radius: f64, material: u32) -> Mesh {
    const ROWS: u32 = 10;
    const COLUMNS: u32 = 16;
    let direction = |i: u32, j: u32| {
        let (theta, phi) = (PI * f64::from(i) / f64::from(ROWS), TAU * f64::from(j % COLUMNS) / f64::from(COLUMNS));
        DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let grid = || (0..=ROWS).flat_map(|i| (0..=COLUMNS).map(move |j| direction(i, j)));
    let corner = |i: u32, j: u32| i * (COLUMNS + 1) + j;
    let cell = |i, j| {
        [[corner(i, j), corner(i, j + 1), corner(i + 1, j)], [corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)]]
    };
    Mesh {
        positions: grid().map(|n| centre + radius * n).collect(),
        normals: grid().map(|n| n.as_vec3()).collect(),
        triangles: (0..ROWS).flat_map(|i| (0..COLUMNS).flat_map(move |j| cell(i, j))).collect(),
        material,
        ..Mesh::default()
    }
}

/// A glass ball and a mirror over a floor, before a wall, under a lamp or under a cloudy sky.
fn scene(sky: bool) -> Scene {
    let glass = Bsdf::Dielectric(Dielectric { ior: 1.5, tint: Rgb::ONE });
    scene_of(sky, [glass, Bsdf::Mirror(Mirror { f0: Rgb::splat(0.9) })])
}

/// The same with a ball of rough glass and a plate of brushed metal, whose lobes are narrow.
fn narrow_scene() -> Scene {
    let ggx = Ggx { alpha: 0.005 };
    let glass = Bsdf::RoughDielectric(RoughDielectric::new(1.5, Rgb::ONE, ggx));
    scene_of(false, [glass, Bsdf::Conductor(Conductor::new(Rgb::splat(0.9), 1.0, ggx))])
}

fn scene_of(sky: bool, [ball_of, plate_of]: [Bsdf; 2]) -> Scene {
    let material = |bsdf, emission| Material { bsdf, emission, ..Material::default() };
    let materials = vec![
        material(Bsdf::Lambert(Lambert { reflectance: Rgb::splat(0.7) }), Rgb::ZERO),
        material(Bsdf::Black, Rgb::splat(if sky { 0.0 } else { 10.0 })),
        material(ball_of, Rgb::ZERO),
        material(plate_of, Rgb::ZERO),
    ];
    let meshes = vec![
        quad([[-2., 0., -2.], [-2., 0., 2.], [2., 0., 2.], [2., 0., -2.]], 0),
        quad([[-2., 0., -1.], [2., 0., -1.], [2., 3., -1.], [-2., 3., -1.]], 0),
        quad([[-0.7, 2.5, -0.7], [0.7, 2.5, -0.7], [0.7, 2.5, 0.7], [-0.7, 2.5, 0.7]], 1),
        ball(DVec3::new(-0.3, 0.8, 0.1), 0.6, 2),
        quad([[1.2, 0.1, 1.], [1.5, 0.1, -1.], [1.5, 2., -1.], [1.2, 2., 1.]], 3),
    ];
    let environment = sky.then(cloudy);
    Scene::new(SceneDescription { meshes, materials, environment, ..SceneDescription::default() }).expect("valid")
}

fn pose() -> CameraPose {
    let forward = Vec3A::new(0.05, -0.25, -1.0).normalize();
    let up = forward.cross(Vec3A::Y).cross(forward).normalize();
    let position = DVec3::new(0.1, 1.7, 3.5);
    CameraPose {
        name: String::new(),
        position,
        forward: forward.into(),
        up: up.into(),
        lens: Lens::Pinhole { vertical_fov: 0.9 },
        aspect_ratio: None,
    }
}

/// π/g.
fn target(path: &LightPath, view: &View, region: &LightRegion) -> f64 {
    let ends = Ends::new(path, view, region, 1.0);
    let technique =
        |s: usize| if mis::connectible(&path.vertices, s) { mis::density(&path.vertices, s, ends) } else { 0.0 };
    (0..path.vertices.len()).map(technique).sum()
}

/// Π P(event) over the specular vertices.
fn events(view: &View, path: &LightPath) -> f64 {
    let probability = |i: usize| {
        let x = &path.vertices[i];
        f64::from(
            view.scene
                .surface(&x.vertex, &mut Resolved::default())
                .event_probability(x.to_eye, -path.vertices[i - 1].to_eye),
        )
    };
    (1..path.edges()).filter(|&i| path.vertices[i].vertex.delta).map(probability).product()
}

/// Bounded functions of a path that a wrong ratio moves: cosines, lengths, and probabilities of events.
fn features(view: &View, path: &LightPath) -> [f64; 15] {
    let mut features = vec![f64::from(path.film.x), f64::from(path.film.y), events(view, path)];
    for i in (0..path.edges()).rev().take(4) {
        let [x, next] = [&path.vertices[i], &path.vertices[i + 1]];
        features.push(f64::from(x.vertex.geometric_normal.dot(x.to_eye).abs()));
        features.push(f64::from(next.vertex.geometric_normal.dot(x.to_eye).abs()));
        features.push(1.0 / (1.0 + f64::from(x.inverse_square)));
    }
    features.resize(15, 0.0);
    features.try_into().expect("as many")
}

/// Largest |z| over the features' mean drifts in one step of the mutation of that name, over paths that it applies to, and
/// its acceptance. Ratios are taken as wrong by the factor error(x)/error(y).
fn drift(name: &str, error: impl Fn(&View, &LightPath) -> f64) -> (f64, f64) {
    drift_in(&scene(false), 400_000, name, error)
}

/// The same in a scene, of so many samples.
fn drift_in(scene: &Scene, samples: u64, name: &str, error: impl Fn(&View, &LightPath) -> f64) -> (f64, f64) {
    let camera = scene.camera(&pose(), [64, 64]);
    let view = View { scene, camera: &camera };
    let strata = LightStrata::new(scene.lights(), Stratification::None);
    let within = &LightStratum::all(&strata, view, MOST_EDGES)[0];
    let region = LightRegion::whole(scene.lights());
    let sampler = Bidirectional { view, region: &region, max_edges: MOST_EDGES };
    let named = |m: &PathMutation| Mutation::<LightPath, LightStratum>::name(m) == name;
    let mutation = PathMutation::all(view).into_iter().find(named).expect("set up");
    let applies = |x: &LightPath| Mutation::<LightPath, LightStratum>::suitability(&mutation, x) > 0.0;
    let mut proposal = LightPath::default();
    let (mut sums, mut squares) = ([0.0; 15], [0.0; 15]);
    let (mut accepted, mut proposed) = (0.0, 0.0);
    for sample in 0..samples {
        let mut rng = generator(7, Purpose::Chain, 0, 0, sample);
        let mut drifts = [0.0; 15];
        sampler.sample_paths(&mut generator(7, Purpose::Sample, 0, 0, sample), &mut |x, weight| {
            if !applies(x) {
                return;
            }
            proposed += 1.0;
            let before = target(x, &view, &region);
            let Some(ratio) = mutation.propose(x, &mut proposal, within, &mut rng) else { return };
            assert!(applies(&proposal), "{name} leads to where it does not apply");
            let ratio = ratio * error(&view, x) / error(&view, &proposal);
            let acceptance = (target(&proposal, &view, &region) * ratio / before).min(1.0);
            accepted += acceptance;
            for ((drift, g), h) in drifts.iter_mut().zip(features(&view, &proposal)).zip(features(&view, x)) {
                *drift += weight * before * acceptance * (g - h);
            }
        });
        for ((sum, square), drift) in sums.iter_mut().zip(&mut squares).zip(drifts) {
            *sum += drift;
            *square += drift * drift;
        }
    }
    let z = |(sum, square): (&f64, &f64)| if *square > 0.0 { (sum / square.sqrt()).abs() } else { 0.0 };
    (sums.iter().zip(&squares).map(z).fold(0.0, f64::max), accepted / proposed)
}

const PERTURBATIONS: [&str; 4] = ["lens", "caustic", "multi-chain", "pivot"];

#[test]
fn each_perturbation_keeps_the_distribution() {
    for name in PERTURBATIONS {
        let (z, acceptance) = drift(name, |_, _| 1.0);
        assert!(z < 4.0, "{name}: z = {z}");
        assert!(acceptance > 0.2, "{name}: acceptance {acceptance}");
    }
}

/// Under a sky, and with the control that a ray moved aside forgets the cosine at what it meets.
#[test]
fn each_perturbation_keeps_the_distribution_under_a_sky() {
    let scene = &scene(true);
    for name in PERTURBATIONS {
        let (z, acceptance) = drift_in(scene, 200_000, name, |_, _| 1.0);
        assert!(z < 4.0, "{name}: z = {z}");
        assert!(acceptance > 0.1, "{name}: acceptance {acceptance}");
    }
    let cosine = |_: &View, path: &LightPath| {
        let moved = path.vertices[1..path.edges() - 1].iter().all(|x| x.vertex.delta);
        if moved { f64::from(path.vertices[0].cosines[1]) } else { 1.0 }
    };
    let (z, _) = drift_in(scene, 600_000, "caustic", cosine);
    assert!(z > 5.0, "z = {z} without the cosine");
}

/// Where events of narrow lobes are followed; the controls forget what their slopes are per solid angle.
#[test]
fn each_perturbation_keeps_the_distribution_on_narrow_gloss() {
    let scene = &narrow_scene();
    let slopes = |view: &View, path: &LightPath| -> f64 {
        let per_solid_angle = |i: usize| {
            let (lobe, _) = microfacet(view, path, i)?;
            let x = &path.vertices[i];
            Some(lobe.slopes_per_solid_angle(x.vertex.shading_normal, x.to_eye, -path.vertices[i - 1].to_eye))
        };
        (1..path.edges()).filter_map(per_solid_angle).product()
    };
    for name in PERTURBATIONS {
        let (z, acceptance) = drift_in(scene, 400_000, name, |_, _| 1.0);
        assert!(z < 4.0, "{name}: z = {z}");
        assert!(acceptance > 0.1, "{name}: acceptance {acceptance}");
        let (z, _) = drift_in(scene, 400_000, name, slopes);
        assert!(z > 5.0, "{name}: z = {z} without the slopes' density");
    }
}

#[test]
fn a_forgotten_cosine_is_found() {
    for name in PERTURBATIONS {
        let cosine = |_: &View, path: &LightPath| {
            let x = &path.vertices[path.edges() - 1];
            let before = if name == "caustic" { path.vertices[path.edges() - 2].to_eye } else { x.to_eye };
            f64::from(x.vertex.geometric_normal.dot(before).abs())
        };
        let (z, _) = drift(name, cosine);
        assert!(z > 6.0, "{name}: z = {z}");
    }
}

#[test]
fn a_forgotten_event_probability_is_found() {
    for name in ["caustic", "multi-chain", "pivot"] {
        let (z, _) = drift(name, events);
        assert!(z > 6.0, "{name}: z = {z}");
    }
}

#[test]
fn a_forgotten_distance_is_found() {
    for name in ["caustic", "multi-chain", "pivot"] {
        let distance = |_: &View, path: &LightPath| {
            let specular = (1..path.edges()).rfind(|&i| path.vertices[i].vertex.delta);
            // Without one, the two vertices next to the camera.
            f64::from(path.vertices[specular.unwrap_or(path.edges() - 2)].inverse_square)
        };
        let (z, _) = drift(name, distance);
        assert!(z > 6.0, "{name}: z = {z}");
    }
}

/// All that a proposal keeps of the old path or sets is as in the whole path computed anew.
#[test]
fn proposals_are_complete() {
    let scene = scene(false);
    let camera = scene.camera(&pose(), [64, 64]);
    let view = View { scene: &scene, camera: &camera };
    let strata = LightStrata::new(scene.lights(), Stratification::None);
    let within = &LightStratum::all(&strata, view, MOST_EDGES)[0];
    let region = LightRegion::whole(scene.lights());
    let sampler = Bidirectional { view, region: &region, max_edges: MOST_EDGES };
    let (mut proposal, mut checked) = (LightPath::default(), [0; 5]);
    for sample in 0..4000 {
        let mut rng = generator(8, Purpose::Chain, 0, 0, sample);
        sampler.sample_paths(&mut generator(8, Purpose::Sample, 0, 0, sample), &mut |x, _| {
            for (mutation, checked) in PathMutation::all(view).iter().zip(&mut checked) {
                let applies = Mutation::<LightPath, LightStratum>::suitability(mutation, x) > 0.0;
                if !applies || mutation.propose(x, &mut proposal, within, &mut rng).is_none() {
                    continue;
                }
                let mut anew = proposal.clone();
                let last = anew.edges();
                set_edges_anew(&mut anew, &scene);
                anew.update(&view, 0..=last).expect("it contributes");
                let close = |a: f64, b: f64| (a - b).abs() <= 1e-4 * a.abs().max(b.abs());
                let same = (1..last).all(|i| {
                    let [a, b] = [&anew.vertices[i], &proposal.vertices[i]];
                    close(a.forward, b.forward) && close(a.reverse, b.reverse)
                });
                assert!(same && close(anew.contribution.x, proposal.contribution.x), "{anew:?}\n{proposal:?}");
                *checked += 1;
            }
        });
    }
    assert!(checked.iter().all(|&n| n > 100), "{checked:?}");
}

#[test]
fn perturbations_are_those_asked_for_and_of_use() {
    let (specular, diffuse) = (room(mirror(), true), room(lambert(Rgb::ONE), true));
    let names = |perturbations, world: &World| {
        let name = |m: &PathMutation| Mutation::<LightPath, LightStratum>::name(m);
        PathMutation::with(perturbations, world.view()).iter().map(name).collect::<Vec<_>>()
    };
    let (none, all) = (Perturbations::NONE, Perturbations::ALL);
    assert_eq!(names(none, &specular), ["bidirectional"]);
    assert_eq!(names(Perturbations { lens: true, ..none }, &specular), ["bidirectional", "lens"]);
    assert_eq!(names(Perturbations { caustic: true, ..none }, &specular), ["bidirectional", "caustic"]);
    assert_eq!(names(Perturbations { caustic: true, ..none }, &diffuse), ["bidirectional"]);
    assert_eq!(names(all, &specular), ["bidirectional", "lens", "multi-chain", "pivot", "caustic"]);
    assert_eq!(names(all, &diffuse), ["bidirectional", "lens", "multi-chain", "pivot"]);
}
