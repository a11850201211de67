//! Stratified Metropolis light transport.
//!
//! The crate has layers, and dependencies point one way, upwards in this list:
//!
//! * [`engine`]: Metropolis sampling of any state space cut into strata, as traits;
//! * [`primary`]: states that are the random numbers of any sampler, for the engine;
//! * [`transport`]: a renderer that is one user of those traits (feature `transport`).

pub mod engine;
pub mod measure;
pub mod primary;
#[cfg(feature = "transport")]
pub mod transport;
