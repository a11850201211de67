//! Adaptive strata, classes, variants and importances of whole renders: unbiased, worth it, and the same on any threads.

use std::ops::ControlFlow;
use std::path::Path;

use mlt_core::transport::image::{Target, luminance_and_error};
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::methods::metropolis::{Adaptation, Perturbations, Variant, Weights};
use mlt_core::transport::paths::Classes;
use mlt_core::transport::render::{Counts, Method, Renderer, Settings};
use mlt_core::transport::scene::{Camera, Scene, View};

const ADAPTIVE: Adaptation = Adaptation { weights: Weights::Adaptive, pilot_rounds: 4 };
const BY_POWER: Adaptation = Adaptation { weights: Weights::Power, pilot_rounds: 4 };

struct Stage {
    scene: Scene,
    camera: Camera,
}

impl Stage {
    fn new(name: &str, size: [u32; 2]) -> Self {
        Self::changed(name, size, |_| ())
    }

    fn changed(name: &str, size: [u32; 2], change: impl Fn(&mut f64)) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}/{name}.gltf"));
        let loaded = mlt_scene::builtin(name).unwrap_or_else(|| mlt_scene::load(&path));
        let mut description = loaded.expect("a scene").description;
        description.meshes.iter_mut().flat_map(|m| &mut m.positions).for_each(|p| change(&mut p.y));
        let pose = description.cameras[0].clone();
        let scene = Scene::new(description).expect("usable");
        let camera = scene.camera(&pose, size);
        Self { scene, camera }
    }

    fn render(&self, settings: &Settings, rounds: u64) -> (Vec<f64>, Counts) {
        let renderer = Renderer::new(View { scene: &self.scene, camera: &self.camera }, settings.clone());
        let mut sums = renderer.sums();
        renderer.render(0..rounds, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let (film, counts) = sums.into_parts();
        ((0..film.sites() as usize).map(|i| luminance_and_error(&film, i).0).collect(), counts)
    }

    /// Means of 4×4 blocks of pixels, and of the image.
    fn blocks(&self, image: &[f64]) -> Vec<f64> {
        let [w, h] = self.camera.size().map(|n| n as usize);
        let block = |x: usize, y: usize| (0..16).map(|i| image[(y + i / 4) * w + x + i % 4]).sum::<f64>() / 16.0;
        let mut blocks: Vec<_> =
            (0..h).step_by(4).flat_map(|y| (0..w).step_by(4).map(move |x| (x, y))).map(|(x, y)| block(x, y)).collect();
        blocks.push(image.iter().sum::<f64>() / image.len() as f64);
        blocks
    }

    /// Mean and squared standard error of each block over independent seeds.
    fn replicas(&self, settings: &Settings, rounds: u64, seeds: u64) -> Vec<(f64, f64)> {
        let of_seed = |seed| self.blocks(&self.render(&settings.clone().with(|s| s.seed = seed), rounds).0);
        let runs: Vec<_> = (0..seeds).map(of_seed).collect();
        let n = seeds as f64;
        let moments = |i: usize| {
            let mean = runs.iter().map(|r| r[i]).sum::<f64>() / n;
            (mean, runs.iter().map(|r| (r[i] - mean).powi(2)).sum::<f64>() / (n - 1.0) / n)
        };
        (0..runs[0].len()).map(moments).collect()
    }
}

/// The largest of Welch's z over the blocks, with the second estimate scaled.
fn worst_z(a: &[(f64, f64)], b: &[(f64, f64)], scale: f64) -> f64 {
    let z = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 - scale * b.0).abs() / (a.1 + scale * scale * b.1).sqrt();
    a.iter().zip(b).map(z).fold(0.0, f64::max)
}

fn agrees(stage: &Stage, change: impl FnOnce(&mut Settings)) {
    let settings = &Settings::new(Method::Metropolis, 64.0).with(|s| s.max_edges = Some(5)).with(change);
    let independent = Settings::new(Method::Bidirectional, 64.0).with(|s| s.max_edges = settings.max_edges);
    let expected = stage.replicas(&independent, 1, 24);
    let seen = stage.replicas(settings, 2, 48);
    let z = worst_z(&seen, &expected, 1.0);
    assert!(z < 4.5, "{settings:?}: z = {z}");
    let control = worst_z(&seen, &expected, 1.05);
    assert!(control > 4.5, "{settings:?}: five per cent too bright gives only z = {control}");
}

#[test]
fn adaptive_weights_are_unbiased() {
    let stage = Stage::new("ring", [16, 16]);
    agrees(&stage, |s| (s.stratification, s.adaptation) = (Stratification::Count(12), ADAPTIVE));
}

