//! Stratified Metropolis light transport.
//!
//! The crate has two layers, and dependencies point one way, from the second to the first:
//!
//! * [`engine`]: Metropolis sampling of any state space cut into strata, as traits;
//! * [`transport`]: a renderer that is one user of those traits (feature `transport`).

pub mod engine;
pub mod measure;
#[cfg(feature = "transport")]
pub mod transport;
