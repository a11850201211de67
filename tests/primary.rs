//! Primary sample space on scenes: it agrees with bidirectional path tracing, however short its rounds and on any number
//! of threads, and allocates nothing once it runs.

use mlt_core::{
    engine::{Chain, Film, Importance, Mixture, Mutation, Purpose, Stratum, generator},
    primary::{PrimaryImportance, PrimaryMutation, PrimaryPath, PrimaryStratum, Tracer},
    transport::{
        camera::Camera,
        path::{Luminance, View},
        primary::{AllConnections, Multiplexed, Part, Techniques},
        render::{Counts, Method, Renderer, Settings, luminance_and_error},
        scene::Scene,
        strata::{LightStrata, Stratification},
    },
};
use std::ops::ControlFlow;

const SIDE: u32 = 16;
/// Pixels in a row of a block; blocks in a row of the image.
const BLOCK: usize = 4;
const BLOCKS: usize = SIDE as usize / BLOCK;
/// Two-sided p = 0.001 over all blocks of one comparison, normal law: |t| for p = 0.001/16.
const LARGEST_T: f64 = 4.3;

fn load(name: &str) -> (Scene, Camera) {
    let description = mlt_scene::open(name).expect("built in").description;
    let pose = description.cameras[0].clone();
    let scene = Scene::new(description).expect("valid");
    let camera = scene.camera(&pose, [SIDE; 2]);
    (scene, camera)
}

fn settings(method: Method, stratification: Stratification, per_pixel: f64, seed: u64) -> Settings {
    Settings { method, stratification, max_edges: Some(6), seed, per_pixel, ..Settings::default() }
}

fn render(view: View, settings: Settings) -> (Film<3>, Counts) {
    let renderer = Renderer::new(view, settings);
    let (mut film, mut counts) = (renderer.film(), Counts::default());
    renderer.render(0..1, &mut film, &mut counts, &mut |_, _| ControlFlow::Continue(()));
    (film, counts)
}

/// Luminance of each block of the image.
fn blocks(film: &Film<3>) -> [f64; BLOCKS * BLOCKS] {
    let mut blocks = [0.0; BLOCKS * BLOCKS];
    for pixel in 0..film.sites() as usize {
        let (x, y) = (pixel % SIDE as usize / BLOCK, pixel / SIDE as usize / BLOCK);
        blocks[y * BLOCKS + x] += luminance_and_error(film, pixel).0 / (BLOCK * BLOCK) as f64;
    }
    blocks
}

