//! How renders would scale to more threads than a machine has: what each part of a round costs is measured on one thread, and
//! put on the clock of as many threads as the renderer would put it, steal by steal.
//!
//! Work that all threads share goes to the thread that is free first, in its order. A parallel step ends when its last task
//! does, and is charged [`WAKE`] for its start. Not in it: processors that share memory, caches and power; start-up and files.

use mlt_benches::Loaded;
use mlt_core::engine::{
    Estimator, Film, MUTATIONS_PER_SAMPLE, Metropolis, Mixture, batch_size, rounds_in_flight, shares_by_power,
    with_shares,
};
use mlt_core::transport::lights::{LightRegion, LightStrata, Stratification};
use mlt_core::transport::methods::metropolis::{LightStratum, PathMutation};
use mlt_core::transport::methods::{AllPaths, Independent, MOST_EDGES, PathTracer};
use mlt_core::transport::paths::Luminance;
use mlt_core::transport::render::film_of;
use mlt_core::transport::scene::rays_traced;
use std::time::Instant;

const THREADS: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 96, 128];
/// Rounds that are measured.
const MEASURED: u64 = 6;
/// Rounds of the render, which repeats what was measured.
const ROUNDS: usize = 768;
/// Seconds that a parallel step takes to reach all threads, more than rayon was seen to need on two.
const WAKE: f64 = 2e-5;
/// Bands of a film of 256×256, each merged by one thread: as many threads as there are take part in merging and closing.
const BANDS: usize = 64;