#[test]
fn adaptive_weights_are_unbiased_in_primary_sample_space() {
    let stage = Stage::new("ring", [16, 16]);
    for method in [Method::PrimaryBidirectional, Method::Multiplexed] {
        agrees(&stage, |s| {
            (s.method, s.stratification, s.adaptation) = (method, Stratification::Count(12), ADAPTIVE);
        });
    }
}

#[test]
fn automatic_strata_are_unbiased() {
    let stage = Stage::new("ring", [16, 16]);
    agrees(&stage, |s| (s.stratification, s.adaptation) = (Stratification::Auto, ADAPTIVE));
}

#[test]
fn classes_of_lengths_and_tiles_are_unbiased() {
    let stage = Stage::new("ring", [16, 16]);
    let classes = Classes { lengths: true, tiles: [2, 2] };
    agrees(&stage, |s| {
        (s.stratification, s.classes, s.adaptation) = (Stratification::Count(2), classes, ADAPTIVE);
    });
}

#[test]
fn the_variant_that_restricts_the_mutation_alone_is_unbiased() {
    let stage = Stage::new("ring", [16, 16]);
    agrees(&stage, |s| (s.stratification, s.variant) = (Stratification::Grid(2, 2), Variant::MutationOnly));
}

#[test]
fn the_bidirectional_mutation_alone_reaches_everything() {
    let stage = Stage::new("ring", [16, 16]);
    agrees(&stage, |s| (s.stratification, s.perturbations) = (Stratification::Grid(2, 2), Perturbations::NONE));
}

#[test]
fn the_relative_importance_is_unbiased() {
    let stage = Stage::new("ring", [16, 16]);
    agrees(&stage, |s| (s.stratification, s.target) = (Stratification::Count(4), Target::Relative));
}

fn rel_mse(image: &[f64], reference: &[f64]) -> f64 {
    let error = |(b, a): (&f64, &f64)| (a - b).powi(2) / (a * a + 1e-2);
    image.iter().zip(reference).map(error).sum::<f64>() / image.len() as f64
}

#[test]
fn adaptive_weights_pay_where_the_brightest_light_is_hidden() {
    let stage = Stage::new("hidden-light", [32, 24]);
    let settings = |method, adaptation| {
        let cut = Stratification::Count(2);
        Settings::new(method, 16.0).with(|s| (s.stratification, s.adaptation) = (cut, adaptation))
    };
    let long = settings(Method::Metropolis, ADAPTIVE).with(|s| (s.seed, s.per_pixel) = (99, 512.0));
    let reference = stage.render(&long, 8).0;
    let error = |method, adaptation| -> f64 {
        let of_seed = |seed| settings(method, adaptation).with(|s| s.seed = seed);
        (0..8).map(|seed| rel_mse(&stage.render(&of_seed(seed), 4).0, &reference)).sum::<f64>() / 8.0
    };
    for method in [Method::Metropolis, Method::PrimaryBidirectional, Method::Multiplexed] {
        let (power, adaptive) = (error(method, BY_POWER), error(method, ADAPTIVE));
        assert!(adaptive < 0.5 * power, "{method:?}: {adaptive} against {power}");
    }
}

#[test]
fn a_dark_stratum_costs_almost_nothing() {
    // The door down to the floor: the flood light is behind a wall without a gap.
    let stage = Stage::changed("hidden-light", [32, 24], |y| *y = if (*y - 0.04).abs() < 1e-6 { -0.01 } else { *y });
    let cut = Stratification::Count(2);
    let settings = Settings::new(Method::Metropolis, 64.0).with(|s| (s.stratification, s.adaptation) = (cut, ADAPTIVE));
    let counts = stage.render(&settings, 4).1;
    let (dark, lit): (Vec<_>, Vec<_>) = counts.chains().strata.iter().partition(|s| s.b() == 0.0);
    let work = |s: &mlt_core::engine::StratumStats| s.chain_work + s.sample_work;
    assert_eq!((dark.len(), lit.len(), dark[0].steps(), dark[0].dark_rounds), (1, 1, 0, 4));
    assert!(dark[0].samples > 0, "it is still looked at");
    assert!(work(dark[0]) * 50 < work(lit[0]), "{} against {}", work(dark[0]), work(lit[0]));
}

#[test]
fn pilots_give_the_same_bits_on_any_number_of_threads() {
    let stage = Stage::new("ring", [24, 16]);
    let settings = Settings::new(Method::Metropolis, 64.0).with(|s| {
        s.classes = Classes { lengths: true, tiles: [2, 1] };
        (s.stratification, s.adaptation, s.target) = (Stratification::Auto, ADAPTIVE, Target::Relative);
    });
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| stage.render(&settings, 2))
    };
    let first = on(1);
    assert!(first.0.iter().any(|&x| x > 0.0) && [2, 3, 8].into_iter().all(|threads| on(threads) == first));
}
