//! From a budget to rounds.

use std::{fmt, ops::Range, time::Duration};

use anyhow::anyhow;
use mlt_core::engine::{Limits, TRUSTED_ROUNDS};

use crate::{
    Failure,
    args::{kept::Shard, render::RenderOptions, transport::Method},
};

/// Rounds of a render with chains whose budget says nothing else.
const ROUNDS: u64 = 16;
/// Rounds of chains that a time budget aims at.
const TIMED_ROUNDS: f64 = 16.0;
/// Fewest rounds of samples that a time budget aims at, and half of the most: few, since well-stratified samples gain from
/// being many in a round, but enough to tell the error, and to end within a twentieth of the time.
const FEWEST_ROUNDS: f64 = TRUSTED_ROUNDS as f64 + 2.0;
/// Most mutations a pixel of a round that nobody asked for: what an interruption may cost.
const LARGEST_CHAINS: f64 = 64.0;
/// The same for samples.
const LARGEST_SAMPLES: f64 = 1024.0;
/// Parts of a mutation or sample a pixel that a round's size is a multiple of, so that decimal text holds it exactly.
const PARTS: f64 = 64.0;

/// How large a round is, and when a render ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Mutations or samples a pixel of one round; `None`: measured first, to suit the time.
    pub per_pixel: Option<f64>,
    /// Number of rounds; `None`: until the end comes.
    pub rounds: Option<u64>,
    /// Number of the first one.
    pub first: u64,
    /// The part of the rounds that is made; `None`: all.
    pub shard: Option<Shard>,
    /// Time on the clock for everything after loading.
    pub time: Option<Duration>,
    /// Relative error to reach.
    pub error: Option<f64>,
    method: Method,
}

impl Plan {
    /// The plan for what was asked for, or a sensible one. `held`: mutations or samples a pixel of the rounds that there are already,
    /// if any.
    pub(crate) fn new(options: &RenderOptions, held: Option<f64>) -> Self {
        let (method, rounds, first, shard) =
            (options.method(), options.rounds, options.first_round, options.keeping.shard);
        let open = Self { per_pixel: held, rounds, first, shard, time: None, error: None, method };
        match (options.per_pixel(), options.time, options.error) {
            (Some(total), ..) => open.sized(total),
            (_, Some(time), _) => Self { time: Some(time), ..open },
            (.., Some(error)) => {
                Self { per_pixel: held.or(Some(Self::usual(method) / 8.0)), error: Some(error), ..open }
            }
            _ => open.sized(Self::usual(method)),
        }
    }

    /// `total` mutations or samples a pixel, over all rounds: as many of the held size as come nearest, if nobody says how many.
    fn sized(self, total: f64) -> Self {
        if let (Some(held), None) = (self.per_pixel, self.rounds) {
            return Self { rounds: Some((total / held).round().max(1.0) as u64), ..self };
        }
        let usual = match self.method {
            Method::Pt | Method::Bdpt => rounds_of(total),
            method => {
                let most = if method.mutates() { u64::MAX } else { (total as u64).max(1) };
                ROUNDS.max((total / self.largest_round()).ceil() as u64).min(most)
            }
        };
        let rounds = self.rounds.unwrap_or(usual);
        // A short mantissa, so that the total of any number of rounds, as text, leads back to the same size.
        let per_pixel = f64::from((total / rounds as f64) as f32);
        Self { per_pixel: Some(per_pixel), rounds: Some(rounds), ..self }
    }

    fn largest_round(&self) -> f64 {
        if self.method.mutates() { LARGEST_CHAINS } else { LARGEST_SAMPLES }
    }

    /// Numbers of all rounds, over all shards; `None`: until the end comes.
    pub(crate) fn whole(&self) -> Option<Range<u64>> {
        self.rounds.map(|rounds| self.first..self.first + rounds)
    }

    /// Numbers of the rounds that are made here.
    pub(crate) fn own(&self) -> Range<u64> {
        let whole = self.whole().unwrap_or(self.first..u64::MAX);
        self.shard.map_or(whole.clone(), |shard| shard.of(whole))
    }

