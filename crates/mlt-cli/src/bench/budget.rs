//! How much a run may spend.

use std::{fmt, time::Duration};

/// Condition that ends a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Time on the clock.
    Time(Duration),
    /// Mutations per pixel, for independent methods samples per pixel.
    PerPixel(f64),
    /// Rays per pixel; met as well as the rays of a first small render predict.
    Rays(f64),
}

impl Budget {
    /// Size, in the budget's own unit.
    pub fn amount(&self) -> f64 {
        match self {
            Self::Time(time) => time.as_secs_f64(),
            Self::PerPixel(n) | Self::Rays(n) => *n,
        }
    }

    /// Whether runs of this budget end at the same place on every machine and every time.
    pub fn repeats(&self) -> bool {
        !matches!(self, Self::Time(_))
    }
}

/// How far a run may end from its time to stand for it, as a share.
const NEAR: f64 = 0.05;

impl Budget {
    /// How much longer, as a share, a run of so many seconds took than it was given; `None` if that is near enough, and where time
    /// is not what it was given.
    pub fn missed_by(&self, seconds: f64) -> Option<f64> {
        let Self::Time(time) = self else { return None };
        let beyond = seconds / time.as_secs_f64() - 1.0;
        (beyond.abs() > NEAR).then_some(beyond)
    }
}

/// Names the budget in files, so it is exact.
impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(time) => write!(f, "{} s", time.as_secs_f64()),
            Self::PerPixel(n) => write!(f, "{n} per pixel"),
            Self::Rays(n) => write!(f, "{n} rays per pixel"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_off_their_time_are_told() {
        let budget = Budget::Time(Duration::from_secs(2));
        assert_eq!([1.91, 2.0, 2.09].map(|seconds| budget.missed_by(seconds)), [None; 3]);
        assert_eq!(budget.missed_by(3.0), Some(0.5));
        assert_eq!(budget.missed_by(1.0), Some(-0.5));
        assert_eq!(Budget::Rays(2.0).missed_by(3.0), None);
    }
}
