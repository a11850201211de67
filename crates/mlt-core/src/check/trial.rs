//! How often something is tried, and means of what ought to be 0.

/// Chance that a check finds a given law broken that is kept.
pub const SIGNIFICANCE: f64 = 1e-4;

/// Trials whose value is not 0 that are enough for a mean to be nearly normal.
const ENOUGH: u64 = 50;

/// How often something is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trials {
    /// Number of trials: samples of a stratum, chains or evaluations.
    pub count: u64,
    /// Key of their random numbers.
    pub seed: u64,
}

/// Moments of values whose expectation ought to be 0, one a trial.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Zero {
    trials: u64,
    lit: u64,
    sum: f64,
    squares: f64,
}

impl Zero {
    /// No value yet, for so many trials; those that add none count as 0.
    pub(super) fn new(trials: u64) -> Self {
        Self { trials, ..Self::default() }
    }

    pub(super) fn add(&mut self, value: f64) {
        self.lit += u64::from(value != 0.0);
        self.sum += value;
        self.squares += value * value;
    }

    /// Mean over its standard error; `None` where too few values are not 0.
    pub(super) fn z(&self) -> Option<f64> {
        let n = self.trials as f64;
        let mean = self.sum / n;
        let variance = (self.squares / n - mean * mean).max(0.0) / (n - 1.0);
        // Values that are all the same have no scatter.
        (self.lit >= ENOUGH).then(|| mean / variance.sqrt().max(1e-12 * mean.abs()))
    }
}
