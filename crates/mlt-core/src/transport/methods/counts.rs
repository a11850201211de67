//! Counts of a render.

use crate::engine::{StratumStats, Tally};
use std::ops::Add;

/// Counts of a render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Independent samples of the image.
    pub samples: u64,
    /// Rays traced, those of the pilot not among them.
    pub rays: u64,
    /// Mutations of the pilot, which are in no image.
    pub pilot_mutations: u64,
    /// Rays of the pilot.
    pub pilot_rays: u64,
    /// Metropolis: its strata and mutations.
    pub chains: Tally,
}

impl Counts {
    /// Steps of all chains.
    pub fn steps(&self) -> u64 {
        self.chains.strata.iter().map(StratumStats::steps).sum()
    }
}

/// Cost of pilots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PilotCounts {
    pub(crate) mutations: u64,
    pub(crate) rays: u64,
}

impl PilotCounts {
    pub(crate) fn of(tally: &Tally) -> Self {
        Self { mutations: tally.total().steps(), rays: tally.work() }
    }
}

impl Add for PilotCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { mutations: self.mutations + other.mutations, rays: self.rays + other.rays }
    }
}
