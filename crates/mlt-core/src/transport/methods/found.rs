//! Findings of pilots, and their bytes.

use super::adapt::Adapted;
use super::counts::PilotCounts;
use super::settings::Settings;
use crate::engine::{Counted, DecodeError, LEAST_SAMPLES, Reader, Share, put, put_list};
use crate::transport::lights::LightStrata;
use crate::transport::scene::View;

/// Findings of a pilot of chains.
#[derive(Debug)]
pub(super) struct Found {
    /// Parts of the lights.
    pub(super) strata: LightStrata,
    /// Shares of a round, by strata.
    pub(super) shares: Vec<Share>,
    /// Cost of the pilot.
    pub(super) pilot: PilotCounts,
}

impl Found {
    /// The strata and shares that a pilot adapted; where it fitted no shares, those that `by_power` gives, with the rays that this took.
    /// Nothing if that is stopped.
    pub(super) fn new(
        adapted: Adapted,
        by_power: impl FnOnce(&LightStrata) -> Option<(Vec<Share>, u64)>,
    ) -> Option<Self> {
        let Adapted { strata, shares, tally } = adapted;
        let (shares, rays) = match shares {
            Some(shares) => (shares, 0),
            None => by_power(&strata)?,
        };
        Some(Self { strata, shares, pilot: PilotCounts::of(&tally) + PilotCounts { mutations: 0, rays } })
    }

    /// Appends them to bytes.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        self.strata.write(to);
        put_shares(to, &self.shares);
        self.pilot.write(to);
    }

    /// Reads what [`write`](Self::write) has written.
    pub(super) fn read(view: View, settings: &Settings, from: &mut Reader) -> Result<Self, DecodeError> {
        let strata = LightStrata::read(view.scene.lights(), from)?;
        let shares = read_shares([settings.mutations_per_round(view), 0.0], from)?;
        Ok(Self { strata, shares, pilot: PilotCounts::read(from)? })
    }
}

/// Mutations of a round that are read, at most, over those that were asked for. Those of `auto` are of less work than its samples.
const MOST_MUTATIONS: f64 = 4096.0;

/// Appends shares of a round.
pub(super) fn put_shares(to: &mut Vec<u8>, shares: &[Share]) {
    put_list(to, shares, |to, share| [share.mutations, share.samples].into_iter().for_each(|count| put(to, count)));
}

/// Reads shares of a round for which about so many mutations are asked for, and so many samples at most beside those of an ordinary share. What
/// no pilot shares out is refused: it would take more memory than a round may.
pub(super) fn read_shares([mutations, samples]: [f64; 2], from: &mut Reader) -> Result<Vec<Share>, DecodeError> {
    let shares = from.list(read_share)?;
    let sum = |count: fn(&Share) -> u64| shares.iter().map(count).fold(0, u64::saturating_add) as f64;
    let least = (2 * LEAST_SAMPLES * shares.len() as u64) as f64;
    let most = sum(|share| share.mutations);
    let in_bounds =
        most <= MOST_MUTATIONS * (mutations + least) && sum(|share| share.samples) <= most / 2.0 + least + samples;
    if in_bounds { Ok(shares) } else { Err(DecodeError::Damaged) }
}

fn read_share(from: &mut Reader) -> Result<Share, DecodeError> {
    match [from.number()?, from.number()?] {
        [0, _] | [_, 0] => Err(DecodeError::Damaged),
        [mutations, samples] => Ok(Share { mutations, samples }),
    }
}
