//! Stratified Metropolis sampling over an arbitrary state space.
//!
//! A user brings a [`Path`] (a state and what it deposits), an [`Importance`], one or more [`Mutation`]s and the
//! [`Stratum`]s that the state space is cut into. The engine estimates, for every site p of a film,
//!
//! image(p) = Σ_j b_j · E_{x ~ I/b_j on Ω_j} [ h_p(x) f(x) / I(x) ]
//!
//! as a mean over independent rounds ([`render`]), each of which is one unbiased estimate of the whole image
//! ([`Metropolis`]). It names no vector type and no scene.

mod accumulated;
mod agreement;
mod allocation;
mod band;
mod blocks;
mod bootstrap;
mod bytes;
mod chain;
mod count;
mod coverage;
mod deposit;
mod ending;
mod error;
mod estimator;
mod exact;
mod film;
mod fixed;
mod importance;
mod key;
mod merge;
mod metropolis;
mod mixture;
mod mutation;
mod packed;
mod path;
mod pilot;
mod pixel;
mod rarity;
mod rounds;
#[cfg(feature = "checkpoints")]
mod sealed;
mod share;
mod stats;
mod stratum;
mod sum;
mod tally;
mod warning;
mod watch;

pub use accumulated::{Accumulated, Key, key_difference, put_key, read_key};
pub use agreement::HalfChains;
pub use allocation::{LEAST_CHAIN, LEAST_SAMPLES, MUTATIONS_PER_SAMPLE, allocate, shares_by_power};
pub use blocks::{Blocks, Grid};
pub use bytes::{Counted, DecodeError, Reader, put, put_chunk, put_list, put_text};
pub use chain::Chain;
pub use count::{add_count, total_count};
pub use coverage::Coverage;
pub use deposit::{Deposit, Deposits, Lost, Sink};
pub use ending::{Ending, Limits, Make, Standing, TRUSTED_ROUNDS};
pub use estimator::{Estimator, Observer, Outcome, Progress, batch_size, render, rounds_in_flight};
pub use exact::ExactSum;
pub use film::Film;
pub use importance::Importance;
pub use key::{Generator, Purpose, generator, mixed, uniform, uniform_f32};
pub use merge::MergeError;
pub use metropolis::{CHAIN_LENGTH, Metropolis};
pub use mixture::Mixture;
pub use mutation::Mutation;
pub use path::{Path, Splat};
pub use pilot::{Measure, PILOT, Piloted, events};
pub use pixel::Pixel;
pub use rarity::Rarity;
pub use rounds::Rounds;
#[cfg(feature = "checkpoints")]
pub use sealed::{sealed, unsealed};
pub use share::{SetupError, Share, with_shares};
pub use stats::{MutationStats, StratumStats};
pub use stratum::Stratum;
pub use sum::{Either, Sum, SumTally};
pub use tally::Tally;
pub use warning::{Warning, WarningKind};
pub use watch::Watch;
