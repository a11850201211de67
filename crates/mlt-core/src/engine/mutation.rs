//! Proposal distributions.

use rand_pcg::rand_core::Rng;

/// One way of proposing a state y from a state x, with density T(x→y), inside a stratum of type `S`.
pub trait Mutation<P, S> {
    /// Name in statistics.
    fn name(&self) -> &'static str;

    /// Relative weight with which a [`Mixture`](super::Mixture) selects this mutation at x; 0 where it does not apply.
    fn suitability(&self, current: &P) -> f64 {
        let _ = current;
        1.0
    }

    /// Writes y ~ T(x→·) over `proposal`, whose former value is arbitrary, and returns T(y→x) / T(x→y).
    ///
    /// `None` is a failed construction and counts as a rejection. `within` is the stratum of the chain: a mutation that
    /// draws afresh what decides the stratum draws it there; any other may leave it and is rejected by the importance.
    fn propose(&self, current: &P, proposal: &mut P, within: &S, rng: &mut impl Rng) -> Option<f64>;
}
