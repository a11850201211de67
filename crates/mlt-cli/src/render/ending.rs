//! When a render ends.

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

use super::{Plan, plan::TRUSTED_ROUNDS};
use crate::interrupt::Interrupt;

/// Steps of the progress bar.
pub const STEPS: u64 = 1000;

/// Rounds after which a render whose error is still unknown gives up: 8 times what it would take by itself.
const UNKNOWN_ROUNDS: u64 = 64;
/// Shares of the rounds that fit the time left which are begun together, at first and later: their time is known ever better.
const IN_FLIGHT: [f64; 2] = [0.25, 0.5];

/// When a render ends.
pub struct Ending {
    plan: Plan,
    interrupt: Interrupt,
    start: Instant,
    /// When its first round began.
    rounds_since: Instant,
    /// Expected time of a round, as long as none is finished.
    expected: Duration,
}

impl Ending {
    /// A render that began at `start`, whose rounds begin now.
    pub fn new(plan: Plan, interrupt: Interrupt, start: Instant, expected: Duration) -> Self {
        Self { plan, interrupt, start, rounds_since: Instant::now(), expected }
    }

    /// Rounds to begin now that `done` are finished, all of which will count; 0: no more.
    ///
    /// A round that is expected to end half of itself too late is as good as none. So that rounds that take longer than expected do
    /// not end far too late, most of the time left is kept for later.
    pub fn next(&self, done: u64) -> u64 {
        let more = self.plan.rounds.map_or(u64::MAX, |rounds| rounds - done);
        let Some(time) = self.plan.time else { return more };
        let round = match done {
            0 => self.expected.as_secs_f64(),
            _ => self.rounds_since.elapsed().as_secs_f64() / done as f64,
        };
        let fit = time.saturating_sub(self.start.elapsed()).as_secs_f64() / round.max(1e-9);
        let begun = (fit * IN_FLIGHT[usize::from(done > 0)]).round() as u64;
        if fit < 0.5 && done > 0 { 0 } else { begun.max(1).min(more) }
    }

    /// Whether the error decides it.
    pub fn needs_error(&self) -> bool {
        self.plan.error.is_some()
    }

    /// Where the progress bar stands after `done` rounds; errors fall as one over the square root of the work.
    pub fn share(&self, done: f64, error: Option<f64>) -> u64 {
        let rounds = self.plan.rounds.map_or(0.0, |rounds| done / rounds as f64);
        let time = self.plan.time.map_or(0.0, |time| self.start.elapsed().as_secs_f64() / time.as_secs_f64());
        let error = self.plan.error.zip(error).map_or(0.0, |(target, error)| (target / error).powi(2));
        (rounds.max(time).max(error).min(1.0) * STEPS as f64) as u64
    }

    /// Breaks when the render is to stop in the middle of what was begun: on a signal at once, else at the end of a round.
    pub fn reached(&self, rounds: u64, at_end: bool, error: Option<f64>) -> ControlFlow<()> {
        let done = self.plan.error.is_some_and(|target| match error {
            Some(error) => rounds >= TRUSTED_ROUNDS && error <= target,
            None => rounds >= UNKNOWN_ROUNDS,
        });
        if self.interrupt.requested() || (at_end && done) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The warning if the error that was asked for is not reached.
    pub fn missed(&self, rounds: u64, error: Option<f64>) -> Option<String> {
        let target = 100.0 * self.plan.error?;
        match error {
            Some(error) if 100.0 * error <= target => None,
            Some(error) => Some(format!(
                "--error {target} % is not reached in {rounds} rounds: the estimated error is {:.2} %; take more rounds",
                100.0 * error
            )),
            None => Some(format!(
                "--error {target} % cannot be reached: after {rounds} rounds the image's error is still unknown, because the image \
                 is black or some pixels are too bright"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::render::RenderOptions;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: RenderOptions,
    }

    fn ending(line: &str, round: Duration) -> Ending {
        let words = std::iter::once("mlt").chain(line.split_whitespace());
        let plan = Plan::new(&Line::try_parse_from(words).expect("valid").options);
        Ending::new(plan, Interrupt::default(), Instant::now(), round)
    }

    #[test]
    fn rounds_in_flight_fit_the_time_left() {
        let ending = ending("--time 16s", Duration::from_secs(1));
        assert_eq!(ending.next(0), 4);
        // 1000 rounds in no time at all: many more fit.
        assert!(ending.next(1000) > 1000);
        let late = Ending { start: Instant::now() - Duration::from_secs(15), ..ending };
        let slow = Ending { rounds_since: Instant::now() - Duration::from_secs(12), ..late };
        assert_eq!([4, 8, 48].map(|done| slow.next(done)), [0, 1, 2]);
    }

    #[test]
    fn all_rounds_are_begun_where_no_clock_ends_them() {
        assert_eq!(ending("--samples-per-pixel 64 --rounds 7", Duration::ZERO).next(3), 4);
        assert_eq!(ending("--error 2%", Duration::ZERO).next(3), u64::MAX);
    }

    #[test]
    fn an_error_that_stays_unknown_ends_the_render_with_a_sentence() {
        let ending = ending("--error 2%", Duration::ZERO);
        assert!(ending.reached(63, true, None).is_continue() && ending.reached(64, true, None).is_break());
        assert!(ending.reached(7, true, Some(0.01)).is_continue() && ending.reached(8, true, Some(0.02)).is_break());
        assert!(
            ending.reached(8, false, Some(0.02)).is_continue() && ending.reached(800, true, Some(0.03)).is_continue()
        );
        assert!(ending.missed(64, None).expect("a sentence").contains("2 % cannot be reached"));
        assert!(ending.missed(9, Some(0.03)).expect("a sentence").contains("is 3.00 %"));
        assert_eq!(ending.missed(9, Some(0.02)), None);
    }
}