    /// Refuses shards of which some have no round.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        match (self.shard, self.rounds) {
            (Some(shard), Some(rounds)) if shard.count() > rounds => Err(Failure::Usage(anyhow!(
                "--shard {shard}: there are only {rounds} rounds to share out; make fewer parts, or more rounds with --rounds"
            ))),
            _ => Ok(()),
        }
    }

    /// Where the render ends.
    pub(crate) fn limits(&self) -> Limits {
        let own = self.own();
        let rounds = self.rounds.map(|_| own.end - own.start);
        Limits { rounds, time: self.time, error: self.error }
    }

    /// The warning if the error that was asked for is not reached.
    pub(crate) fn missed(&self, rounds: u64, error: Option<f64>) -> Option<String> {
        let target = 100.0 * self.error?;
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

    /// The size of a round that suits the time, at `rate` mutations or samples a pixel and second.
    pub(crate) fn per_pixel_at(&self, rate: f64, time: Duration) -> f64 {
        let total = rate * time.as_secs_f64();
        let usual = if self.method.mutates() { TIMED_ROUNDS } else { FEWEST_ROUNDS };
        let ideal = self.rounds.map_or((total / usual).min(self.largest_round()), |rounds| total / rounds as f64);
        match (self.method.mutates(), self.rounds) {
            (true, _) => ((ideal * PARTS).floor() / PARTS).max(1.0 / PARTS),
            (false, Some(_)) => ideal.floor().max(1.0),
            // The first 2^k points of a sequence are the best spread.
            (false, None) => (ideal.max(1.0).log2().floor()).exp2(),
        }
    }

    /// The options that make a render of `rounds` rounds of this size again.
    pub(crate) fn budget_option(method: Method, per_pixel: f64, rounds: u64) -> String {
        let total = per_pixel * rounds as f64;
        format!("--{}-per-pixel {total}", method.unit())
    }

    /// Mutations or samples a pixel of a render that nothing is said about.
    pub(crate) fn usual(method: Method) -> f64 {
        match method {
            Method::Mlt | Method::Mmlt => 128.0,
            Method::Bdpt | Method::Pssmlt => 32.0,
            Method::Auto | Method::Pt => 64.0,
        }
    }
}

/// Rounds for `total` samples a pixel. Well-stratified samples gain from being many in a round, and the first 2^k points of a sequence are
/// the best spread, so these are the fewest that tell the error or, if that makes 2^k samples a round, up to twice as many.
fn rounds_of(total: f64) -> u64 {
    let fewest = (total / LARGEST_SAMPLES).ceil().max(TRUSTED_ROUNDS as f64).min(total.floor()).max(1.0);
    let of_power = total / (total / fewest).log2().floor().exp2();
    if of_power.fract() == 0.0 { of_power as u64 } else { fewest as u64 }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.method.unit();
        match (self.per_pixel, self.rounds) {
            (Some(n), Some(rounds)) => write!(f, "{} {unit} per pixel in {rounds} rounds", n * rounds as f64),
            _ => f.write_str("going on until the end is reached"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_many_in_a_round() {
        for (total, rounds) in [
            (0.5, 1),
            (1.0, 1),
            (3.0, 3),
            (8.0, 8),
            (9.0, 9),
            (12.0, 12),
            (32.0, 8),
            (64.0, 8),
            (72.0, 9),
            (100.0, 8),
            (288.0, 9),
            (1000.0, 8),
            (8192.0, 8),
            (16384.0, 16),
            (20000.0, 20),
            (1e6, 977),
        ] {
            assert_eq!(rounds_of(total), rounds, "{total}");
        }
    }

    #[test]
    fn an_error_that_is_missed_is_told() {
        let open =
            Plan { per_pixel: None, rounds: None, first: 0, shard: None, time: None, error: None, method: Method::Pt };
        let plan = Plan { error: Some(0.02), ..open };
        assert!(plan.missed(64, None).expect("a sentence").contains("2 % cannot be reached"));
        assert!(plan.missed(9, Some(0.03)).expect("a sentence").contains("is 3.00 %"));
        assert_eq!(plan.missed(9, Some(0.02)), None);
    }
}
