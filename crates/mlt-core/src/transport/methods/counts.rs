//! Counts of a render.

use super::independent::SampleTally;
use crate::engine::{Counted, DecodeError, Reader, StratumStats, SumTally, Tally, put, total_count};
use std::ops::Add;

/// Counts of a render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Of independent samples, and of chains.
    pub(super) made: SumTally<SampleTally, Tally>,
    /// Of the pilot, none of which is in an image.
    pub pilot: PilotCounts,
}

impl Counts {
    /// Counts without a pilot.
    pub fn new(samples: SampleTally, chains: Tally) -> Self {
        Self { made: SumTally(samples, chains), ..Self::default() }
    }

    /// Independent samples of the image.
    pub fn samples(&self) -> u64 {
        self.made.0.samples
    }

    /// Metropolis: its strata and mutations.
    pub fn chains(&self) -> &Tally {
        &self.made.1
    }

    /// Rays traced, those of the pilot not among them.
    pub fn rays(&self) -> u64 {
        total_count([self.made.0.rays, self.chains().work()])
    }

    /// Steps of all chains.
    pub fn steps(&self) -> u64 {
        total_count(self.chains().strata.iter().map(StratumStats::steps))
    }
}

impl Counted for Counts {
    fn merge(&mut self, other: &Self) {
        self.made.merge(&other.made);
        self.pilot.merge(&other.pilot);
    }

    fn write(&self, to: &mut Vec<u8>) {
        self.made.write(to);
        self.pilot.write(to);
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        Ok(Self { made: Counted::read(from)?, pilot: Counted::read(from)? })
    }
}

/// Cost of pilots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PilotCounts {
    /// Mutations.
    pub mutations: u64,
    /// Rays traced.
    pub rays: u64,
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

impl Counted for PilotCounts {
    /// All parts of a render have the same pilot, but one without any round has none yet.
    fn merge(&mut self, other: &Self) {
        self.mutations = self.mutations.max(other.mutations);
        self.rays = self.rays.max(other.rays);
    }

    fn write(&self, to: &mut Vec<u8>) {
        [self.mutations, self.rays].into_iter().for_each(|count| put(to, count));
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        Ok(Self { mutations: from.number()?, rays: from.number()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As a forged file may have them.
    #[test]
    fn counts_stay_at_the_largest() {
        let chains = Tally { strata: vec![StratumStats::of_largest_counts()], mutations: vec!["nudge".into()] };
        let mut counts = Counts::new(SampleTally { samples: u64::MAX, rays: u64::MAX }, chains);
        counts.merge(&counts.clone());
        assert_eq!([counts.samples(), counts.rays(), counts.steps()], [u64::MAX; 3]);
    }
}
