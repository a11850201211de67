//! How light transport is computed.

mod adapt;
pub mod auto;
mod bidirectional;
mod counts;
mod film_unit;
mod found;
mod independent;
pub mod metropolis;
mod path_tracing;
pub mod primary;
mod run;
mod samples;
mod settings;
mod sobol;
mod target;

pub use bidirectional::{Bidirectional, BidirectionalTracing};
pub use counts::{Counts, PilotCounts};
pub use film_unit::{film_of, film_unit};
pub(crate) use independent::point_in_pixel;
pub use independent::{AllPaths, ImageSampler, Independent, SampleTally, Selection};
pub use path_tracing::{PathTracer, PathTracing};
pub use run::{Observer, Run, Sums};
pub use settings::{MOST_EDGES, Method, Settings};
pub use sobol::OwenSobol;
