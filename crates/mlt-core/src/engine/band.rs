//! Sums of neighbouring sites of a film.

use super::fixed::Sums;
use super::packed::Packed;
use super::{DecodeError, Reader};

/// [`Sums`] of each channel of some sites.
#[derive(Clone, Debug)]
pub(super) struct Band<const C: usize> {
    first: Packed,
    second: Packed,
}

impl<const C: usize> Band<C> {
    /// No rounds of so many sites.
    pub(super) fn new(sites: usize) -> Self {
        Self { first: Packed::zeros(sites * C), second: Packed::zeros(sites * C) }
    }

    #[inline]
    pub(super) fn get(&self, site: usize) -> [Sums; C] {
        std::array::from_fn(|c| Sums { first: self.first.get(site * C + c), second: self.second.get(site * C + c) })
    }

    /// Adds to the sums of a channel of a site.
    #[inline]
    pub(super) fn add(&mut self, site: usize, channel: usize, sums: Sums) {
        self.first.add(site * C + channel, sums.first);
        self.second.add(site * C + channel, sums.second);
    }

    /// Adds those of other rounds of the same sites.
    pub(super) fn merge(&mut self, other: &Self) {
        self.first.merge(&other.first);
        self.second.merge(&other.second);
    }

    /// Appends them to bytes: the same bytes for the same sums.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        self.first.write(to);
        self.second.write(to);
    }

    /// Reads what [`write`](Self::write) has written.
    pub(super) fn read(sites: usize, from: &mut Reader) -> Result<Self, DecodeError> {
        Ok(Self { first: Packed::read(sites * C, from)?, second: Packed::read(sites * C, from)? })
    }
}
