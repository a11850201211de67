//! The method `auto`: whatever its pilot decides, the image is the same.

mod proof_support;

use mlt_core::engine::{Film, Outcome, Pixel};
use mlt_core::transport::{
    auto::{Sampler, Summary},
    path::View,
    render::{Counts, Method, Renderer, Settings},
    strata::Stratification::{self, Count, None as Whole},
};
use proof_support::*;
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

const SIZE: [u32; 2] = [12, 12];

fn scene(name: &str) -> World {
    World::new(
        mlt_scene::open(format!("{}/../../scenes/{name}/{name}.gltf", env!("CARGO_MANIFEST_DIR"))).unwrap().description,
    )
}

fn decision(world: &World, settings: &Settings) -> Summary {
    let camera = world.camera(SIZE);
    let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, settings.clone());
    renderer.decision().expect("decided").clone()
}

fn auto(cut: Stratification, per_pixel: f64) -> Settings {
    settings(Method::Auto, cut, per_pixel)
}

/// Glass over a diffuse room: paths for direct light are easy, caustics are not.
#[test]
fn a_mixture_agrees_with_bidirectional_path_tracing() {
    let world = scene("caustic");
    let truth = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, 4096.0), 0..16);
    for cut in [Whole, Count(3)] {
        let settings = auto(cut, 2048.0);
        let Summary { sampler, chain_share, parts } = decision(&world, &settings);
        assert!(sampler.is_some() && (0.01..0.99).contains(&chain_share), "{sampler:?} {chain_share}");
        assert!(parts.iter().any(|part| part.in_chains && part.chains > 0.0), "{parts:?}");
        let mixture = replicas(&world, SIZE, &settings, 0..16);
        assert_same(mixture.p_value(&truth), "mixture and bidirectional");
        assert_different(mixture.plus(0.02, &mixture).p_value(&truth), "two per cent too bright");
    }
}

/// The pilot sees each seed another way; the mean of very short renders is the image.
#[test]
fn short_renders_have_no_bias_whatever_is_decided() {
    let world = scene("caustic");
    let of_seed = |seed: u64| {
        let settings = Settings { seed, ..auto(Count(2), 2.0) };
        let made_of = decision(&world, &settings);
        (replicas(&world, SIZE, &settings, 0..1).images.remove(0), made_of)
    };
    let (images, decisions): (Vec<_>, Vec<_>) = (0..600).into_par_iter().map(of_seed).unzip();
    let different = |a: &Summary, b: &Summary| {
        a.sampler != b.sampler || a.parts.iter().zip(&b.parts).any(|(a, b)| a.in_chains != b.in_chains)
    };
    assert!(decisions[1..].iter().filter(|d| different(d, &decisions[0])).count() > 30, "the pilot hardly differs");
    let short = Replicas { images };
    let truth = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, 4096.0), 0..16);
    assert_same(short.p_value(&truth), "short renders");
    assert_different(short.plus(0.1, &short).p_value(&truth), "ten per cent too bright");
}

#[test]
fn easy_light_is_left_to_path_tracing() {
    for name in ["cornell", "ring", "suzanne"] {
        let decided = decision(&World::builtin(name), &auto(Whole, 64.0));
        assert_eq!((decided.sampler, decided.chain_share), (Some(Sampler::Path), 0.0), "{name}");
    }
}

#[test]
fn threads_and_split_rounds_change_no_bit() {
    let world = scene("caustic");
    let settings = auto(Count(2), 16.0);
    let render = |threads: usize, rounds: &[Range<u64>]| {
        let camera = world.camera(SIZE);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, settings.clone());
            let (mut film, mut counts) = (renderer.film(), Counts::default());
            for rounds in rounds {
                let go_on = &mut |_, _: &Film<3>| ControlFlow::Continue(());
                assert_eq!(renderer.render(rounds.clone(), &mut film, &mut counts, go_on), Outcome::Complete);
            }
            assert!(counts.samples > 0 && counts.steps() > 0);
            let of = |p: Pixel| [p.mean.to_bits(), p.stderr.to_bits()];
            ((0..film.sites() as usize).flat_map(|i| film.pixel(i)).flat_map(of).collect::<Vec<_>>(), counts)
        })
    };
    let alone = render(1, &[0..5]);
    for threads in [2, 3, 8, 32] {
        assert_eq!(render(threads, &[0..5]), alone, "{threads} threads");
    }
    assert_eq!(render(2, &[0..2, 2..5]), alone, "rounds in two calls");
}
