//! The method `auto`: however path space is shared out, the image is the same.

use crate::support::*;
use glam::DVec3;
use mlt_core::engine::{Outcome, Pixel, Share};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Bsdf, Lambert, Mirror};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::image::{luminance_and_error, mean_luminance};
use mlt_core::transport::lights::Stratification::{Count, None as Whole};
use mlt_core::transport::lights::{LightStrata, Stratification};
use mlt_core::transport::methods::MOST_EDGES;
use mlt_core::transport::methods::auto::Plan;
use mlt_core::transport::render::{Method, Renderer, Settings, Sums};
use mlt_core::transport::scene::{SceneDescription, View};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::ops::{ControlFlow, Range};

const SIZE: [u32; 2] = [8, 8];

/// A floor under two square lamps of some side beside a mirror: every kind of path, and none that is rare if lamps are large.
fn mirrored(side: f64) -> World {
    let mut description = SceneDescription::default();
    let lamp = |x: f64| -> Mesh { quad([[x, 2., 0.], [x + side, 2., 0.], [x + side, 2., side], [x, 2., side]]) };
    let grey = || Bsdf::Lambert(Lambert { reflectance: Rgb::splat(0.6) });
    add(&mut description, quad([[-2., 0., 2.], [2., 0., 2.], [2., 0., -2.], [-2., 0., -2.]]), grey(), Rgb::ZERO);
    add(&mut description, quad([[-2., 0., -2.], [-2., 3., -2.], [-2., 3., 2.], [-2., 0., 2.]]), grey(), Rgb::ZERO);
    let mirror = Bsdf::Mirror(Mirror { f0: Rgb::splat(0.9) });
    add(&mut description, quad([[2., 0., -2.], [2., 0., 2.], [2., 3., 2.], [2., 3., -2.]]), mirror, Rgb::ZERO);
    add(&mut description, lamp(-1.5), Bsdf::Black, Rgb::new(3.0, 2.0, 1.0));
    add(&mut description, lamp(0.5), Bsdf::Black, Rgb::new(1.0, 2.0, 3.0));
    description.cameras.push(pose(DVec3::new(-1.0, 1.5, 5.0), DVec3::new(0.3, 0.6, 0.0), 45.0));
    World::new(description)
}

/// Rounds of path tracing with so many branches and edges, and of chains in each part of the lights, where every pixel is expected to show `level`.
fn shared_out(world: &World, cut: Stratification, level: f64, numbers: [usize; 2]) -> Replicas {
    let camera = world.camera(SIZE);
    let view = View { scene: &world.scene, camera: &camera };
    let one = |round| {
        let strata = LightStrata::new(world.scene.lights(), cut);
        // What only chance meets is one more stratum.
        let shares = vec![Share { mutations: 200_000, samples: 50_000 }; strata.regions().len() + 1];
        let plan = Plan::new(strata, (level, 512.0), numbers, shares);
        let renderer = Renderer::with_plan(view, settings(Method::Auto, Whole, 1.0), plan);
        let mut sums = renderer.sums();
        renderer.render(round..round + 1, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let film = sums.film();
        (0..film.sites() as usize).flat_map(|i| film.pixel(i).map(|c| c.mean)).collect()
    };
    Replicas { images: (0..16).into_par_iter().map(one).collect() }
}

#[test]
fn every_way_to_share_paths_out_gives_the_same_image() {
    let world = mirrored(1.0);
    let truth = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, 1024.0), 0..16);
    for (cut, level, numbers) in [
        (Whole, 0.001, [1, MOST_EDGES]),
        (Whole, 0.05, [4, MOST_EDGES]),
        (Count(2), 1.0, [2, MOST_EDGES]),
        (Whole, 0.1, [1, 1]),
        (Count(2), 0.1, [1, 3]),
    ] {
        let shared = shared_out(&world, cut, level, numbers);
        assert_same(shared.p_value(&truth), &format!("{cut:?}, level {level}, {numbers:?}"));
        assert_different(shared.plus(0.02, &shared).p_value(&truth), "two per cent too bright");
    }
}

