//! When a render stops that is asked to.

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

/// Time for the round in work from when a stop is asked for: with the files of an image of 1920x1080 that makes less than 5 s.
const PATIENCE: Duration = Duration::from_secs(3);

/// Lets the round in work come to its end where that is near, as it would be lost.
pub(super) struct Stop {
    round_began: Instant,
    asked: Option<Instant>,
}

impl Stop {
    /// For rounds from now on.
    pub(super) fn new(now: Instant) -> Self {
        Self { round_began: now, asked: None }
    }

    /// Breaks where a stop is asked for, unless the round in work is expected to end within 3 s of that. `rounds`: those made, with the
    /// finished part of the one in work.
    pub(super) fn go_on(&mut self, asked: bool, rounds: f64, now: Instant) -> ControlFlow<()> {
        let part = rounds.fract();
        if part == 0.0 {
            self.round_began = now;
        }
        if !asked {
            return ControlFlow::Continue(());
        }
        let since = now - *self.asked.get_or_insert(now);
        let waits = part > 0.0 && since + (now - self.round_began).mul_f64(1.0 / part - 1.0) <= PATIENCE;
        if waits { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_that_is_about_to_end_is_waited_for() {
        let start = Instant::now();
        let at = |seconds| start + Duration::from_secs_f64(seconds);
        // Rounds of 5 s: the third one is half done 12.5 s after the start.
        let mut stop = Stop::new(start);
        for (rounds, seconds) in [(0.5, 2.5), (1.0, 5.0), (1.5, 7.5), (2.0, 10.0)] {
            assert!(stop.go_on(false, rounds, at(seconds)).is_continue());
        }
        assert!(stop.go_on(true, 2.5, at(12.5)).is_continue());
        assert!(stop.go_on(true, 2.9, at(14.5)).is_continue());
        assert!(stop.go_on(true, 3.0, at(15.0)).is_break());
    }

    #[test]
    fn a_round_that_takes_longer_is_given_up() {
        let start = Instant::now();
        let at = |seconds| start + Duration::from_secs_f64(seconds);
        assert!(Stop::new(start).go_on(true, 0.4, at(4.0)).is_break());
        // It seemed to take 2 s more, and takes longer.
        let mut stop = Stop::new(start);
        assert!(stop.go_on(true, 0.5, at(2.0)).is_continue());
        assert!(stop.go_on(true, 0.6, at(4.0)).is_break());
        // A small one that has just begun is not worth the wait.
        assert!(Stop::new(start).go_on(true, 7.0, at(0.1)).is_break());
    }
}
