//! Large and small steps.

use super::{PrimaryPath, PrimaryStratum, StepSize, Tracer};
use crate::engine::Mutation;
use rand_pcg::rand_core::Rng;

/// All numbers afresh: T(x→y) = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargeStep {
    /// Relative weight in a mixture.
    pub weight: f64,
}

/// Each number u becomes u + d mod 1, with |d| log-uniform in (s₁, s₂] and either sign: T(x→y) = T(y→x).
///
/// Numbers beyond those that the current state has are fresh.
///
/// Source: [KelemenSzirmayKalos02], section 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallStep {
    weight: f64,
    size: StepSize,
}

impl SmallStep {
    /// Steps between s₁ = `smallest` and s₂ = `largest`, both in (0, 1/2]; `weight` is relative, in a mixture.
    pub fn new(weight: f64, smallest: f64, largest: f64) -> Self {
        Self { weight, size: StepSize::new(smallest, largest) }
    }
}

/// One of the mutations, chosen without a virtual call.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PrimaryMutation {
    /// All numbers afresh.
    Large(LargeStep),
    /// Each number moved a little.
    Small(SmallStep),
}

impl PrimaryMutation {
    /// Both, the large step with probability `large`; small steps between 1/1024 and 1/64.
    pub fn both(large: f64) -> Vec<Self> {
        let small = SmallStep::new(1.0 - large, 1.0 / 1024.0, 1.0 / 64.0);
        vec![Self::Large(LargeStep { weight: large }), Self::Small(small)]
    }
}

impl<T, const STREAMS: usize> Mutation<PrimaryPath<T::Output, STREAMS>, PrimaryStratum<T>> for PrimaryMutation
where
    T: Tracer<STREAMS>,
{
    fn name(&self) -> &'static str {
        match self {
            Self::Large(_) => "large step",
            Self::Small(_) => "small step",
        }
    }

    #[inline]
    fn suitability(&self, _current: &PrimaryPath<T::Output, STREAMS>) -> f64 {
        match self {
            Self::Large(step) => step.weight,
            Self::Small(step) => step.weight,
        }
    }

    #[inline]
    fn propose(
        &self,
        current: &PrimaryPath<T::Output, STREAMS>,
        proposal: &mut PrimaryPath<T::Output, STREAMS>,
        within: &PrimaryStratum<T>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let near = match self {
            Self::Large(_) => None,
            Self::Small(step) => Some((current, [&step.size; STREAMS])),
        };
        proposal.propose(near, &within.tracer, rng).then_some(1.0)
    }
}
