//! Findings of pilots, as bytes.

use crate::engine::{DecodeError, LEAST_SAMPLES, Reader, Share, put, put_list};

/// Mutations of a round that are read, at most, over those that were asked for. Those of `auto` are of less work than its samples.
const MOST_MUTATIONS: f64 = 4096.0;

/// Appends shares of a round.
pub(super) fn put_shares(to: &mut Vec<u8>, shares: &[Share]) {
    put_list(to, shares, |to, share| [share.mutations, share.samples].into_iter().for_each(|count| put(to, count)));
}

/// Reads shares of a round for which about so many mutations are asked for. What no pilot shares out is refused: it would take more memory
/// than a round may.
pub(super) fn read_shares(mutations: f64, from: &mut Reader) -> Result<Vec<Share>, DecodeError> {
    let shares = from.list(read_share)?;
    let sum = |count: fn(&Share) -> u64| shares.iter().map(count).fold(0, u64::saturating_add);
    let least = 2 * LEAST_SAMPLES * shares.len() as u64;
    let most = sum(|share| share.mutations);
    let in_bounds =
        most as f64 <= MOST_MUTATIONS * (mutations + least as f64) && sum(|share| share.samples) <= most / 2 + least;
    if in_bounds { Ok(shares) } else { Err(DecodeError::Damaged) }
}

fn read_share(from: &mut Reader) -> Result<Share, DecodeError> {
    match [from.number()?, from.number()?] {
        [0, _] | [_, 0] => Err(DecodeError::Damaged),
        [mutations, samples] => Ok(Share { mutations, samples }),
    }
}