/// Seconds of the parts of one round, on one thread.
struct Round {
    /// Independent samples behind b̂ and starts, in blocks that any thread can take.
    samples: Vec<f64>,
    /// Its tasks.
    tasks: Vec<f64>,
    /// Merging the deposits of one task.
    add: f64,
    /// Closing it, and the means by which an observer compares rounds.
    close: f64,
    /// Its counts, on one thread whatever there is.
    tally: f64,
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Runs rounds on the calling thread; `blocks`: parts that the samples of a round come in.
fn measure<E: Estimator<3>>(estimator: &E, film: &mut Film<3>, blocks: usize) -> Vec<Round> {
    let mut total = E::Tally::default();
    let mut round = |number: u64| {
        let (prepared, samples) = timed(|| estimator.prepare(number));
        let (mut tallies, mut tasks, mut add) = (Vec::new(), Vec::new(), 0.0);
        let mut deposits = [film.deposits()];
        for task in 0..estimator.tasks(&prepared) {
            deposits[0].clear();
            let (tally, seconds) = timed(|| estimator.run(&prepared, task, &mut deposits[0]));
            tallies.push(tally);
            tasks.push(seconds);
            add += timed(|| film.add(&mut deposits)).1;
        }
        let ((), close) = timed(|| film.close_round(number, estimator.weight(number)));
        let ((), tally) = timed(|| {
            estimator.tally(&mut total, &prepared, tallies);
            estimator.tally_round(&mut total, &prepared);
        });
        let samples = vec![samples / blocks as f64; blocks];
        Round { samples, add: add / tasks.len() as f64, tasks, close, tally }
    };
    round(0);
    (1..=MEASURED).map(round).collect()
}

/// Seconds until the last of some tasks is done.
fn makespan(tasks: impl Iterator<Item = f64>, threads: usize) -> f64 {
    let mut busy_until = vec![0.0; threads];
    for task in tasks {
        let first = busy_until.iter_mut().min_by(|a, b| f64::total_cmp(a, b)).expect("a thread");
        *first += task;
    }
    WAKE + busy_until.into_iter().fold(0.0, f64::max)
}

/// Seconds of a whole render, as `engine::render` runs it.
fn render(rounds: &[Round], threads: usize, task_deposits: usize) -> f64 {
    let round = |number: usize| &rounds[number % rounds.len()];
    let shared = |seconds: f64| WAKE + seconds / threads.min(BANDS) as f64;
    let (mut clock, mut next, mut in_flight) = (0.0, 0, 1);
    while next < ROUNDS {
        let flight = next..ROUNDS.min(next + in_flight);
        clock += makespan(flight.clone().flat_map(|r| round(r).samples.iter().copied()), threads);
        let tasks: Vec<_> = flight.clone().flat_map(|r| round(r).tasks.iter().map(move |&t| (r, t))).collect();
        for batch in tasks.chunks(batch_size::<3>(threads, task_deposits)) {
            clock += makespan(batch.iter().map(|task| task.1), threads);
            let merges = batch.chunk_by(|a, b| a.0 == b.0);
            clock += merges.map(|of_round| shared(of_round.len() as f64 * round(of_round[0].0).add)).sum::<f64>();
        }
        clock += flight.clone().map(|r| shared(round(r).close) + WAKE + round(r).tally).sum::<f64>();
        in_flight = rounds_in_flight(threads, tasks.len() / flight.len()) as usize;
        next = flight.end;
    }
    clock
}

/// A row of the table.
fn print(name: &str, rounds: &[Round], task_deposits: usize) {
    let share = |part: fn(&Round) -> f64| {
        let sum = |part: fn(&Round) -> f64| rounds.iter().map(part).sum::<f64>();
        let all = |r: &Round| r.samples.iter().chain(&r.tasks).sum::<f64>() + r.merges() + r.close + r.tally;
        100.0 * sum(part) / sum(all)
    };
    let longest = rounds.iter().flat_map(|r| &r.tasks).fold(0.0, |a: f64, &b| a.max(b));
    let shares = [share(|r| r.samples.iter().sum()), share(Round::merges), share(|r| r.close), share(|r| r.tally)];
    let shares = shares.map(|share| format!("{share:.2}")).join(" | ");
    let one = render(rounds, 1, task_deposits);
    let gains = THREADS[1..].iter().map(|&threads| format!("{:.1}", one / render(rounds, threads, task_deposits)));
    let gains = gains.collect::<Vec<_>>().join(" | ");
    println!("| {name} | {} | {:.1} | {shares} | {gains} |", rounds[0].tasks.len(), 1e3 * longest);
}

impl Round {
    fn merges(&self) -> f64 {
        self.add * self.tasks.len() as f64
    }
}

fn chains(name: &str, stratification: Stratification, per_pixel: f64) {
    let loaded = Loaded::builtin(name, [256, 256]);
    let view = loaded.view();
    let parts = LightStrata::new(loaded.scene.lights(), stratification);
    let strata = LightStratum::all(&parts, view, MOST_EDGES);
    let shares = shares_by_power(&strata, per_pixel * f64::from(view.camera.pixels()), MUTATIONS_PER_SAMPLE);
    let mixture = Mixture::new(PathMutation::all(view));
    let strata = with_shares(strata, &shares).expect("a share for each");
    let estimator = Metropolis::new(&strata, &mixture, &Luminance, 1).expect("sound").counting(rays_traced);
    let mut film = film_of(view);
    let blocks = shares.iter().map(|share| share.samples.div_ceil(256) as usize).sum();
    let rounds = measure(&estimator, &mut film, blocks);
    print(&format!("mlt, {name}, strata: {}", strata.len()), &rounds, Estimator::<3>::task_deposits(&estimator));
}

fn paths(name: &str, samples_per_pixel: f64) {
    let loaded = Loaded::builtin(name, [256, 256]);
    let view = loaded.view();
    let region = LightRegion::whole(loaded.scene.lights());
    let light_sampler = region.light_sampler();
    let tracer = PathTracer { view, light_sampler, max_edges: MOST_EDGES, max_image_edges: MOST_EDGES, branches: 1 };
    let estimator = Independent { sampler: &tracer, selection: AllPaths, samples_per_pixel, seed: 1 };
    let mut film = film_of(view);
    let rounds = measure(&estimator, &mut film, 1);
    print(&format!("pt, {name}"), &rounds, Estimator::<3>::task_deposits(&estimator));
}

fn main() {
    let threads = THREADS[1..].iter().map(|threads| format!(" {threads} |")).collect::<String>();
    println!("| | tasks a round | longest, ms | samples, % | merge, % | close, % | counts, % |{threads}");
    println!("|---|---|---|---|---|---|---|{}", "---|".repeat(THREADS.len() - 1));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(|| {
        paths("cornell", 8.0);
        chains("cornell", Stratification::None, 8.0);
        chains("suzanne", Stratification::None, 8.0);
        chains("cornell", Stratification::Grid(4, 4), 8.0);
        chains("suzanne", Stratification::Grid(16, 16), 8.0);
    });
}
