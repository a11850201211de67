//! Deposits of one task, kept apart until they are merged into the film.

use super::Splat;
use super::count::add_count;

/// Takes splats.
pub trait Sink<S> {
    /// Adds `weight` × splat.
    fn deposit(&mut self, splat: S, weight: f64);
}

/// A weighted splat on its way to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deposit<const C: usize> {
    /// Index of the film's site.
    pub site: u32,
    /// Value for the site, one number a channel.
    pub value: [f32; C],
}

/// Deposits with a site outside the film or a value that is not finite, which are left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lost {
    /// How many.
    pub count: u64,
    /// The first few of the film's sites that they would have gone to, in order.
    pub sites: Vec<u32>,
}

impl Lost {
    /// Most sites that are kept.
    const SITES: usize = 8;

    fn add(&mut self, site: u32, sites: u32) {
        self.count += 1;
        if site < sites {
            self.keep(site);
        }
    }

    /// Adds others; the outcome does not depend on the order.
    pub(super) fn merge(&mut self, other: &Self) {
        add_count(&mut self.count, other.count);
        other.sites.iter().for_each(|&site| self.keep(site));
    }

    fn keep(&mut self, site: u32) {
        if let Err(at) = self.sites.binary_search(&site) {
            self.sites.insert(at, site);
            self.sites.truncate(Self::SITES);
        }
    }
}

/// The deposits of one task in the order in which they were made.
///
/// Before they go to the film they are sorted into bands of consecutive sites, which threads merge independently; each is small enough for a
/// cache. A list of deposits, unlike a film of its own for each chain, takes memory in proportion to the task's length whatever the size
/// of the film.
#[derive(Clone, Debug)]
pub struct Deposits<const C: usize> {
    list: Vec<Deposit<C>>,
    /// Where the deposits of each band end in the list, once it is sorted.
    ends: Vec<u32>,
    sites: u32,
    shift: u32,
    lost: Lost,
}

impl<const C: usize> Deposits<C> {
    /// No deposits, for a film of `sites` sites cut into bands of 2^`shift`.
    pub(crate) fn new(sites: u32, shift: u32) -> Self {
        let bands = (sites as usize).div_ceil(1 << shift).max(1);
        Self { list: Vec::new(), ends: vec![0; bands], sites, shift, lost: Lost::default() }
    }

    /// Forgets the deposits and keeps the memory.
    pub fn clear(&mut self) {
        self.list.clear();
        self.lost = Lost::default();
    }

    /// Sorts the deposits into bands, in each of which they keep their order; `other` is scratch.
    pub(super) fn sort(&mut self, other: &mut Vec<Deposit<C>>) {
        let band = |deposit: &Deposit<C>| (deposit.site >> self.shift) as usize;
        self.ends.fill(0);
        self.list.iter().for_each(|deposit| self.ends[band(deposit)] += 1);
        let mut next = 0;
        for end in &mut self.ends {
            next += std::mem::replace(end, next);
        }
        other.clone_from(&self.list);
        for deposit in &self.list {
            let place = &mut self.ends[band(deposit)];
            other[*place as usize] = *deposit;
            *place += 1;
        }
        std::mem::swap(&mut self.list, other);
    }

    /// Sites and the sums, over deposits and channels, that they get; in the order of the sites.
    pub(super) fn sums(&self) -> Vec<(u32, f64)> {
        let sum = |deposit: &Deposit<C>| (deposit.site, deposit.value.iter().map(|&v| f64::from(v)).sum());
        let mut list: Vec<(u32, f64)> = self.list.iter().map(sum).collect();
        list.sort_by_key(|&(site, _)| site);
        list.dedup_by(|later, first| {
            let same = later.0 == first.0;
            first.1 += if same { later.1 } else { 0.0 };
            same
        });
        list
    }

    /// All of them.
    #[cfg(test)]
    pub(crate) fn list(&self) -> &[Deposit<C>] {
        &self.list
    }

    /// Those of a band, once they are sorted.
    pub(super) fn band(&self, band: usize) -> &[Deposit<C>] {
        let first = band.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.list[first as usize..self.ends[band] as usize]
    }

    /// Deposits that were left out.
    pub fn lost(&self) -> &Lost {
        &self.lost
    }
}

impl<const C: usize> Sink<Splat<C>> for Deposits<C> {
    #[inline]
    fn deposit(&mut self, splat: Splat<C>, weight: f64) {
        let value = splat.value.map(|v| (v * weight) as f32);
        if splat.site >= self.sites || value.iter().any(|v| !v.is_finite()) {
            self.lost.add(splat.site, self.sites);
            return;
        }
        self.list.push(Deposit { site: splat.site, value });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_keep_the_order_of_their_deposits() {
        let mut deposits = Deposits::<1>::new(64, 4);
        for i in 0..200 {
            deposits.deposit(Splat { site: (i * 37) % 64, value: [1.0] }, f64::from(i));
        }
        let before = deposits.list().to_vec();
        deposits.sort(&mut Vec::new());
        for band in 0..4 {
            let own = before.iter().filter(|deposit| deposit.site as usize / 16 == band);
            assert!(deposits.band(band).iter().eq(own), "{band}");
        }
    }
}
