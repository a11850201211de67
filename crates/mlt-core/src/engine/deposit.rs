//! Deposits of one task, kept apart until they are merged into the film.

use super::Splat;

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
        self.count += other.count;
        other.sites.iter().for_each(|&site| self.keep(site));
    }

    fn keep(&mut self, site: u32) {
        if let Err(at) = self.sites.binary_search(&site) {
            self.sites.insert(at, site);
            self.sites.truncate(Self::SITES);
        }
    }
}

/// The deposits of one task in the order in which they were made, sorted into bands of consecutive sites.
///
/// Bands are what threads merge independently, and each is small enough for a cache. A list of deposits, unlike a film
/// of its own for each chain, takes memory in proportion to the task's length whatever the size of the film.
#[derive(Clone, Debug)]
pub struct Deposits<const C: usize> {
    bands: Vec<Vec<Deposit<C>>>,
    sites: u32,
    shift: u32,
    lost: Lost,
}

impl<const C: usize> Deposits<C> {
    /// No deposits, for a film of `sites` sites cut into bands of 2^`shift`.
    pub(crate) fn new(sites: u32, shift: u32) -> Self {
        let bands = (sites as usize).div_ceil(1 << shift).max(1);
        Self { bands: vec![Vec::new(); bands], sites, shift, lost: Lost::default() }
    }

    /// Forgets the deposits and keeps the memory.
    pub fn clear(&mut self) {
        self.bands.iter_mut().for_each(Vec::clear);
        self.lost = Lost::default();
    }

    /// Sites and the sums, over deposits and channels, that they get; in the order of the sites.
    pub(super) fn sums(&self) -> Vec<(u32, f64)> {
        let sum = |deposit: &Deposit<C>| (deposit.site, deposit.value.iter().map(|&v| f64::from(v)).sum());
        let mut list: Vec<(u32, f64)> = self.bands.iter().flatten().map(sum).collect();
        list.sort_by_key(|&(site, _)| site);
        list.dedup_by(|later, first| {
            let same = later.0 == first.0;
            first.1 += if same { later.1 } else { 0.0 };
            same
        });
        list
    }

    pub(crate) fn band(&self, band: usize) -> &[Deposit<C>] {
        &self.bands[band]
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
        self.bands[(splat.site >> self.shift) as usize].push(Deposit { site: splat.site, value });
    }
}
