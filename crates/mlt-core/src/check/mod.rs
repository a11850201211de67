//! Tests of one's own sampler, partition and mutations.
//!
//! Each takes what a render would take, tries it many times, and reports which law is broken, if any:
//!
//! | function | laws |
//! |---|---|
//! | [`strata`] | samples repeat and lie in their stratum; strata are disjoint, cover the space, and estimate their integrals |
//! | [`mutation`] | ratios of densities there and back are inverse; chains keep the target; nothing is left over in a proposal |
//! | [`tracer`] | a [`Tracer`](crate::primary::Tracer) is a function of its numbers; it overwrites its output; I = 0 where F = 0 |
//!
//! A law about expectations is tested by z, corrected for the number of tests ([`SIGNIFICANCE`]); a law about single states is broken
//! by one state.
//!
//! ```
//! use mlt_core::check::{self, Law, Trials};
//! use mlt_core::engine::{Stratum, uniform};
//! use mlt_core::rand_core::Rng;
//!
//! /// [low, high).
//! struct Cell { low: f64, high: f64 }
//!
//! impl Stratum<f64> for Cell {
//!     fn contains(&self, x: &f64) -> bool {
//!         (self.low..self.high).contains(x)
//!     }
//!     fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&f64, f64)) {
//!         let width = self.high - self.low;
//!         visit(&(self.low + width * uniform(rng)), width);
//!     }
//!     fn density(&self, _: &f64) -> f64 {
//!         1.0 / (self.high - self.low)
//!     }
//!     fn power(&self) -> f64 {
//!         1.0
//!     }
//! }
//!
//! let cells = |cuts: [f64; 4]| [Cell { low: cuts[0], high: cuts[1] }, Cell { low: cuts[2], high: cuts[3] }];
//! let whole = Cell { low: 0.0, high: 1.0 };
//! let trials = Trials { count: 4000, seed: 1 };
//! let report = |cuts| check::strata(&cells(cuts), &whole, &|x: &f64| 1.0 + x, trials);
//! assert!(report([0.0, 0.3, 0.3, 1.0]).is_sound());
//! assert!(report([0.0, 0.3, 0.4, 1.0]).breaks(Law::Covered));
//! assert!(report([0.0, 0.5, 0.4, 1.0]).breaks(Law::Disjoint));
//! ```

mod mutation;
mod report;
mod strata;
mod tracer;
mod trial;

pub use mutation::mutation;
pub use report::{Finding, Law, Report};
pub use strata::strata;
pub use tracer::tracer;
pub use trial::{SIGNIFICANCE, Trials};
