//! One call of a render: rounds added to its sums.

use super::counts::{Counts, PilotCounts};
use super::independent::{ImageSampler, Independent, Selection};
use crate::engine::{
    self, Accumulated, Deposits, Estimator, Importance, Metropolis, Mixture, Mutation, Outcome, Path, Share, Splat,
    Stratum, Sum,
};
use crate::transport::scene::rays_traced;
use std::fmt;
use std::ops::Range;

/// Sums of a render's rounds, with what they counted.
pub type Sums = Accumulated<3, Counts>;

/// Called with the state of a render; it breaks to stop it.
pub type Observer<'a> = engine::Observer<'a, 3, Counts>;

/// Rounds of one call of a render, and where they are added.
pub struct Run<'r, 'o> {
    /// The rounds, by their numbers.
    pub rounds: Range<u64>,
    /// The sums that the rounds are added to.
    pub sums: &'r mut Sums,
    /// Told of every round.
    pub observe: &'r mut Observer<'o>,
}

impl fmt::Debug for Run<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Run").field("rounds", &self.rounds).field("sums", &self.sums).finish_non_exhaustive()
    }
}

impl Run<'_, '_> {
    /// Runs chains after a pilot.
    pub(super) fn metropolis<P, S, M, I>(self, chains: &Metropolis<P, S, M, I>, pilot: PilotCounts) -> Outcome
    where
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
    {
        self.of(Counting { estimator: chains, part: |counts| &mut counts.made.1, pilot })
    }

    /// Takes independent samples after a pilot.
    pub(super) fn independent<T: ImageSampler>(self, samples: &Independent<T>, pilot: PilotCounts) -> Outcome {
        self.of(Counting { estimator: samples, part: |counts| &mut counts.made.0, pilot })
    }

    /// Takes independent samples of some paths, and runs chains over the others, after a pilot.
    pub(super) fn mixture<T, A, P, S, M, I>(
        self,
        samples: Independent<T, A>,
        chains: Metropolis<P, S, M, I>,
        pilot: PilotCounts,
    ) -> Outcome
    where
        T: ImageSampler,
        A: Selection,
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
    {
        let estimator = &Sum(samples, chains.partial());
        self.of(Counting { estimator, part: |counts| &mut counts.made, pilot })
    }

    fn of<E: Estimator<3, Tally = Counts>>(self, estimator: E) -> Outcome {
        engine::render(&estimator, self.rounds, self.sums, self.observe)
    }
}

/// An estimator whose counts are a part of a render's.
struct Counting<'e, E: Estimator<3>> {
    estimator: &'e E,
    part: fn(&mut Counts) -> &mut E::Tally,
    pilot: PilotCounts,
}

impl<E: Estimator<3>> Estimator<3> for Counting<'_, E> {
    type Prepared = E::Prepared;
    type Task = E::Task;
    type Tally = Counts;

    fn prepare(&self, round: u64) -> E::Prepared {
        self.estimator.prepare(round)
    }

    fn tasks(&self, prepared: &E::Prepared) -> usize {
        self.estimator.tasks(prepared)
    }

    fn task_deposits(&self) -> usize {
        self.estimator.task_deposits()
    }

    fn run(&self, prepared: &E::Prepared, task: usize, deposits: &mut Deposits<3>) -> E::Task {
        self.estimator.run(prepared, task, deposits)
    }

    fn weight(&self, round: u64) -> u64 {
        self.estimator.weight(round)
    }

    fn tally(&self, total: &mut Counts, prepared: &E::Prepared, tasks: Vec<E::Task>) {
        self.estimator.tally((self.part)(total), prepared, tasks);
    }

    fn tally_round(&self, total: &mut Counts, prepared: &E::Prepared) {
        total.pilot = self.pilot;
        self.estimator.tally_round((self.part)(total), prepared);
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
