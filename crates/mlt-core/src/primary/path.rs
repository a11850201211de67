//! States in primary sample space.

use super::stream::Change;
use super::{Output, Stream, Tracer};
use crate::engine::{Importance, Path};
use rand_pcg::rand_core::Rng;
use std::array;

/// The numbers that a tracer used, and its output.
#[derive(Debug)]
pub struct PrimaryPath<O, const STREAMS: usize> {
    numbers: [Vec<u32>; STREAMS],
    output: O,
}

impl<O: Default, const STREAMS: usize> Default for PrimaryPath<O, STREAMS> {
    fn default() -> Self {
        Self { numbers: array::from_fn(|_| Vec::new()), output: O::default() }
    }
}

impl<O: Clone, const STREAMS: usize> Clone for PrimaryPath<O, STREAMS> {
    fn clone(&self) -> Self {
        Self { numbers: self.numbers.clone(), output: self.output.clone() }
    }

    /// Copies without giving up the memory of `self`.
    fn clone_from(&mut self, source: &Self) {
        self.numbers.iter_mut().zip(&source.numbers).for_each(|(to, from)| to.clone_from(from));
        self.output.clone_from(&source.output);
    }
}

impl<O: Output, const STREAMS: usize> PrimaryPath<O, STREAMS> {
    /// The numbers of each stream, u·2³², as far as the tracer used them.
    pub fn numbers(&self) -> &[Vec<u32>; STREAMS] {
        &self.numbers
    }

    /// What the tracer made of them.
    pub fn output(&self) -> &O {
        &self.output
    }

    /// Traces numbers that follow from those of `current`, and records them; false where F = 0.
    #[inline]
    pub(super) fn trace(
        &mut self,
        current: Option<&Self>,
        change: Change,
        tracer: &impl Tracer<STREAMS, Output = O>,
        rng: &mut impl Rng,
    ) -> bool {
        let mut index = 0;
        let mut streams = self.numbers.each_mut().map(|to| {
            let from = current.map_or(&[][..], |path| &path.numbers[index]);
            index += 1;
            Stream::new(from, to, change, rng.next_u64())
        });
        tracer.trace(&mut streams, &mut self.output)
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
