//! Parts of the lights: what strata are cut from, and what points are drawn on.

mod cell;
mod cut;
mod region;
mod sampler;
mod strata;

pub use cell::Cell;
pub use cut::{LightTree, MOST_HALVINGS, Node};
pub use region::LightRegion;
pub use sampler::{LightSampler, Receiver};
pub use strata::{LightStrata, Stratification};
