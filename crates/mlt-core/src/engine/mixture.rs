//! State-dependent mixture of mutations.

use super::{Mutation, uniform};
use rand_pcg::rand_core::Rng;
use std::marker::PhantomData;

/// Mutations of one type, chosen by suitability: p_m(x) = s_m(x) / Σ_n s_n(x).
///
/// Mutations of different kinds are variants of one enum, so that a proposal costs a branch and no virtual call.
#[derive(Debug)]
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

    /// s_m(x) of each mutation.
    pub(super) fn suitabilities(&self, path: &P) -> Suitabilities {
        let mut suitabilities = Suitabilities { each: vec![0.0; self.mutations.len()], total: 0.0 };
        self.weigh(path, &mut suitabilities);
        suitabilities
    }

    /// Writes s_m(x) of each mutation.
    #[inline]
    pub(super) fn weigh(&self, path: &P, into: &mut Suitabilities) {
        into.total = 0.0;
        for (mutation, each) in self.mutations.iter().zip(&mut into.each) {
            *each = mutation.suitability(path);
            into.total += *each;
        }
    }
}

/// s_m(x) of all mutations at one state.
#[derive(Debug)]
pub(super) struct Suitabilities {
    pub(super) each: Vec<f64>,
    /// Σ_n s_n(x).
    pub(super) total: f64,
}

impl Suitabilities {
    /// Draws m with probability p_m(x). `None` where no mutation applies.
    #[inline]
    pub(super) fn choose(&self, rng: &mut impl Rng) -> Option<usize> {
        let mut remaining = uniform(rng) * self.total;
        self.each.iter().position(|&suitability| {
            let chosen = remaining < suitability;
            remaining -= suitability;
            chosen
        })
    }
}
