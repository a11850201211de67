//! Whole methods: mutations, samples and rays a second on the built-in scenes, with the share of ray traversal in
//! Metropolis sampling.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use mlt_benches::Loaded;
use mlt_core::engine::{Chain, Generator, Mixture, Purpose, Sink, Splat, Stratum, generator};
use mlt_core::transport::lights::{LightStrata, Stratification};
use mlt_core::transport::methods::MOST_EDGES;
use mlt_core::transport::methods::metropolis::{LightStratum, PathMutation};
use mlt_core::transport::paths::{LightPath, Luminance};
use mlt_core::transport::render::{Method, Renderer};
use mlt_core::transport::scene::rays_traced;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

const SIZE: [u32; 2] = [256, 256];
const SCENES: [&str; 2] = ["cornell", "suzanne"];
/// Longest path in edges, the limit under which other renderers' figures are quoted.
const EDGES: usize = 6;

/// One round of each method on one thread.
fn rounds(criterion: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for name in SCENES {
        let loaded = Loaded::builtin(name, SIZE);
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        for (method, label, per_pixel) in
            [(Method::Metropolis, "mlt", 4.0), (Method::Bidirectional, "bdpt", 1.0), (Method::Path, "pt", 1.0)]
        {
            let settings = loaded.settings(method, per_pixel).with(|s| s.max_edges = Some(EDGES));
            let renderer = Renderer::new(loaded.view(), settings);
            let mut sums = renderer.sums();
            group.throughput(Throughput::Elements((per_pixel * f64::from(SIZE[0] * SIZE[1])) as u64));
            let mut round = 0;
            group.bench_function(label, |bencher| {
                bencher.iter(|| {
                    let end = &mut |_, _: &_| ControlFlow::Continue(());
                    one.install(|| renderer.render(round..round + 1, &mut sums, end));
                    round += 1;
                    black_box(sums.tally().rays())
                });
            });
        }
        group.finish();
    }
}

type PathChain<'a> = Chain<'a, LightPath, LightStratum<'a>, PathMutation<'a>, Luminance>;

/// Swallows deposits.
struct Nowhere;

impl Sink<Splat<3>> for Nowhere {
    fn deposit(&mut self, splat: Splat<3>, weight: f64) {
        black_box((splat, weight));
    }
}

/// Steps of a bare chain, and how much of their time the same rays take without it.
fn chain(criterion: &mut Criterion) {
    for name in SCENES {
        let loaded = Loaded::builtin(name, SIZE);
        let strata = LightStrata::new(loaded.scene.lights(), Stratification::None);
        let strata = LightStratum::all(&strata, loaded.view(), MOST_EDGES);
        let mixture = Mixture::new(PathMutation::all(loaded.view()));
        let mut rng: Generator = generator(1, Purpose::Chain, 0, 0, 0);
        let mut start = None;
        while start.is_none() {
            strata[0].sample(&mut rng, &mut |path: &LightPath, _| start = Some(path.clone()));
        }
        let Some(mut chain) = start.and_then(|x| Chain::new(&mixture, &Luminance, &strata[0], x)) else {
            continue;
        };
        share_of_traversal(name, &loaded, &mut chain, &mut rng);
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(1));
        group.bench_function("mutation", |bencher| bencher.iter(|| chain.step(&mut Nowhere, 1.0, &mut rng)));
        group.finish();
    }
}

/// Prints the share: rays of a run × the time of a ray between vertices of the paths it visited, over its own time.
fn share_of_traversal(name: &str, loaded: &Loaded, chain: &mut PathChain, rng: &mut Generator) {
    const STEPS: usize = 200_000;
    let mut run = |steps: usize| (0..steps).for_each(|_| chain.step(&mut Nowhere, 1.0, rng));
    let (before, start) = (rays_traced(), Instant::now());
    run(STEPS);
    let (rays, run_time) = (rays_traced() - before, start.elapsed());
    let visited = |_| {
        (0..10).for_each(|_| chain.step(&mut Nowhere, 1.0, rng));
        chain.current().clone()
    };
    let paths: Vec<_> = (0..STEPS / 10).map(visited).collect();
    let (before, start) = (rays_traced(), Instant::now());
    for pair in paths.iter().flat_map(|path| path.vertices().windows(2)) {
        black_box(loaded.scene.trace(&pair[0].vertex, pair[0].to_eye));
        black_box(loaded.scene.visible(&pair[0].vertex, &pair[1].vertex));
    }
    let a_ray = start.elapsed().as_secs_f64() / (rays_traced() - before) as f64;
    let share = rays as f64 * a_ray / run_time.as_secs_f64();
    println!(
        "{name}: {:.2} M mutations/s, {:.2} M rays/s in the chain, {:.2} M rays/s bare, traversal {:.0} % of the time",
        STEPS as f64 / run_time.as_secs_f64() / 1e6,
        rays as f64 / run_time.as_secs_f64() / 1e6,
        1e-6 / a_ray,
        100.0 * share
    );
}

criterion_group!(benches, rounds, chain);
criterion_main!(benches);
