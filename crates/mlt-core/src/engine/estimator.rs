//! What is repeated in rounds, and the loop that repeats it.

use super::{Deposits, Film};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Deposits that may wait for their merge, bytes.
const WAITING_DEPOSITS: usize = 8 << 20;

/// An unbiased estimator of the whole film that can be repeated independently.
///
/// A round is cut into tasks. What a task deposits depends on the round's and the task's number alone, and tasks are
/// merged in their order: the film's bits do not depend on threads.
pub trait Estimator<const C: usize>: Sync {
    /// What the tasks of a round share.
    type Prepared: Sync;
    /// What a task counts.
    type Tally: Default + Send;

    /// Starts round number `round`.
    fn prepare(&self, round: u64) -> Self::Prepared;
    /// Number of tasks in a round.
    fn tasks(&self, prepared: &Self::Prepared) -> usize;
    /// Most deposits that a task may make, for the size of a batch.
    fn task_deposits(&self) -> usize;
    /// Runs one task.
    fn run(&self, prepared: &Self::Prepared, task: usize, deposits: &mut Deposits<C>) -> Self::Tally;
    /// Samples in a round: the weight of its result.
    fn weight(&self, round: u64) -> u64;
    /// Adds to `total` what a finished round counted; `tasks` are in their order.
    fn tally(&self, total: &mut Self::Tally, prepared: Self::Prepared, tasks: Vec<Self::Tally>);
}

/// Where a render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Rounds finished by this call.
    pub rounds: u64,
    /// Finished share of the current round, in [0, 1]; 0 just after a round has ended.
    pub fraction: f64,
}

/// Called with the state of a render; it breaks to stop it.
pub type Observer<'a, const C: usize, T> = dyn FnMut(Progress, &Film<C>, &T) -> ControlFlow<()> + 'a;

/// How a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All rounds were made.
    Complete,
    /// The observer stopped it; the film holds the finished rounds.
    Stopped,
}

/// Adds rounds to `film` and their counts to `tally`, on the current rayon pool.
///
/// `observe` is called after every batch of tasks and after every round. When it breaks, an unfinished round is dropped.
pub fn render<const C: usize, E: Estimator<C>>(
    estimator: &E,
    rounds: Range<u64>,
    film: &mut Film<C>,
    tally: &mut E::Tally,
    observe: &mut Observer<'_, C, E::Tally>,
) -> Outcome {
    let mut buffers = Vec::new();
    for (done, round) in (0..).zip(rounds) {
        let prepared = estimator.prepare(round);
        let tasks = estimator.tasks(&prepared);
        let batch = batch_size::<C>(estimator.task_deposits());
        buffers.resize_with(batch.min(tasks), || film.deposits());
        let mut tallies = Vec::with_capacity(tasks);
        for first in (0..tasks).step_by(batch) {
            let last = (first + batch).min(tasks);
            let buffers = &mut buffers[..last - first];
            let run = |(task, deposits): (usize, &mut Deposits<C>)| {
                deposits.clear();
                estimator.run(&prepared, task, deposits)
            };
            tallies.par_extend((first..last).into_par_iter().zip(buffers.par_iter_mut()).map(run));
            film.add(buffers);
            let progress = Progress { rounds: done, fraction: last as f64 / tasks as f64 };
            if last < tasks && observe(progress, film, tally).is_break() {
                film.drop_round();
                return Outcome::Stopped;
            }
        }
        film.close_round(estimator.weight(round));
        estimator.tally(tally, prepared, tallies);
        if observe(Progress { rounds: done + 1, fraction: 0.0 }, film, tally).is_break() {
            return Outcome::Stopped;
        }
    }
    Outcome::Complete
}

/// Tasks whose deposits fit the memory set aside for them, and enough to keep the threads busy.
fn batch_size<const C: usize>(task_deposits: usize) -> usize {
    let bytes = task_deposits.max(1) * size_of::<super::Deposit<C>>();
    (WAITING_DEPOSITS / bytes).min(256).max(2 * rayon::current_num_threads())
}
