//! Timing in turns, so that what the machine does besides falls on all alike.

use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;

/// How long a turn took.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// Seconds on the clock.
    pub wall: f64,
    /// Seconds that the process's threads ran, all together.
    pub cpu: f64,
}

fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Gives each of `n` contestants a turn to warm up and then `slices` turns, another one first each time; the times of each.
pub fn take_turns(n: usize, slices: usize, mut turn: impl FnMut(usize)) -> Vec<Vec<Time>> {
    (0..n).for_each(&mut turn);
    let mut times = vec![Vec::with_capacity(slices); n];
    for slice in 0..slices {
        for i in (0..n).map(|k| (k + slice) % n) {
            let (start, start_cpu) = (Instant::now(), cpu());
            turn(i);
            times[i].push(Time { cpu: cpu() - start_cpu, wall: start.elapsed().as_secs_f64() });
        }
    }
    times
}

/// The middle value; of an even number, the upper one.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut sorted: Vec<_> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// The median over the slices of a's time over b's.
pub fn median_ratio(a: &[Time], b: &[Time], clock: fn(&Time) -> f64) -> f64 {
    median(a.iter().zip(b).map(|(a, b)| clock(a) / clock(b)))
}
