//! Arrays over the pixels of an image.

mod blur;
mod error;
mod importance;
mod weights;

pub(crate) use blur::blurred;
pub use error::{luminance_and_error, mean_luminance, relative_error};
pub use importance::{PixelImportance, Target};
pub(crate) use weights::error_weights;
