//! Metropolis, bidirectional and path tracing agree with each other and with an independent renderer's reference.

use crate::support::*;
use exr::prelude::*;
use glam::{DVec3, Vec2};
use mlt_core::engine::Path;
use mlt_core::transport::lights::LightRegion;
use mlt_core::transport::lights::Stratification::{Grid, None as Whole};
use mlt_core::transport::methods::{AllPaths, Bidirectional, ImageSampler, Independent, MOST_EDGES, OwenSobol};
use mlt_core::transport::paths::{Kind, LightEnd, PathEnd};
use mlt_core::transport::render::{Method, film_unit};
use mlt_core::transport::scene::View;
use std::ops::Range;

/// A pixel is a block of 32 × 32 of the reference's.
const SIZE: [u32; 2] = [8, 8];
const ROUNDS: Range<u64> = 0..16;

/// The reference's means over blocks, with the variance that its own error, measured from its two halves, gives them.
fn reference(name: &str) -> Known {
    let path = format!("{}/../../tests/data/{name}.reference.exr", env!("CARGO_MANIFEST_DIR"));
    let image = read_first_rgba_layer_from_file(
        &path,
        |size, _| vec![vec![[0f32; 3]; size.width()]; size.height()],
        |image, at, (r, g, b, _): (f32, f32, f32, f32)| image[at.y()][at.x()] = [r, g, b],
    )
    .unwrap();
    let mut attributes = image.attributes.other.iter().chain(&image.layer_data.attributes.other);
    let Some((_, AttributeValue::Text(error))) = attributes.find(|(name, _)| **name == *"peer_self_relMSE") else {
        panic!("{path} does not say its error");
    };
    let relative_error: f64 = error.to_string().parse().unwrap();
    let pixels = image.layer_data.channel_data.pixels;
    let block = pixels.len() / SIZE[1] as usize;
    let mut known = Known { values: Vec::new(), variances: Vec::new() };
    for (row, column, channel) in (0..SIZE[1] as usize)
        .flat_map(|row| (0..SIZE[0] as usize).map(move |column| (row, column)))
        .flat_map(|(row, column)| (0..3).map(move |channel| (row, column, channel)))
    {
        let inside =
            (0..block * block).map(|i| f64::from(pixels[row * block + i / block][column * block + i % block][channel]));
        let n = (block * block) as f64;
        known.values.push(inside.clone().sum::<f64>() / n);
        // relMSE = (a − b)² / (a² + 10⁻²), pixels independent.
        known.variances.push(inside.map(|a| relative_error * (a * a + 1e-2)).sum::<f64>() / (n * n));
    }
    known
}

/// Bidirectional path tracing that takes direct light for two per cent brighter than it is.
struct BrightDirectLight<'a>(Bidirectional<'a>);

impl ImageSampler for BrightDirectLight<'_> {
    fn size(&self) -> [u32; 2] {
        self.0.size()
    }

    fn sample(&self, image: Vec2, rng: &mut OwenSobol, visit: &mut impl FnMut(Option<u32>, DVec3, PathEnd)) {
        let pixels = f64::from(self.0.view.camera.pixels());
        self.0.sample_through(image, 1.0, rng, &mut |path, density| {
            let error = if path.edges() == 2 { 1.02 } else { 1.0 };
            let end = PathEnd { kind: Kind::of(path), light: LightEnd::Drawn(path.light()), scale: 1.0 };
            for splat in path.splats() {
                visit(Some(splat.site), DVec3::from_array(splat.value) * (density * error / pixels), end);
            }
        });
    }
}

/// Budgets a pixel and round, of samples and of mutations.
fn methods_agree(name: &str, samples: f64, mutations: f64) {
    let world = World::builtin(name);
    let truth = reference(name);
    let path = replicas(&world, SIZE, &settings(Method::Path, Whole, samples), ROUNDS);
    let bidirectional = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, samples), ROUNDS);
    let whole = metropolis(&world, SIZE, Whole, mutations, ROUNDS);
    let cut = metropolis(&world, SIZE, Grid(2, 1), mutations, ROUNDS);
    let estimates = [("path tracing", path), ("bidirectional", bidirectional), ("one stratum", whole), ("strata", cut)];
    for (i, (a, x)) in estimates.iter().enumerate() {
        println!("{name}, {a}: ± {:.1e}", x.relative_error());
        assert_same(x.p_value_of(&truth), &format!("{name}, {a} and the reference"));
        for (b, y) in &estimates[..i] {
            assert_same(x.p_value(y), &format!("{name}, {a} and {b}"));
        }
    }
    errors_are_seen(name, &world, &truth, &estimates.map(|(_, x)| x), mutations);
}

fn errors_are_seen(name: &str, world: &World, truth: &Known, estimates: &[Replicas; 4], mutations: f64) {
    let [path, bidirectional, _, cut] = estimates;
    let check = |wrong: &Replicas, what: &str| {
        assert_different(wrong.p_value_of(truth), &format!("{name}, {what} and the reference"));
        assert_different(wrong.p_value(path), &format!("{name}, {what} and path tracing"));
    };
    let camera = world.camera(SIZE);
    let region = LightRegion::whole(world.scene.lights());
    let view = View { scene: &world.scene, camera: &camera };
    let sampler = BrightDirectLight(Bidirectional { view, region: &region, max_edges: MOST_EDGES });
    let estimator = Independent { sampler: &sampler, selection: AllPaths, samples_per_pixel: 256.0, seed: 5 };
    let unit = film_unit(view);
    check(&replicas_of(&estimator, camera.pixels(), unit, ROUNDS), "direct light two per cent too bright");
    let lights = &world.scene.lights().lights;
    let brightest = (0..lights.len()).max_by(|&a, &b| lights[a].power().total_cmp(&lights[b].power())).unwrap();
    // Every light is cut in two.
    let part = metropolis_in(world, SIZE, (Grid(2, 1), |j| j / 2 == brightest), mutations, ROUNDS);
    check(&cut.plus(0.02, &part), "b of the brightest light's strata two per cent too large");
    assert_different(bidirectional.plus(0.01, bidirectional).p_value(path), "one per cent too bright");
}

#[test]
fn methods_agree_on_cornell() {
    methods_agree("cornell", 2048.0, 8000.0);
}

#[test]
fn methods_agree_on_ring() {
    methods_agree("ring", 512.0, 8000.0);
}

#[test]
fn methods_agree_on_suzanne() {
    methods_agree("suzanne", 512.0, 8000.0);
}
