//! Counts of a Metropolis render.

use super::bytes::{put_list, put_text};
use super::count::total_count;
use super::{Counted, DecodeError, Reader, StratumStats, Warning};
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
        total_count(self.strata.iter().flat_map(|s| [s.chain_work, s.sample_work]))
    }

    /// Signs that the image is wrong, or that its error bars say too little.
    pub fn warnings(&self) -> Vec<Warning> {
        Warning::all(self)
    }
}

impl Counted for Tally {
    fn merge(&mut self, other: &Self) {
        let strata = self.strata.len().max(other.strata.len());
        self.strata.resize_with(strata, StratumStats::default);
        self.strata.iter_mut().zip(&other.strata).for_each(|(a, b)| a.merge(b));
        if self.mutations.is_empty() {
            self.mutations.clone_from(&other.mutations);
        }
    }

    fn write(&self, to: &mut Vec<u8>) {
        put_list(to, &self.strata, |to, stratum| stratum.write(to));
        put_list(to, &self.mutations, |to, name| put_text(to, name));
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let strata = from.list(StratumStats::read)?;
        Ok(Self { strata, mutations: from.list(|from| from.text().map(Cow::Owned))? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As a forged file may have them.
    #[test]
    fn counts_stay_at_the_largest() {
        let stats = StratumStats::of_largest_counts();
        let mut tally = Tally { strata: vec![stats.clone(), stats], mutations: vec!["nudge".into()] };
        tally.merge(&tally.clone());
        let total = tally.total();
        let of_mutation = total.mutations[0].total();
        assert_eq!([tally.work(), total.steps(), total.samples, total.coverage.shared, of_mutation], [u64::MAX; 5]);
        assert!(tally.warnings().iter().any(|warning| warning.to_string().contains(&u64::MAX.to_string())));
    }
}
