//! Stratified Metropolis light transport in path space.

pub(crate) mod adapt;
pub mod mutate;
mod stratum;

pub use adapt::{Adaptation, Weights};
pub use mutate::{PathMutation, Perturbations};
pub use stratum::{LightStratum, Variant};
