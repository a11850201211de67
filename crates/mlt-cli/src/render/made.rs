//! A render that is over: its rounds and its report.

use mlt_core::transport::render::Sums;

use super::features::Features;
use crate::{kept::About, report::Report};

/// A render that is over.
pub(crate) struct Finished {
    /// Its rounds.
    pub sums: Sums,
    /// All else.
    pub made: Made,
}

/// The report of some rounds.
pub(crate) struct Made {
    /// Which render they are of.
    pub about: About,
    /// Its pilot's findings, if it has one.
    pub pilot: Option<Vec<u8>>,
    /// Its report, without the files.
    pub report: Report,
    /// Mutations or samples a pixel of one round.
    pub per_pixel: f64,
    /// Features of its image.
    pub features: Features,
}
