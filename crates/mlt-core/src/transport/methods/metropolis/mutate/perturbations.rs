//! The choice of perturbations.

/// The perturbations that go with the bidirectional mutation. It goes alone if need be: it reaches every path by itself, and they
/// do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Perturbations {
    /// [`LensPerturbation`](super::LensPerturbation).
    pub lens: bool,
    /// [`MultiChainPerturbation`](super::MultiChainPerturbation).
    pub multi_chain: bool,
    /// [`PivotPerturbation`](super::PivotPerturbation).
    pub pivot: bool,
    /// [`CausticPerturbation`](super::CausticPerturbation).
    pub caustic: bool,
}

impl Perturbations {
    /// None of them.
    pub const NONE: Self = Self { lens: false, multi_chain: false, pivot: false, caustic: false };
    /// All of them.
    pub const ALL: Self = Self { lens: true, multi_chain: true, pivot: true, caustic: true };
}

impl Default for Perturbations {
    fn default() -> Self {
        Self::ALL
    }
}
