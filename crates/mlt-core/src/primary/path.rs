//! States in primary sample space.

use super::{Output, StepSize, Stream, Streams, Tracer};
use crate::engine::{Importance, Path};
use rand_pcg::rand_core::Rng;
use std::array;

/// The numbers that a tracer used, and its output.
#[derive(Debug)]
pub struct PrimaryPath<O, const STREAMS: usize> {
    streams: Streams<STREAMS>,
    output: O,
}

impl<O: Default, const STREAMS: usize> Default for PrimaryPath<O, STREAMS> {
    fn default() -> Self {
        Self { streams: array::from_fn(|_| Stream::default()), output: O::default() }
    }
}

impl<O: Clone, const STREAMS: usize> Clone for PrimaryPath<O, STREAMS> {
    fn clone(&self) -> Self {
        Self { streams: self.streams.clone(), output: self.output.clone() }
    }

    /// Copies without giving up the memory of `self`.
    fn clone_from(&mut self, source: &Self) {
        self.streams.clone_from_slice(&source.streams);
        self.output.clone_from(&source.output);
    }
}

impl<O: Output, const STREAMS: usize> PrimaryPath<O, STREAMS> {
    /// The streams of numbers, as far as the tracer used them.
    pub fn streams(&self) -> &Streams<STREAMS> {
        &self.streams
    }

    /// The tracer's result for them.
    pub fn output(&self) -> &O {
        &self.output
    }

    /// Traces fresh numbers, or numbers near those of a state by steps of a size for each stream, and records them; false where
    /// F = 0. Both are symmetric: T(x→y) = T(y→x).
    #[inline]
    pub fn propose(
        &mut self,
        near: Option<(&Self, [&StepSize; STREAMS])>,
        tracer: &impl Tracer<STREAMS, Output = O>,
        rng: &mut impl Rng,
    ) -> bool {
        for (i, stream) in self.streams.iter_mut().enumerate() {
            stream.begin(near.map(|(path, sizes)| (&path.streams[i], sizes[i])), rng.next_u64());
        }
        let lit = tracer.trace(&mut self.streams, &mut self.output);
        self.streams.iter_mut().for_each(Stream::end);
        lit
    }
}

impl<O: Output, const STREAMS: usize> Path for PrimaryPath<O, STREAMS> {
    type Splat = O::Splat;

    fn splats(&self) -> impl Iterator<Item = O::Splat> {
        self.output.splats()
    }
}

/// I(u), as the tracer's output has it.
#[derive(Clone, Copy, Debug, Default)]
pub struct PrimaryImportance;

impl<O: Output, const STREAMS: usize> Importance<PrimaryPath<O, STREAMS>> for PrimaryImportance {
    #[inline]
    fn eval(&self, path: &PrimaryPath<O, STREAMS>) -> f64 {
        path.output.importance()
    }
}
