//! Proofs by statistics: methods agree with integrals, with each other and with another renderer, on any number of threads.

mod agreement;
mod analytic;
mod auto;
mod cameras;
mod copies;
mod determinism;
mod duct;
mod primary;
mod punctual;
mod startup_bias;
mod strata;
mod support;
