//! Features of what each pixel shows, beside its radiance: for compositing and for denoisers.
//!
//! They are found by camera rays alone, whatever the method: the same bits for the same view, at no cost to a render that does not ask
//! for them. None is NaN or infinite.

mod albedo;
mod strata;
mod surfaces;

pub use strata::strongest_strata;
pub use surfaces::{NOWHERE, SurfaceFeatures, surfaces};
