//! Lines for a log.

use std::{
    io::{Write, stderr},
    time::{Duration, Instant},
};

/// A render that is done before this says nothing.
const FIRST: Duration = Duration::from_secs(1);
/// Time between two lines at least, unless [`MUCH`] was done.
const APART: Duration = Duration::from_secs(10);
/// The same as a share of the time so far, so that a long render does not fill its log.
const APART_OF_LONG: f64 = 0.1;
/// Share of the work that is worth a line.
const MUCH: f64 = 0.1;

/// Tells now and then how far a render is.
#[derive(Debug)]
pub(super) struct Lines {
    start: Instant,
    /// Time of the last line since the start, and the share that was done then.
    last: Option<(Duration, f64)>,
}

impl Lines {
    pub(super) fn new() -> Self {
        Self { start: Instant::now(), last: None }
    }

    pub(super) fn show(&mut self, share: f64, parts: &[String]) {
        if self.is_due(self.start.elapsed(), share) {
            // Nobody is left to tell when standard error is gone.
            let _ = writeln!(stderr(), "progress: {}", parts.join(", "));
        }
    }

    /// Whether a line is due after this time; then it counts as written.
    fn is_due(&mut self, time: Duration, share: f64) -> bool {
        let due = match self.last {
            None => time >= FIRST,
            Some((last, done)) => {
                let since = time - last;
                since >= APART.max(time.mul_f64(APART_OF_LONG)) || (since >= FIRST && share >= done + MUCH)
            }
        };
        if due {
            self.last = Some((time, share));
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_now_and_then() {
        // Seconds at which lines are written where so much is done every second.
        let told = |share_per_second: f64, seconds: u64| -> Vec<u64> {
            let mut lines = Lines::new();
            let share = |second: u64| share_per_second * second as f64;
            (0..seconds).filter(|&second| lines.is_due(Duration::from_secs(second), share(second))).collect()
        };
        assert_eq!(told(0.06, 16), [1, 3, 5, 7, 9, 11, 13, 15]);
        assert_eq!(told(0.001, 40), [1, 11, 21, 31]);
        assert!(told(1e-6, 8 * 3600).len() < 100, "{:?}", told(1e-6, 8 * 3600).len());
    }
}
