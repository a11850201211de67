//! The horizontal axis of a chart.

use super::row::Row;

/// Horizontal axis of a chart of error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// Seconds on the clock.
    Seconds,
    /// Rays per pixel.
    Rays,
    /// Mutations per pixel, or samples per pixel.
    Work,
}

impl Axis {
    /// Where a run stands on it.
    pub(super) fn of(self, row: &Row) -> f64 {
        match self {
            Self::Seconds => row.seconds,
            Self::Rays => row.rays_per_pixel(),
            Self::Work => row.per_pixel(),
        }
    }

    /// Its name in the name of a file.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Seconds => "seconds",
            Self::Rays => "rays",
            Self::Work => "work",
        }
    }

    /// Its name with unit.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Seconds => "seconds",
            Self::Rays => "rays per pixel",
            Self::Work => "mutations or samples per pixel",
        }
    }
}
