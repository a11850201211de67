//! Stratified Metropolis light transport.
//!
//! The state space Ω (all light paths, say) is cut into strata Ω_1 … Ω_K. With a contribution f, an importance I ≥ 0, the
//! filter h_p of site p, and b_j = ∫_{Ω_j} I, the film is estimated as
//!
//! ```text
//! image(p) = ∫ h_p f = Σ_j b_j · E_{x ~ I/b_j on Ω_j} [ h_p(x) f(x) / I(x) ]
//! b̂_j      = mean importance weight of m_j independent samples of Ω_j
//! x_0      = one of those samples, drawn in proportion to its weight
//! x_{i+1}  = y ~ T(x_i → y) with probability min(1, I_j(y) T(y→x_i) / (I_j(x_i) T(x_i→y))), else x_i
//! round(p) = Σ_j b̂_j / n_j · Σ_i h_p(x_i) f(x_i) / I(x_i),   image = mean of independent rounds
//! ```
//!
//! Every round is unbiased, however short its chains; the scatter of the rounds is the error bar of each pixel.
//!
//! # Modules
//!
//! | module | what it holds |
//! |---|---|
//! | [`check`] | Tests of one's own sampler, strata and mutations. |
//! | [`engine`] | Metropolis sampling of any state space, as traits. It knows no vector, no scene, no light. |
//! | [`measure`] | Measures of the error of an image against a reference. |
//! | [`memory`] | A budget of memory that all who allocate much of it share. |
//! | [`primary`] | States that are the random numbers of any sampler, for the engine. |
//! | `transport` | A renderer that is one user of those traits (feature `transport`, on by default). |
//!
//! The feature `checkpoints`, which `transport` implies, adds sums of rounds as bytes with a checksum.
//!
//! In [`engine`]: what you bring ([`Path`](engine::Path), [`Importance`](engine::Importance),
//! [`Mutation`](engine::Mutation), [`Stratum`](engine::Stratum)), what drives it ([`Metropolis`](engine::Metropolis),
//! [`Mixture`](engine::Mixture), [`render`](engine::render)), and what comes out ([`Film`](engine::Film),
//! [`Tally`](engine::Tally)). Dependencies point one way, from `transport` to `engine`.
//!
//! # A toy
//!
//! ∫ x² over [0, 1) from two strata; the film is a single site.
//!
//! ```
//! use mlt_core::engine::{Accumulated, Film, Metropolis, Mixture, Mutation, Path, Share, Splat, Stratum, render, uniform};
//! use mlt_core::rand_core::Rng;
//! use std::ops::ControlFlow;
//!
//! #[derive(Clone)]
//! struct X(f64);
//!
//! impl Path for X {
//!     type Splat = Splat<1>;
//!     fn splats(&self) -> impl Iterator<Item = Splat<1>> {
//!         std::iter::once(Splat { site: 0, value: [self.0 * self.0] })
//!     }
//! }
//!
//! /// Ω_j = [low, low + ½).
//! struct Half { low: f64 }
//!
//! impl Stratum<X> for Half {
//!     fn contains(&self, x: &X) -> bool {
//!         (self.low..self.low + 0.5).contains(&x.0)
//!     }
//!     fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
//!         visit(&X(self.low + 0.5 * uniform(rng)), 0.5); // uniform in the half: 1/p = ½
//!     }
//!     fn density(&self, _: &X) -> f64 {
//!         2.0
//!     }
//!     fn power(&self) -> f64 {
//!         1.0
//!     }
//! }
//!
//! struct Nudge;
//!
//! impl Mutation<X, Half> for Nudge {
//!     fn name(&self) -> &'static str {
//!         "nudge"
//!     }
//!     fn propose(&self, x: &X, y: &mut X, _: &Half, rng: &mut impl Rng) -> Option<f64> {
//!         y.0 = (x.0 + 0.4 * (uniform(rng) - 0.5)).rem_euclid(1.0);
//!         Some(1.0) // T(y→x) / T(x→y)
//!     }
//! }
//!
//! let share = Share { mutations: 100, samples: 50 };
//! let strata = [(Half { low: 0.0 }, share), (Half { low: 0.5 }, share)];
//! let mixture = Mixture::new(vec![Nudge]);
//! let importance = |x: &X| x.0; // any positive function will do; the better it follows f, the less noise
//! let metropolis = Metropolis::new(&strata, &mixture, &importance, 7)?;
//! let mut sums = Accumulated::new(Film::new(1, 1.0));
//! render(&metropolis, 0..400, &mut sums, &mut |_, _| ControlFlow::Continue(()));
//! let (film, tally) = sums.into_parts();
//! let [pixel] = film.pixel(0);
//! assert!((pixel.mean - 1.0 / 3.0).abs() < 4.0 * pixel.stderr);
//! assert!(pixel.stderr < 0.002);
//! assert!(tally.warnings().is_empty()); // no gap, no overlap, no sampler that gives another sample the second time
//! # Ok::<(), mlt_core::engine::SetupError>(())
//! ```
//!
//! # Speed
//!
//! A program that renders is fastest with this in its own Cargo.toml, since profiles of dependencies are not inherited: the hot loops
//! are in this crate, and what is cut apart is not inlined as well.
//!
//! ```toml
//! [profile.release.package.mlt-core]
//! codegen-units = 1
//! ```

pub mod check;
pub mod engine;
mod instructions;
pub mod measure;
pub mod memory;
pub mod primary;
#[cfg(feature = "transport")]
pub mod transport;

/// Vectors, in the version that the renderer's signatures name.
#[cfg(feature = "transport")]
pub use glam;
/// The trait of random generators that the engine's signatures name.
pub use rand_pcg::rand_core;
