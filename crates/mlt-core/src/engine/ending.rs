//! When a render ends: after some rounds, some time, or at some error.

use super::{Accumulated, Counted, Observer, Outcome, Progress};
use std::cell::Cell;
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

/// Fewest rounds whose spread is trusted to end a render.
pub const TRUSTED_ROUNDS: u64 = 8;
/// Rounds after which a render whose error is still unknown gives up: 8 times what it would take by itself.
const UNKNOWN_ROUNDS: u64 = 64;
/// Shares of the rounds that fit the time left which are begun together, at first and later: their time is known ever better.
const IN_FLIGHT: [f64; 2] = [0.25, 0.5];

/// Limits of a render; `None` is no limit. The first one that is reached ends it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Rounds that its sums hold in the end.
    pub rounds: Option<u64>,
    /// Time on the clock.
    pub time: Option<Duration>,
    /// Relative error to reach, estimated from at least [`TRUSTED_ROUNDS`] rounds.
    pub error: Option<f64>,
}

/// Where a render with [`Limits`] stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Rounds that its sums hold, with the finished share of the next one.
    pub rounds: f64,
    /// Estimated relative error after the last round, if it is known.
    pub error: Option<f64>,
    /// Share of the limit that is nearest, in [0, 1]. Errors fall as one over the square root of the work.
    pub share: f64,
    /// Time until the limit that is nearest, if it is known: see [`Ending::left`].
    pub left: Option<Duration>,
}

/// A render that makes rounds until its limits are reached.
#[derive(Clone, Copy, Debug)]
pub struct Ending<const C: usize> {
    limits: Limits,
    /// Weights of the channels in the error.
    weights: [f64; C],
    /// When its time began.
    start: Instant,
    /// Expected time of a round, as long as none is finished.
    expected: Duration,
    /// Whether the error is estimated where no limit asks for it.
    shows_error: bool,
}

