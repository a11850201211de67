//! One call of a render: rounds added to its film and its counts.

use super::counts::{Counts, PilotCounts};
use super::independent::{ImageSampler, Independent, SampleTally, Selection};
use crate::engine::{
    self, Estimator, Film, Importance, Metropolis, Mixture, Mutation, Outcome, Path, Progress, Share, Splat, Stratum,
    Sum, SumTally,
};
use crate::transport::scene::rays_traced;
use std::ops::{ControlFlow, Range};

/// Called with the state of a render; it breaks to stop it.
pub type Observer<'a> = dyn FnMut(Progress, &Film<3>) -> ControlFlow<()> + 'a;

/// Rounds of one call of a render, and where they are added.
pub struct Run<'r, 'o> {
    /// The rounds, by their numbers.
    pub rounds: Range<u64>,
    /// The film that the rounds are added to.
    pub film: &'r mut Film<3>,
    /// The counts that theirs are added to.
    pub counts: &'r mut Counts,
    /// Told of every round.
    pub observe: &'r mut Observer<'o>,
}

impl Run<'_, '_> {
    /// The same after a pilot.
    pub(super) fn after(self, pilot: PilotCounts) -> Self {
        (self.counts.pilot_mutations, self.counts.pilot_rays) = (pilot.mutations, pilot.rays);
        self
    }

    /// Runs chains.
    pub(super) fn metropolis<P, S, M, I>(self, estimator: &Metropolis<P, S, M, I>) -> Outcome
    where
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
    {
        let counts = self.counts;
        let outcome = repeat(estimator, self.rounds, self.film, &mut counts.chains, self.observe);
        counts.rays = counts.chains.work();
        outcome
    }

    /// Takes independent samples.
    pub(super) fn independent<T: ImageSampler>(self, estimator: &Independent<T>) -> Outcome {
        let counts = self.counts;
        let mut tally = SampleTally { samples: counts.samples, rays: counts.rays };
        let outcome = repeat(estimator, self.rounds, self.film, &mut tally, self.observe);
        (counts.samples, counts.rays) = (tally.samples, tally.rays);
        outcome
    }

    /// Takes independent samples of some paths, and runs chains over the others.
    pub(super) fn mixture<T, A, P, S, M, I>(self, samples: Independent<T, A>, chains: Metropolis<P, S, M, I>) -> Outcome
    where
        T: ImageSampler,
        A: Selection,
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
    {
        let counts = self.counts;
        let tally = std::mem::take(&mut counts.chains);
        let chain_rays = tally.work();
        let mut tally = SumTally(SampleTally { samples: counts.samples, rays: counts.rays - chain_rays }, tally);
        let outcome = repeat(&Sum(samples, chains.partial()), self.rounds, self.film, &mut tally, self.observe);
        let SumTally(samples, tally) = tally;
        (counts.samples, counts.rays) = (samples.samples, samples.rays + tally.work());
        counts.chains = tally;
        outcome
    }
}

/// Chains that count rays, in strata whose shares are at least one mutation and one sample.
pub(super) fn metropolis<'s, P, S, M, I>(
    strata: &'s [(S, Share)],
    mixture: &'s Mixture<P, S, M>,
    importance: &'s I,
    seed: u64,
) -> Metropolis<'s, P, S, M, I> {
    let chains = Metropolis::new(strata, mixture, importance, seed);
    chains.expect("every plan has strata, none of which gets nothing").counting(rays_traced)
}

fn repeat<E: Estimator<3>>(
    estimator: &E,
    rounds: Range<u64>,
    film: &mut Film<3>,
    tally: &mut E::Tally,
    observe: &mut Observer,
) -> Outcome {
    engine::render(estimator, rounds, film, tally, &mut |progress, film, _| observe(progress, film))
}
