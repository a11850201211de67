//! Shares of a round, and what cannot be rendered with.

use std::error::Error;
use std::fmt;

/// A stratum's share of every round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// n_j ≥ 1, mutations of its chains.
    pub mutations: u64,
    /// m_j ≥ 1, independent samples for b̂_j and the chains' starts.
    pub samples: u64,
}

/// Each stratum with its share, in the order of both.
///
/// # Errors
///
/// [`SetupError::Shares`] if there are not as many shares as strata.
pub fn with_shares<S>(strata: Vec<S>, shares: &[Share]) -> Result<Vec<(S, Share)>, SetupError> {
    if strata.len() != shares.len() {
        return Err(SetupError::Shares { strata: strata.len(), shares: shares.len() });
    }
    Ok(strata.into_iter().zip(shares.iter().copied()).collect())
}

/// Why [`Metropolis`](super::Metropolis) cannot estimate an image from given strata.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SetupError {
    /// There is no stratum.
    NoStratum,
    /// There are not as many shares as strata.
    Shares {
        /// Number of strata.
        strata: usize,
        /// Number of shares.
        shares: usize,
    },
    /// A stratum has no mutation in a round.
    NoMutations {
        /// Which one, from 0.
        stratum: usize,
    },
    /// A stratum has no independent sample in a round.
    NoSamples {
        /// Which one, from 0.
        stratum: usize,
    },
}

impl SetupError {
    /// Finds what is wrong with the strata's shares.
    pub(super) fn check(shares: impl ExactSizeIterator<Item = Share>) -> Result<(), Self> {
        if shares.len() == 0 {
            return Err(Self::NoStratum);
        }
        for (stratum, share) in shares.enumerate() {
            if share.mutations == 0 {
                return Err(Self::NoMutations { stratum });
            }
            if share.samples == 0 {
                return Err(Self::NoSamples { stratum });
            }
        }
        Ok(())
    }
}

impl Error for SetupError {}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStratum => write!(f, "there is no stratum; one that contains every state leaves the space uncut"),
            Self::Shares { strata, shares } => {
                write!(f, "there are {strata} strata and {shares} shares; give each stratum a share of its own")
            }
            Self::NoMutations { stratum } => write!(
                f,
                "stratum {stratum} has no mutation in a round, so its part of the image would be missing; give it one or more"
            ),
            Self::NoSamples { stratum } => write!(
                f,
                "stratum {stratum} has no independent sample in a round, so its chains could not start; give it one or more"
            ),
        }
    }
}