/// Adds the rounds of a range to sums.
pub type Make<'a, const C: usize, T> =
    dyn Fn(Range<u64>, &mut Accumulated<C, T>, &mut Observer<'_, C, T>) -> Outcome + 'a;

/// Rounds that this render has made itself, and when it began with them.
#[derive(Clone, Copy)]
struct Pace {
    since: Instant,
    made: u64,
}

impl<const C: usize> Ending<C> {
    /// Limits of a render whose time began at `start`; the error is that of Σ_c weights_c × channel c.
    pub fn new(limits: Limits, weights: [f64; C], start: Instant) -> Self {
        Self { limits, weights, start, expected: Duration::ZERO, shows_error: false }
    }

    /// The same where a round is expected to take so long, as far as time is limited.
    #[must_use]
    pub fn expecting(self, expected: Duration) -> Self {
        Self { expected, ..self }
    }

    /// The same with the error estimated after each round, for whoever looks.
    #[must_use]
    pub fn showing_error(self, shows_error: bool) -> Self {
        Self { shows_error, ..self }
    }

    /// Makes rounds from number `first` on until the end; those that the sums hold already count and are not made again. `make` adds
    /// the rounds of a range, as [`render`](super::render) does, and `observe` may break before.
    ///
    /// A render that has reached a limit is complete, even where `observe` breaks after its last round.
    pub fn render<T: Counted>(
        &self,
        first: u64,
        sums: &mut Accumulated<C, T>,
        make: &Make<'_, C, T>,
        observe: &mut dyn FnMut(Standing, &Accumulated<C, T>) -> ControlFlow<()>,
    ) -> Outcome {
        let held = sums.film().rounds();
        let (since, mut error, reached, mut stopped) = (Instant::now(), None, Cell::new(false), false);
        let mut observe = |at: Progress, sums: &Accumulated<C, T>| {
            let (rounds, at_end) = (sums.film().rounds(), at.fraction == 0.0);
            if at_end && rounds > 1 && (self.shows_error || self.limits.error.is_some()) {
                error = Some(sums.film().relative_error(self.weights)).filter(|error| error.is_finite());
            }
            let done = rounds as f64 + at.fraction;
            let made = done - held as f64;
            let left = self.left(done, error, since.elapsed().div_f64(made.max(f64::MIN_POSITIVE)));
            let asked = observe(Standing { rounds: done, error, share: self.share(done, error), left }, sums);
            reached.set(at_end && self.is_reached(rounds, error));
            if reached.get() { ControlFlow::Break(()) } else { asked }
        };
        loop {
            let (done, missing) = (sums.film().rounds(), sums.rounds().missing(first..u64::MAX));
            let Some(next) = missing.into_iter().next().filter(|_| !reached.get()) else {
                return Outcome::Complete;
            };
            let begun = self.next(done, Pace { since, made: done - held });
            let rounds = next.start..next.end.min(next.start.saturating_add(begun));
            if rounds.is_empty() {
                return Outcome::Complete;
            }
            if stopped {
                return Outcome::Stopped;
            }
            stopped = make(rounds.clone(), sums, &mut observe) == Outcome::Stopped;
            if stopped && !reached.get() && !sums.rounds().missing(rounds).is_empty() {
                return Outcome::Stopped;
            }
        }
    }

    /// Rounds to begin now that `done` are finished, all of which will count; 0: no more.
    ///
    /// No round is begun that would have less than half of the time that it is expected to take. Rounds may take longer than
    /// expected, so only a part of those that fit are begun at once.
    fn next(&self, done: u64, pace: Pace) -> u64 {
        let more = self.limits.rounds.map_or(u64::MAX, |rounds| rounds.saturating_sub(done));
        let Some(time) = self.limits.time else { return more };
        let round = match pace.made {
            0 => self.expected.as_secs_f64(),
            made => pace.since.elapsed().as_secs_f64() / made as f64,
        };
        let fit = time.saturating_sub(self.start.elapsed()).as_secs_f64() / round.max(1e-9);
        let begun = (fit * IN_FLIGHT[usize::from(pace.made > 0)]).round() as u64;
        if fit < 0.5 && done > 0 { 0 } else { begun.max(1).min(more) }
    }

    /// The share of the limit that is nearest, after `done` rounds.
    fn share(&self, done: f64, error: Option<f64>) -> f64 {
        let rounds = self.limits.rounds.map_or(0.0, |rounds| done / rounds as f64);
        let time = self.limits.time.map_or(0.0, |time| self.start.elapsed().as_secs_f64() / time.as_secs_f64());
        let trusted = done / TRUSTED_ROUNDS as f64;
        let error = self.limits.error.zip(error).map_or(0.0, |(target, error)| (target / error).powi(2).min(trusted));
        rounds.max(time).max(error).min(1.0)
    }

    /// Time until the limit that is nearest, after `done` rounds of which each took the time `round`: what is left of the clock; the
    /// rounds that are to come; or those that bring the error e down to the target t, done · (e/t)² in all, for errors fall as one
    /// over the square root of the work. `None` where the limits do not tell, as of an error that is not known yet.
    pub fn left(&self, done: f64, error: Option<f64>, round: Duration) -> Option<Duration> {
        let clock = self.limits.time.map(|time| time.saturating_sub(self.start.elapsed()));
        let of_error = |(target, error): (f64, f64)| (done * (error / target).powi(2)).max(TRUSTED_ROUNDS as f64);
        let rounds = self.limits.rounds.map(|rounds| rounds as f64);
        let last = rounds.into_iter().chain(self.limits.error.zip(error).map(of_error)).reduce(f64::min);
        let work = last.and_then(|last| Duration::try_from_secs_f64(round.as_secs_f64() * (last - done).max(0.0)).ok());
        clock.into_iter().chain(work).min()
    }

    /// Whether the error ends the render.
    fn is_reached(&self, rounds: u64, error: Option<f64>) -> bool {
        self.limits.error.is_some_and(|target| match error {
            Some(error) => rounds >= TRUSTED_ROUNDS && error <= target,
            None => rounds >= UNKNOWN_ROUNDS,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Film, Sink, Splat};

    fn ending(limits: Limits, ago: u64) -> Ending<1> {
        Ending::new(limits, [1.0], Instant::now() - Duration::from_secs(ago)).expecting(Duration::from_secs(1))
    }

    #[test]
    fn rounds_in_flight_fit_the_time_left() {
        let limits = Limits { time: Some(Duration::from_secs(16)), ..Limits::default() };
        let pace = |made, ago| Pace { since: Instant::now() - Duration::from_secs(ago), made };
        assert_eq!(ending(limits, 0).next(0, pace(0, 0)), 4);
        // 1000 rounds in no time at all: many more fit.
        assert!(ending(limits, 0).next(1000, pace(1000, 0)) > 1000);
        assert_eq!([4, 8, 48].map(|made| ending(limits, 15).next(made, pace(made, 12))), [0, 1, 2]);
        // One round at least, but no more where others were held already.
        assert_eq!([0, 3].map(|done| ending(limits, 17).next(done, pace(0, 0))), [1, 0]);
    }

    /// Rounds of 1, or of 0 and 1 in turn.
    fn made(limits: Limits, held: &[Range<u64>], value: fn(u64) -> f64) -> (Outcome, String) {
        made_until(limits, held, value, f64::INFINITY)
    }

    /// The same where `observe` breaks from so many rounds on.
    fn made_until(limits: Limits, held: &[Range<u64>], value: fn(u64) -> f64, stop: f64) -> (Outcome, String) {
        let mut sums = Accumulated::<1, u64>::new(Film::new(1, 1.0));
        let close = |sums: &mut Accumulated<1, u64>, round: u64| {
            let mut deposits = sums.film.deposits();
            deposits.deposit(Splat { site: 0, value: [value(round)] }, 1.0);
            sums.film.add(&mut [deposits]);
            sums.film.close_round(round, 1);
        };
        held.iter().cloned().flatten().for_each(|round| close(&mut sums, round));
        let make = |rounds: Range<u64>, sums: &mut Accumulated<1, u64>, observe: &mut Observer<'_, 1, u64>| {
            for (rounds, round) in (1..).zip(rounds) {
                close(sums, round);
                if observe(Progress { rounds, fraction: 0.0 }, sums).is_break() {
                    return Outcome::Stopped;
                }
            }
            Outcome::Complete
        };
        let mut observe = |at: Standing, _: &Accumulated<1, u64>| match at.rounds < stop {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        let outcome = ending(limits, 0).render(2, &mut sums, &make, &mut observe);
        (outcome, sums.rounds().to_string())
    }

    #[test]
    fn rounds_that_are_held_are_not_made_again() {
        let limits = Limits { rounds: Some(9), ..Limits::default() };
        assert_eq!(made(limits, &[], |_| 1.0), (Outcome::Complete, "2 to 10".into()));
        assert_eq!(made(limits, &[3..5, 8..9], |_| 1.0), (Outcome::Complete, "2 to 10".into()));
    }

    /// After 16 of 64 rounds of 2 s: 96 s of rounds, 12 s of the clock, and for half of the error three times what was done.
    #[test]
    fn the_time_left_is_that_of_the_nearest_limit() {
        let rounds = Limits { rounds: Some(64), ..Limits::default() };
        let time = Limits { time: Some(Duration::from_secs(20)), ..Limits::default() };
        let error = Limits { error: Some(0.01), ..Limits::default() };
        let left = |limits, error| {
            let left = ending(limits, 8).left(16.0, error, Duration::from_secs(2));
            left.map(|left| left.as_secs_f64().round())
        };
        assert_eq!(left(rounds, None), Some(96.0));
        assert_eq!(left(time, None), Some(12.0));
        assert_eq!((left(error, None), left(error, Some(0.02))), (None, Some(96.0)));
        assert_eq!(left(Limits { time: time.time, ..error }, Some(0.02)), Some(12.0));
        // Eight rounds are made at least.
        assert_eq!(ending(error, 0).share(2.0, Some(1e-3)), 0.25);
        assert_eq!(ending(error, 0).left(2.0, Some(1e-3), Duration::from_secs(1)), Some(Duration::from_secs(6)));
    }

    #[test]
    fn an_error_that_is_reached_or_stays_unknown_ends_the_render() {
        let limits = |error| Limits { error: Some(error), ..Limits::default() };
        assert_eq!(made(limits(0.02), &[], |_| 1.0), (Outcome::Complete, "2 to 9".into()));
        assert_eq!(made(limits(0.02), &[], |_| 0.0), (Outcome::Complete, "2 to 65".into()));
        // R rounds of 0 and 2 have the relative error 1/√(R − 1) with R even.
        assert_eq!(made(limits(0.1), &[], |round| 2.0 * (round % 2) as f64), (Outcome::Complete, "2 to 103".into()));
    }

    #[test]
    fn a_stop_after_the_last_round_stops_nothing() {
        let rounds = Limits { rounds: Some(9), ..Limits::default() };
        let error = Limits { error: Some(0.02), ..Limits::default() };
        let time = Limits { time: Some(Duration::ZERO), ..Limits::default() };
        for (limits, last, all) in [(rounds, 9, "2 to 10"), (error, 8, "2 to 9"), (time, 1, "2")] {
            let until = |stop| made_until(limits, &[], |_| 1.0, stop);
            assert_eq!(until(f64::from(last)), (Outcome::Complete, all.into()), "{limits:?}");
            if last > 1 {
                let most = format!("2 to {last}");
                assert_eq!(until(f64::from(last - 1)), (Outcome::Stopped, most), "{limits:?}");
            }
        }
    }
}
