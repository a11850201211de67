//! The light on the pool's floor: path tracing finds what an integral over one angle says, single connections miss it all.

use std::{f64::consts::PI, path::Path};

use mlt_core::transport::LUMINANCE;
use mlt_core::transport::image::luminance_and_error;
use mlt_core::transport::render::{Method, Renderer, Settings};
use mlt_core::transport::scene::{CameraPose, Lens, Scene, View};
use std::ops::ControlFlow;

const LAMP: f64 = 2.0;
const DEPTH: f64 = 1.0;
const IOR: f64 = 1.33;
/// Opening angle of a camera that sees the floor alone.
const FOV: f64 = 0.2;
const AREA: f64 = 0.01;
/// The lamp's radiance and the floor's reflectance.
const COLOUR: [f64; 3] = [600.0, 560.0, 480.0];
const REFLECTANCE: [f64; 3] = [0.25, 0.35, 0.55];

/// Share of unpolarised light that goes from air into water, or back along the same way.
fn transmitted(sin: f64) -> f64 {
    let (cos, cos_below) = ((1.0 - sin * sin).sqrt(), (1.0 - (sin / IOR).powi(2)).sqrt());
    let parallel = (IOR * cos - cos_below) / (IOR * cos + cos_below);
    let across = (cos - IOR * cos_below) / (cos + IOR * cos_below);
    1.0 - 0.5 * (parallel * parallel + across * across)
}

/// Where light that meets the water at an angle of this sine, `above` over it, comes to at the bottom.
fn reach(sin: f64, above: f64) -> f64 {
    let below = sin / IOR;
    above * sin / (1.0 - sin * sin).sqrt() + DEPTH * below / (1.0 - below * below).sqrt()
}

/// The sine for which [`reach`] is `r`: it grows with the sine.
fn sine(r: f64, above: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0 - 1e-9);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if reach(middle, above) < r { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Irradiance over radiant intensity at the nadir, of the floor at r from the point below a small lamp.
///
/// The flux between sin θ and sin θ + d sin θ, 2π I cosθ T(θ) · sinθ d sinθ / cosθ, falls on the ring 2π r dr.
fn irradiance(r: f64) -> f64 {
    let s = sine(r.max(1e-3), LAMP);
    let step = 1e-5;
    let slope = (reach(s + step, LAMP) - reach(s - step, LAMP)) / (2.0 * step);
    transmitted(s) * s / (r.max(1e-3) * slope)
}

/// Luminance of the floor seen from above: ρ E/π, less what is reflected at the surface, over n² for the spreading cone.
fn floor(r: f64, eye_sine: f64) -> f64 {
    let reflected: f64 = (0..3).map(|c| LUMINANCE[c] * COLOUR[c] * REFLECTANCE[c]).sum();
    reflected * AREA * irradiance(r) / PI * transmitted(eye_sine) / (IOR * IOR)
}

/// Luminance at a height of the image's middle column, `v` from 1 at the top to -1; `None` off the floor.
fn expected(v: f64) -> Option<f64> {
    let (eye, target, half) = ([2.2, 2.4], [-0.5, 0.0], (0.5 * FOV).tan());
    let forward: [f64; 2] = [target[0] - eye[0], target[1] - eye[1]];
    let length = forward[0].hypot(forward[1]);
    let forward = forward.map(|x| x / length);
    let direction: [f64; 2] = [forward[0] - v * half * forward[1], forward[1] + v * half * forward[0]];
    let sin = (direction[1] / direction[0].hypot(direction[1])).abs();
    let (surface, floor_point) = (eye[1] - eye[0] * sin / (1.0 - sin * sin).sqrt(), eye[1] - reach(sin, eye[0]));
    (surface.abs() < 0.98 && floor_point.abs() < 0.98).then(|| floor(floor_point.abs(), sin))
}

/// Mean over a row of pixels of a strip of `rows`.
fn expected_row(row: usize, rows: usize) -> Option<f64> {
    const PARTS: usize = 16;
    let part = |i: usize| expected(1.0 - 2.0 * (row as f64 + (i as f64 + 0.5) / PARTS as f64) / rows as f64);
    let parts: Option<Vec<f64>> = (0..PARTS).map(part).collect();
    parts.map(|parts| parts.iter().sum::<f64>() / PARTS as f64)
}

/// A path from the camera meets the lamp by chance, once in some ten thousand times: no other technique makes these paths.
#[test]
fn path_tracing_finds_the_light_in_the_pool() {
    const ROWS: usize = 3;
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stability/pool/scene.gltf");
    let description = mlt_scene::load(&file).expect("loaded").description;
    let pose = CameraPose { lens: Lens::Pinhole { vertical_fov: FOV as f32 }, ..description.cameras[0].clone() };
    let scene = Scene::new(description).expect("valid");
    let camera = scene.camera(&pose, [1, ROWS as u32]);
    let settings = Settings::new(Method::Path, 65_536.0).with(|s| (s.max_edges, s.seed) = (Some(4), 5));
    let renderer = Renderer::new(View { scene: &scene, camera: &camera }, settings);
    let mut sums = renderer.sums();
    renderer.render(0..16, &mut sums, &mut |_, _| ControlFlow::Continue(()));

    let (mut sum, mut variance, mut truth) = (0.0, 0.0, 0.0);
    for row in 0..ROWS {
        let (mean, error) = luminance_and_error(sums.film(), row);
        let expected = expected_row(row, ROWS).expect("the floor");
        println!("row {row}: {mean:.4} ± {error:.4}, analytic {expected:.4}");
        assert!((mean - expected).abs() < 5.0 * error.max(0.1 * expected), "row {row}");
        (sum, variance, truth) = (sum + mean, variance + error * error, truth + expected);
    }
    let error = variance.sqrt();
    println!("all rows: {sum:.4} ± {error:.4}, analytic {truth:.4}");
    assert!(error < 0.08 * truth, "too noisy to tell");
    assert!((sum - truth).abs() < 3.5 * error);
    assert!((sum - truth / (IOR * IOR)).abs() > 3.5 * error, "without the spreading of the cone it has to fail");
}
