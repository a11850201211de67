//! Whether the strata are a partition of the space, as far as a render can see.

use super::count::add_count;

/// Where states lie that a render met: a few of the independent samples, and of the proposals that left their stratum.
///
/// In a partition every state of positive importance is in one stratum, and a sample is in its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// States that were looked at.
    pub states: u64,
    /// Independent samples that lie outside their own stratum.
    pub astray: u64,
    /// Proposals of positive importance that lie in no stratum.
    pub uncovered: u64,
    /// States that lie in two strata or more.
    pub shared: u64,
}

/// Strata that are asked about a state, at most, for each chain and each block of samples, on average over rounds.
const MOST_STRATA: u64 = 64;

impl Coverage {
    /// Whether it is a chain's turn, or a block of samples', to be looked at in a round.
    pub(super) fn is_due(round: u64, stratum: usize, index: u64, strata: usize) -> bool {
        let turns = (strata as u64).div_ceil(MOST_STRATA);
        (round % turns + stratum as u64 + index).is_multiple_of(turns)
    }

    /// Takes in an independent sample of positive weight: whether it is in its own stratum, and in how many others.
    pub(super) fn add_sample(&mut self, own: bool, others: usize) {
        self.states += 1;
        self.astray += u64::from(!own);
        self.shared += u64::from(others > usize::from(!own));
    }

    /// Takes in a proposal that left its stratum: the number of strata that it is in, and whether its importance is positive.
    pub(super) fn add_stray(&mut self, strata: usize, lit: bool) {
        self.states += 1;
        self.uncovered += u64::from(strata == 0 && lit);
        self.shared += u64::from(strata > 1);
    }

    /// Adds others.
    pub(super) fn merge(&mut self, other: &Self) {
        add_count(&mut self.states, other.states);
        add_count(&mut self.astray, other.astray);
        add_count(&mut self.uncovered, other.uncovered);
        add_count(&mut self.shared, other.shared);
    }
}
