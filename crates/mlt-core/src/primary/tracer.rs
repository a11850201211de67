//! Tracer: the function of random numbers that primary sample space is built on.

use super::Streams;

/// Result of a tracer for its random numbers.
pub trait Output: Clone + Default {
    /// One deposit.
    type Splat;

    /// I ≥ 0, the scalar that chains sample; it may be 0 only where every deposit is 0.
    fn importance(&self) -> f64;

    /// F(u), one item for each site that is touched.
    fn splats(&self) -> impl Iterator<Item = Self::Splat>;
}

/// A function F of uniform random numbers, with ∫ F(u) du the image.
///
/// A tracer that picks one of P pixels by its numbers deposits P times the radiance that it finds there: each pixel is picked in a
/// P-th of all cases. One that takes the pixel from elsewhere cannot be used, as its chains would never leave it.
///
/// `STREAMS` sequences of numbers are played back independently of each other: parts that use varying amounts of numbers
/// (the two subpaths of a bidirectional sampler) take one each, so that a change in one does not shift the others.
pub trait Tracer<const STREAMS: usize> {
    /// Type of the result.
    type Output: Output;

    /// Writes F(u) over `output`, whose former value is arbitrary; returns false, and leaves it so, where F(u) = 0.
    ///
    /// It has to be a function of the numbers alone, and to depend on no more numbers than it draws.
    fn trace(&self, numbers: &mut Streams<STREAMS>, output: &mut Self::Output) -> bool;
}
