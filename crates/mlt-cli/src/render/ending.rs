//! When a render ends.

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

use super::{Plan, plan::TRUSTED_ROUNDS};
use crate::interrupt::Interrupt;

/// Steps of the progress bar.
pub const STEPS: u64 = 1000;

/// When a render ends.
pub struct Ending {
    plan: Plan,
    interrupt: Interrupt,
    start: Instant,
    /// When the current round began.
    round: Instant,
    /// Longest round so far.
    longest: Duration,
}

impl Ending {
    /// A render that began at `start`.
    pub fn new(plan: Plan, interrupt: Interrupt, start: Instant) -> Self {
        Self { plan, interrupt, start, round: Instant::now(), longest: Duration::ZERO }
    }

    /// Where the progress bar stands after `done` rounds; errors fall as one over the square root of the work.
    pub fn share(&self, done: f64, error: Option<f64>) -> u64 {
        let rounds = self.plan.rounds.map_or(0.0, |rounds| done / rounds as f64);
        let time = self.plan.time.map_or(0.0, |time| self.start.elapsed().as_secs_f64() / time.as_secs_f64());
        let error = self.plan.error.zip(error).map_or(0.0, |(target, error)| (target / error).powi(2));
        (rounds.max(time).max(error).min(1.0) * STEPS as f64) as u64
    }

    /// Breaks when the render is to stop: on a signal at once, else at the end of a round.
    pub fn reached(&mut self, rounds: u64, at_end: bool, error: Option<f64>) -> ControlFlow<()> {
        if at_end {
            self.longest = self.longest.max(self.round.elapsed());
            self.round = Instant::now();
        }
        // Half a round too late is as good as half a round too early.
        let late = self.plan.time.is_some_and(|time| self.start.elapsed() + self.longest / 2 > time);
        let good =
            rounds >= TRUSTED_ROUNDS && self.plan.error.zip(error).is_some_and(|(target, error)| error <= target);
        if self.interrupt.requested() || (at_end && (late || good)) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
