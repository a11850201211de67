//! How much a run may spend.

use std::{fmt, time::Duration};

/// What ends a run.
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
