//! How light transport is computed.

pub mod auto;
mod bidirectional;
mod connect;
pub(crate) mod counts;
mod independent;
pub mod metropolis;
mod path_tracing;
pub mod primary;
pub(crate) mod samples;
mod settings;
mod sobol;

pub use bidirectional::{Bidirectional, MOST_EDGES};
pub use counts::Counts;
pub use independent::{AllPaths, ImageSampler, Independent, SampleTally, Selection};
pub use path_tracing::PathTracer;
pub use settings::{Method, Settings};
pub use sobol::OwenSobol;
