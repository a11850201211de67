//! What a Metropolis render counts.

use super::{StratumStats, Warning};
use std::borrow::Cow;

/// Counts of a render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// In the order of the strata.
    pub strata: Vec<StratumStats>,
    /// Names of the mutations, in the order of every stratum's list.
    pub mutations: Vec<Cow<'static, str>>,
}

impl Tally {
    /// Counts over all strata.
    pub fn total(&self) -> StratumStats {
        let mut total = StratumStats::default();
        self.strata.iter().for_each(|s| total.merge(s));
        total
    }

    /// Work of all strata, in the unit of [`Metropolis::counting`](super::Metropolis::counting).
    pub fn work(&self) -> u64 {
        self.strata.iter().map(|s| s.chain_work + s.sample_work).sum()
    }

    /// Signs that the image is wrong, or that its error bars say too little.
    pub fn warnings(&self) -> Vec<Warning> {
        Warning::all(self)
    }
}
