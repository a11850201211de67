//! Timing in turns, so that what the machine does besides falls on all alike.

use rustix::time::{ClockId, clock_gettime};
use std::sync::LazyLock;
use std::time::Instant;

/// Seconds on the clock.
pub fn wall() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// Seconds that all threads of the process have run.
pub fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// How often everyone has a turn, and on which clock.
pub struct Contest {
    /// Turns of each.
    pub slices: usize,
    /// [`wall`] or [`cpu`].
    pub clock: fn() -> f64,
}

impl Contest {
    /// Seconds of each turn of each of `n` contestants, who begin in another place each time.
    pub fn run(&self, n: usize, mut turn: impl FnMut(usize)) -> Vec<Vec<f64>> {
        (0..n).for_each(&mut turn);
        let mut times = vec![vec![0.0; self.slices]; n];
        for slice in 0..self.slices {
            for i in (0..n).map(|k| (k + slice) % n) {
                let start = (self.clock)();
                turn(i);
                times[i][slice] = (self.clock)() - start;
            }
        }
        times
    }
}

/// The middle value; of an even number, the upper one.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// The median of a over b, turn by turn.
pub fn median_ratio(a: &[f64], b: &[f64]) -> f64 {
    median(&a.iter().zip(b).map(|(a, b)| a / b).collect::<Vec<_>>())
}
