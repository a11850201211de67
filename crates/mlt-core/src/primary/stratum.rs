//! Strata of primary sample space.

use super::{PrimaryPath, Tracer};
use crate::engine::Stratum;
use rand_pcg::rand_core::Rng;

/// Ω_j as the image of all numbers under a tracer of its own.
///
/// Every state is inside: what a tracer draws, it maps onto its part, and what it meets outside it leaves out of F.
#[derive(Clone, Copy, Debug)]
pub struct PrimaryStratum<T> {
    /// F on Ω_j.
    pub tracer: T,
    /// First estimate of b_j, up to a factor common to all strata.
    pub power: f64,
}

impl<T: Tracer<STREAMS>, const STREAMS: usize> Stratum<PrimaryPath<T::Output, STREAMS>> for PrimaryStratum<T> {
    const OF_ONE_SPACE: bool = false;

    fn contains(&self, _path: &PrimaryPath<T::Output, STREAMS>) -> bool {
        true
    }

    /// Fresh numbers; their density is 1.
    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&PrimaryPath<T::Output, STREAMS>, f64)) {
        let mut path = PrimaryPath::default();
        if path.propose(None, &self.tracer, rng) {
            visit(&path, 1.0);
        }
    }

    fn density(&self, _path: &PrimaryPath<T::Output, STREAMS>) -> f64 {
        1.0
    }

    fn power(&self) -> f64 {
        self.power
    }
}