/// Means of the image over 160 seeds, each with the standard error of the mean and the root of the sum of the pixels' squared errors.
fn means_of_mixtures(world: &World) -> Vec<(f64, f64, f64)> {
    let camera = world.camera(SIZE);
    let view = View { scene: &world.scene, camera: &camera };
    let of_seed = |seed| {
        let strata = LightStrata::new(world.scene.lights(), Whole);
        // Few samples for b, so that the error that pixels have in common is not small.
        let shares = vec![Share { mutations: 4000, samples: 32 }; 2];
        let plan = Plan::new(strata, (0.001, 256.0), [1, MOST_EDGES], shares);
        let settings = settings(Method::Auto, Whole, 1.0).with(|s| s.seed = seed);
        let renderer = Renderer::with_plan(view, settings, plan);
        let mut sums = renderer.sums();
        renderer.render(0..16, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let film = sums.film();
        let own: f64 = (0..film.sites() as usize).map(|i| luminance_and_error(film, i).1.powi(2)).sum();
        let Pixel { mean, stderr } = mean_luminance(film);
        (mean, stderr, own.sqrt() / f64::from(film.sites()))
    };
    (0..160).into_par_iter().map(of_seed).collect()
}

/// Σ (b − b̄)² over the mean squared error that was told is χ² with one degree of freedom less than there are seeds.
#[test]
fn the_mean_of_a_mixture_scatters_as_far_as_it_says() {
    let found = means_of_mixtures(&mirrored(1.0));
    let n = found.len() as f64;
    let mean = found.iter().map(|f| f.0).sum::<f64>() / n;
    let scatter: f64 = found.iter().map(|f| (f.0 - mean).powi(2)).sum();
    let p = |told: &dyn Fn(&(f64, f64, f64)) -> f64| {
        let squares = found.iter().map(|f| told(f).powi(2)).sum::<f64>() / n;
        let below = ChiSquared::new(n - 1.0).expect("a law").cdf(scatter / squares);
        2.0 * below.min(1.0 - below)
    };
    assert!(p(&|f| f.1) > 1e-3, "p = {:e}", p(&|f| f.1));
    // The negative control: as if pixels had no error in common.
    assert!(p(&|f| f.2) < 1e-6, "p = {:e}", p(&|f| f.2));
}

fn auto(cut: Stratification, per_pixel: f64) -> Settings {
    settings(Method::Auto, cut, per_pixel)
}

/// The pilot may decide another way at each seed; the mean of very short renders is the image all the same.
#[test]
fn short_renders_have_no_bias_whatever_is_decided() {
    let world = mirrored(0.8);
    let camera = world.camera(SIZE);
    let of_seed = |seed: u64| {
        let settings = auto(Count(2), 16.0).with(|s| s.seed = seed);
        let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, settings.clone());
        let decided = *renderer.decision().expect("decided");
        (replicas(&world, SIZE, &settings, 0..1).images.remove(0), decided)
    };
    let (images, decisions): (Vec<_>, Vec<_>) = (0..400).into_par_iter().map(of_seed).unzip();
    let mixtures = decisions.iter().filter(|d| (0.01..0.99).contains(&d.chain_share)).count();
    println!("{mixtures} of {} are mixtures", decisions.len());
    assert!((30..370).contains(&mixtures), "{mixtures} of {}", decisions.len());
    // With a sample a pixel and round, the edge of a lamp is met in few of the renders.
    let short = Replicas { images }.in_blocks(SIZE, 4);
    let truth = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, 2048.0), 0..16).in_blocks(SIZE, 4);
    assert_same(short.p_value(&truth), "short renders");
    assert_different(short.plus(0.05, &short).p_value(&truth), "five per cent too bright");
}

#[test]
fn easy_light_is_left_to_path_tracing() {
    for name in ["ring", "suzanne"] {
        let world = World::builtin(name);
        let camera = world.camera([32, 32]);
        let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, auto(Whole, 64.0));
        let decided = renderer.decision().expect("decided");
        assert!(decided.chain_share == 0.0 && decided.hard_light < 0.05, "{name}: {decided:?}");
    }
}

#[test]
fn threads_and_split_rounds_change_no_bit() {
    let file = format!("{}/../../scenes/hidden-light/hidden-light.gltf", env!("CARGO_MANIFEST_DIR"));
    let world = World::new(mlt_scene::open(file).unwrap().description);
    let settings = auto(Whole, 32.0);
    let render = |threads: usize, rounds: &[Range<u64>]| {
        let camera = world.camera([24, 24]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, settings.clone());
            let mut sums = renderer.sums();
            for rounds in rounds {
                let go_on = &mut |_, _: &Sums| ControlFlow::Continue(());
                assert_eq!(renderer.render(rounds.clone(), &mut sums, go_on), Outcome::Complete);
            }
            let (film, counts) = sums.into_parts();
            assert!(counts.samples() > 0 && counts.steps() > 0);
            let of = |p: Pixel| [p.mean.to_bits(), p.stderr.to_bits()];
            ((0..film.sites() as usize).flat_map(|i| film.pixel(i)).flat_map(of).collect::<Vec<_>>(), counts)
        })
    };
    let whole = std::slice::from_ref(&(0..5));
    let alone = render(1, whole);
    for threads in [2, 3, 8, 32] {
        assert_eq!(render(threads, whole), alone, "{threads} threads");
    }
    assert_eq!(render(2, &[0..2, 2..5]), alone, "rounds in two calls");
}
