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
//! ```
//! use mlt_core::engine::{Accumulated, Film, Metropolis, Mixture, Share, Splat, render, uniform};
//! use mlt_core::primary::{Output, PrimaryImportance, PrimaryMutation, PrimaryStratum, Streams, Tracer};
//! use std::ops::ControlFlow;
//!
//! /// Result of the tracer: a pixel of two, and 2 (the number of pixels) × the radiance there.
//! #[derive(Clone, Default)]
//! struct Seen { pixel: u32, value: f64 }
//!
//! impl Output for Seen {
//!     type Splat = Splat<1>;
//!     fn importance(&self) -> f64 {
//!         self.value
//!     }
//!     fn splats(&self) -> impl Iterator<Item = Splat<1>> {
//!         std::iter::once(Splat { site: self.pixel, value: [self.value] })
//!     }
//! }
//!
//! /// Radiance u² at pixel ⌊2v⌋, the mean of which is ⅓.
//! struct Squares;
//!
//! impl Tracer<1> for Squares {
//!     type Output = Seen;
//!     fn trace(&self, [numbers]: &mut Streams<1>, seen: &mut Seen) -> bool {
//!         seen.pixel = (2.0 * uniform(numbers)) as u32;
//!         seen.value = 2.0 * uniform(numbers).powi(2);
//!         seen.value > 0.0
//!     }
//! }
//!
//! let strata = [(PrimaryStratum { tracer: Squares, power: 1.0 }, Share { mutations: 1000, samples: 250 })];
//! let mixture = Mixture::new(PrimaryMutation::both(0.3));
//! let metropolis = Metropolis::new(&strata, &mixture, &PrimaryImportance, 1)?;
//! let mut sums = Accumulated::new(Film::new(2, 1.0));
//! render(&metropolis, 0..100, &mut sums, &mut |_, _| ControlFlow::Continue(()));
//! let (film, tally) = sums.into_parts();
//! let [pixel] = film.pixel(0);
//! assert!((pixel.mean - 1.0 / 3.0).abs() < 4.0 * pixel.stderr && pixel.stderr < 0.01);
//! # Ok::<(), mlt_core::engine::SetupError>(())
//! ```
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
