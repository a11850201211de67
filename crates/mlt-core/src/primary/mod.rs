//! Primary sample space: states are the random numbers that a tracer consumes.
//!
//! A [`Tracer`] turns uniform numbers u ∈ [0, 1)^∞ into deposits F(u), whose integral over u is the image: any renderer
//! that samples is one. A [`PrimaryPath`] is the numbers that the tracer used and what it made of them. Every number is
//! uniform, so densities in this space are 1 and both mutations are symmetric: [`LargeStep`] draws all numbers afresh,
//! [`SmallStep`] moves each a little. The tracer sees its random numbers as generators ([`Stream`]); it needs no change.
//!
//! Strata: each has a tracer of its own, which maps the numbers onto that part of the domain. Nothing that is drawn can
//! leave it; what is met by chance elsewhere, the tracer leaves out of F.
//!
//! Source: [KelemenSzirmayKalos02]; derivations in docs/theory-primary.md.

mod mutation;
mod path;
mod stratum;
mod stream;
#[cfg(test)]
mod tests;
mod tracer;

pub use mutation::{LargeStep, PrimaryMutation, SmallStep};
pub use path::{PrimaryImportance, PrimaryPath};
pub use stratum::PrimaryStratum;
pub use stream::{StepSize, Stream, Streams};
pub use tracer::{Output, Tracer};