/// Mean of every block over renders with the seeds 0 … n − 1, and the square of its standard error.
fn replicas(view: View, n: u64, with_seed: impl Fn(u64) -> Settings) -> Vec<(f64, f64)> {
    let renders: Vec<_> = (0..n).map(|seed| blocks(&render(view, with_seed(seed)).0)).collect();
    let n = n as f64;
    let of = |block: usize| {
        let mean = renders.iter().map(|r| r[block]).sum::<f64>() / n;
        let variance = renders.iter().map(|r| (r[block] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    (0..BLOCKS * BLOCKS).map(of).collect()
}

/// Largest |t| of Welch's test over the blocks.
fn largest_t(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a.0 - b.0).abs() / (a.1 + b.1).sqrt()).fold(0.0, f64::max)
}

fn agrees(name: &str) {
    let (scene, camera) = load(name);
    let view = View { scene: &scene, camera: &camera };
    let bdpt = |seed| settings(Method::Bidirectional, Stratification::None, 32.0, 1000 + seed);
    let reference = replicas(view, 60, bdpt);
    for stratification in [Stratification::None, Stratification::Grid(2, 2)] {
        for (method, per_pixel) in [(Method::PrimaryBidirectional, 24.0), (Method::Multiplexed, 128.0)] {
            let ours = replicas(view, 60, |seed| settings(method, stratification, per_pixel, seed));
            let t = largest_t(&reference, &ours);
            assert!(t < LARGEST_T, "{name}, {method:?}, {stratification:?}: t = {t}");
        }
    }
    let cut =
        |seed| Settings { max_edges: Some(2), ..settings(Method::Multiplexed, Stratification::None, 128.0, seed) };
    let t = largest_t(&reference, &replicas(view, 60, cut));
    assert!(t > LARGEST_T, "{name}: the control, direct light only, goes unnoticed: t = {t}");
}

#[test]
fn cornell_agrees_with_bidirectional_path_tracing() {
    agrees("cornell");
}

#[test]
fn ring_agrees_with_bidirectional_path_tracing() {
    agrees("ring");
}

#[test]
fn suzanne_agrees_with_bidirectional_path_tracing() {
    agrees("suzanne");
}

#[test]
fn two_thousand_very_short_renders_have_the_right_mean() {
    let (scene, camera) = load("cornell");
    let view = View { scene: &scene, camera: &camera };
    let reference = replicas(view, 60, |seed| settings(Method::Bidirectional, Stratification::None, 64.0, seed));
    for method in [Method::PrimaryBidirectional, Method::Multiplexed] {
        let short = replicas(view, 2000, |seed| settings(method, Stratification::None, 0.125, seed));
        let t = largest_t(&reference, &short);
        assert!(t < LARGEST_T, "{method:?}: t = {t}");
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    let (scene, camera) = load("cornell");
    let view = View { scene: &scene, camera: &camera };
    for method in [Method::PrimaryBidirectional, Method::Multiplexed] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                let (film, counts) = render(view, settings(method, Stratification::Grid(2, 2), 200.0, 3));
                let bits = |i: usize| film.pixel(i).map(|channel| channel.mean.to_bits());
                ((0..film.sites() as usize).map(bits).collect::<Vec<_>>(), counts)
            })
        };
        let one = on(1);
        assert!(one.0.iter().flatten().any(|&bits| bits != 0));
        for threads in [2, 3, 8] {
            assert_eq!(on(threads), one, "{method:?} on {threads} threads");
        }
    }
}

/// Allocations of 20,000 steps, after as many.
fn allocations<T: Tracer<N>, const N: usize>(stratum: &PrimaryStratum<T>) -> u64
where
    PrimaryMutation: Mutation<PrimaryPath<T::Output, N>, PrimaryStratum<T>>,
{
    struct Nothing;
    impl<S> mlt_core::engine::Sink<S> for Nothing {
        fn deposit(&mut self, _: S, _: f64) {}
    }
    let mixture = Mixture::new(PrimaryMutation::both(0.3));
    let mut rng = generator(7, Purpose::Chain, 0, 0, 0);
    let mut start = None;
    while start.is_none() {
        stratum.sample(&mut rng, &mut |path: &PrimaryPath<T::Output, N>, _| {
            start = (PrimaryImportance.eval(path) > 0.0).then(|| path.clone());
        });
    }
    let start = start.expect("found");
    let mut chain = Chain::new(&mixture, &PrimaryImportance, stratum, start).expect("bright");
    (0..20_000).for_each(|_| chain.step(&mut Nothing, 1.0, &mut rng));
    let counted = allocation_counter::measure(|| (0..20_000).for_each(|_| chain.step(&mut Nothing, 1.0, &mut rng)));
    counted.count_total
}

#[test]
fn a_warm_chain_allocates_nothing() {
    let (scene, camera) = load("cornell");
    let view = View { scene: &scene, camera: &camera };
    let strata = LightStrata::new(scene.lights(), Stratification::None);
    let part = Part { view, strata: &strata, index: 0, max_edges: 6, importance: &Luminance };
    let techniques = Techniques::new(part.max_edges);
    assert_eq!(allocations(&part.all(|part| Multiplexed { part, techniques: &techniques })[0]), 0);
    assert_eq!(allocations(&part.all(|part| AllConnections { part })[0]), 0);
    let counted = allocation_counter::measure(|| drop(std::hint::black_box(vec![0u8; 100])));
    assert_eq!(counted.count_total, 1, "the control goes unnoticed");
}
