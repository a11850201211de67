//! Cells of a partition of the state space.

use rand_pcg::rand_core::Rng;

/// Ω_j: the strata given to one render are disjoint and cover every state of positive importance.
pub trait Stratum<P> {
    /// Whether all strata of this type are parts of one space, so that any of them can be asked about a state of any other;
    /// `false` where each is a space of its own. What a render finds of gaps and overlaps, it finds by asking.
    const OF_ONE_SPACE: bool = true;

    /// Whether x ∈ Ω_j.
    fn contains(&self, path: &P) -> bool;

    /// Draws one independent sample and shows each state it consists of to `visit`, with that state's weight w(x)/p(x).
    ///
    /// A sample may be several states (all the connections of two subpaths) or none. The weights are right if
    /// E[Σ w/p · g(x)] = ∫_{Ω_j} g for every g; states outside Ω_j are not shown.
    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&P, f64));

    /// Expected number of times that one sample shows x, relative to the measure of the weights' densities: Σ_s p_s(x) over the ways
    /// s in which it can. Roulette may be left out. No estimate depends on it: it is there to warn of states that samples hardly ever
    /// show. The default, infinite, warns of none.
    fn density(&self, _path: &P) -> f64 {
        f64::INFINITY
    }

    /// First estimate of b_j, up to a factor common to all strata.
    fn power(&self) -> f64;
}
