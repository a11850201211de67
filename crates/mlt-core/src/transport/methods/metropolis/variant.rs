//! The chains or mutations that strata restrict.

/// The chains or mutations that a stratum restricts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Variant {
    /// The importance and the bidirectional mutation: I_j is 0 outside Ω_j.
    #[default]
    Stratified,
    /// The bidirectional mutation alone: one chain space Ω, in which the light end is drawn again on the part of the lights
    /// that the current path starts on.
    ///
    /// Source: [Jankauski15], section 6.1.
    MutationOnly,
}
