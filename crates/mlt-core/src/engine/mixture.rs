//! State-dependent mixture of mutations.

use super::{Mutation, uniform};
use rand_pcg::rand_core::Rng;
use std::marker::PhantomData;

/// Mutations of one type, chosen by suitability: p_m(x) = s_m(x) / Σ_n s_n(x).
///
/// Mutations of different kinds are variants of one enum, so that a proposal costs a branch and no virtual call.
pub struct Mixture<P, S, M> {
    mutations: Vec<M>,
    marker: PhantomData<fn(&P, &S)>,
}

impl<P, S, M: Mutation<P, S>> Mixture<P, S, M> {
    /// A mixture of `mutations`; what does not apply anywhere in a problem is best left out.
    pub fn new(mutations: Vec<M>) -> Self {
        Self { mutations, marker: PhantomData }
    }

    /// The mutations, in the order of every list of statistics.
    pub fn mutations(&self) -> &[M] {
        &self.mutations
    }

    /// Draws m with probability p_m(x); returns it with s_m(x). `total`: Σ_n s_n(x). `None` where no mutation applies.
    #[inline]
    pub(super) fn select(&self, path: &P, total: f64, rng: &mut impl Rng) -> Option<(usize, f64)> {
        let mut remaining = uniform(rng) * total;
        for (m, mutation) in self.mutations.iter().enumerate() {
            let suitability = mutation.suitability(path);
            if remaining < suitability {
                return Some((m, suitability));
            }
            remaining -= suitability;
        }
        None
    }

    /// Σ_n s_n(x).
    #[inline]
    pub(super) fn total(&self, path: &P) -> f64 {
        self.mutations.iter().map(|m| m.suitability(path)).sum()
    }
}
