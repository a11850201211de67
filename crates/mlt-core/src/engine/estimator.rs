//! Estimators that are repeated in rounds, and the loop that repeats them.

use super::{Accumulated, Counted, Deposits};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Deposits that may wait for their merge, bytes; more where that would not keep all threads busy.
const WAITING_DEPOSITS: usize = 16 << 20;
/// Tasks for each thread that rounds in flight have at least: at their end threads wait for the last task, half of one on average.
const TASKS_PER_THREAD: usize = 32;
/// Tasks for each thread in a batch at least.
const BATCH_PER_THREAD: usize = 8;

/// An unbiased estimator of the whole film that can be repeated independently.
///
/// A round is cut into tasks. What a task deposits depends on the round's and the task's number alone, and tasks are
/// merged in their order: the film's bits do not depend on threads.
pub trait Estimator<const C: usize>: Sync {
    /// State that the tasks of a round share.
    type Prepared: Send + Sync;
    /// Counts of a task.
    type Task: Send;
    /// Counts of rounds.
    type Tally: Counted;

    /// Starts round number `round`.
    fn prepare(&self, round: u64) -> Self::Prepared;
    /// Number of tasks in a round.
    fn tasks(&self, prepared: &Self::Prepared) -> usize;
    /// Most deposits that a task may make, for the size of a batch.
    fn task_deposits(&self) -> usize;
    /// Runs one task.
    fn run(&self, prepared: &Self::Prepared, task: usize, deposits: &mut Deposits<C>) -> Self::Task;
    /// Samples in a round: the weight of its result.
    fn weight(&self, round: u64) -> u64;
    /// Adds to `total` what some tasks of a round counted. Each task comes once, soon after it has run.
    fn tally(&self, total: &mut Self::Tally, prepared: &Self::Prepared, tasks: Vec<Self::Task>);
    /// Adds to `total` what a round counted that has ended, beside its tasks.
    fn tally_round(&self, _total: &mut Self::Tally, _prepared: &Self::Prepared) {}
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
pub type Observer<'a, const C: usize, T> = dyn FnMut(Progress, &Accumulated<C, T>) -> ControlFlow<()> + 'a;

/// How a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It came to its end.
    Complete,
    /// The observer stopped it; its sums hold the finished rounds.
    Stopped,
}

/// Adds rounds to `sums`, on the current rayon pool. Those that are in them already are left out.
///
/// Where a round has few tasks, several rounds are in flight: prepared together, with one list of tasks. `observe` is called
/// after every batch of tasks and after every round. When it breaks, unfinished rounds are dropped.
pub fn render<const C: usize, E: Estimator<C>>(
    estimator: &E,
    rounds: Range<u64>,
    sums: &mut Accumulated<C, E::Tally>,
    observe: &mut Observer<'_, C, E::Tally>,
) -> Outcome {
    let missing = sums.rounds().missing(rounds);
    let mut merger = Merger { estimator, sums, observe, tasks: 0, tally: E::Tally::default(), rounds: 0 };
    if missing.into_iter().try_for_each(|rounds| merger.make(rounds)).is_break() {
        merger.sums.film.drop_round();
        return Outcome::Stopped;
    }
    Outcome::Complete
}

/// A round's number and what its tasks share.
type Round<E, const C: usize> = (u64, <E as Estimator<C>>::Prepared);

/// Merges tasks in their order and closes rounds.
struct Merger<'a, 'o, const C: usize, E: Estimator<C>> {
    estimator: &'a E,
    sums: &'a mut Accumulated<C, E::Tally>,
    observe: &'a mut Observer<'o, C, E::Tally>,
    /// Tasks of the current round that are merged, and their counts.
    tasks: usize,
    tally: E::Tally,
    /// Rounds closed.
    rounds: u64,
}

impl<const C: usize, E: Estimator<C>> Merger<'_, '_, C, E> {
    /// Makes consecutive rounds.
    fn make(&mut self, rounds: Range<u64>) -> ControlFlow<()> {
        let estimator = self.estimator;
        let prepare = |rounds: Range<u64>| rounds.into_par_iter().map(|round| (round, estimator.prepare(round)));
        let (mut next, mut in_flight, mut buffers) = (rounds.start, 1, Vec::new());
        while next < rounds.end {
            let end = |in_flight| rounds.end.min(next.saturating_add(in_flight));
            let mut prepared: Vec<_> = prepare(next..end(in_flight)).collect();
            if next == rounds.start {
                in_flight = rounds_in_flight(rayon::current_num_threads(), estimator.tasks(&prepared[0].1));
                prepared.par_extend(prepare(end(1)..end(in_flight)));
            }
            let tasks: Vec<_> =
                prepared.iter().flat_map(|p| (0..estimator.tasks(&p.1)).map(move |task| (p, task))).collect();
            self.run(&prepared, &tasks, &mut buffers)?;
            in_flight = rounds_in_flight(rayon::current_num_threads(), tasks.len() / prepared.len());
            next = end(prepared.len() as u64);
        }
        ControlFlow::Continue(())
    }

    /// Runs the tasks of some rounds in batches.
    fn run(
        &mut self,
        rounds: &[Round<E, C>],
        tasks: &[(&Round<E, C>, usize)],
        buffers: &mut Vec<Deposits<C>>,
    ) -> ControlFlow<()> {
        let batch = batch_size::<C>(rayon::current_num_threads(), self.estimator.task_deposits());
        if buffers.len() < batch.min(tasks.len()) {
            buffers.resize_with(batch.min(tasks.len()), || self.sums.film.deposits());
        }
        let mut open = self.close(rounds)?;
        for tasks in tasks.chunks(batch) {
            let estimator = self.estimator;
            let run = |(&(round, task), deposits): (&(&Round<E, C>, usize), &mut Deposits<C>)| {
                deposits.clear();
                estimator.run(&round.1, task, deposits)
            };
            let mut counts = tasks.par_iter().zip(buffers.par_iter_mut()).map(run).collect::<Vec<_>>().into_iter();
            let mut merged = 0;
            for of_round in tasks.chunk_by(|a, b| a.0.0 == b.0.0) {
                self.sums.film.add(&mut buffers[merged..merged + of_round.len()]);
                let counts = counts.by_ref().take(of_round.len()).collect();
                estimator.tally(&mut self.tally, &of_round[0].0.1, counts);
                self.tasks += of_round.len();
                merged += of_round.len();
                open = self.close(open)?;
            }
            if let Some(round) = open.first().filter(|_| self.tasks > 0) {
                let fraction = self.tasks as f64 / self.estimator.tasks(&round.1) as f64;
                (self.observe)(Progress { rounds: self.rounds, fraction }, self.sums)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Closes the first of the open rounds if all its tasks are merged, and those after it that have none; returns the rest.
    fn close<'r>(&mut self, mut open: &'r [Round<E, C>]) -> ControlFlow<(), &'r [Round<E, C>]> {
        while let [(round, prepared), rest @ ..] = open
            && self.tasks == self.estimator.tasks(prepared)
        {
            self.sums.film.close_round(*round, self.estimator.weight(*round));
            self.estimator.tally_round(&mut self.tally, prepared);
            self.sums.tally.merge(&std::mem::take(&mut self.tally));
            self.tasks = 0;
            self.rounds += 1;
            (self.observe)(Progress { rounds: self.rounds, fraction: 0.0 }, self.sums)?;
            open = rest;
        }
        ControlFlow::Continue(open)
    }
}

/// Rounds that are prepared and run together: enough for some tasks a thread.
pub fn rounds_in_flight(threads: usize, tasks_per_round: usize) -> u64 {
    (TASKS_PER_THREAD * threads).div_ceil(tasks_per_round.max(1)) as u64
}

/// Tasks that run before their deposits are merged: those whose deposits fit the memory set aside for them, but enough to keep
/// the threads busy. `task_deposits`: most deposits of a task.
pub fn batch_size<const C: usize>(threads: usize, task_deposits: usize) -> usize {
    let bytes = task_deposits.max(1) * size_of::<super::Deposit<C>>();
    (WAITING_DEPOSITS / bytes).min(256).max(BATCH_PER_THREAD * threads)
}

#[cfg(test)]
mod tests {
    use super::super::{Film, Sink, Splat};
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    /// Rounds of some tasks, each of which lights one site.
    struct Lamps {
        tasks: fn(u64) -> usize,
        /// How long a task waits for another to run beside it.
        patience: Duration,
        running: AtomicUsize,
        most: AtomicUsize,
    }

    impl Estimator<1> for Lamps {
        type Prepared = u64;
        type Task = u64;
        type Tally = u64;

        fn prepare(&self, round: u64) -> u64 {
            round
        }

        fn tasks(&self, round: &u64) -> usize {
            (self.tasks)(*round)
        }

        fn task_deposits(&self) -> usize {
            1 << 16
        }

        fn run(&self, round: &u64, task: usize, deposits: &mut Deposits<1>) -> u64 {
            self.most.fetch_max(self.running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            let start = Instant::now();
            while start.elapsed() < self.patience && self.most.load(Ordering::SeqCst) < 2 {
                std::thread::yield_now();
            }
            let value = 1.0 / (1.0 + *round as f64 + 0.3 * task as f64);
            deposits.deposit(Splat { site: (*round as u32 + task as u32) % 5, value: [value] }, 1.0);
            self.running.fetch_sub(1, Ordering::SeqCst);
            1
        }

        fn weight(&self, round: u64) -> u64 {
            1 + round % 3
        }

        fn tally(&self, total: &mut u64, _round: &u64, tasks: Vec<u64>) {
            assert!(tasks.len() <= 256, "{} tasks' counts waited for the end of their round", tasks.len());
            *total += tasks.iter().sum::<u64>();
        }
    }

    /// 40 rounds on some threads, stopped after `most` of them: the pixels, the number of rounds and of tasks, and how many
    /// ran at once.
    fn rendered(tasks: fn(u64) -> usize, threads: usize, most: u64, patience: u64) -> (Vec<f64>, u64, u64, usize) {
        let patience = Duration::from_millis(patience);
        let lamps = Lamps { tasks, patience, running: AtomicUsize::new(0), most: AtomicUsize::new(0) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut sums = Accumulated::new(Film::new(5, 1.0));
        pool.install(|| {
            let observe: &mut Observer<1, u64> = &mut |at, sums| {
                assert_eq!(at.rounds, sums.film().rounds());
                if at.rounds >= most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let _ = render(&lamps, 0..40, &mut sums, observe);
        });
        let pixels = (0..5).map(|i| sums.film().pixel(i)[0].mean).collect();
        (pixels, sums.film().rounds(), *sums.tally(), lamps.most.into_inner())
    }

    #[test]
    fn rounds_of_any_size_give_the_same_bits_on_any_threads() {
        for tasks in [(|_| 1) as fn(u64) -> usize, |r| r as usize % 4, |_| 1000, |_| 0] {
            let alone = rendered(tasks, 1, 40, 0);
            assert_eq!(alone.1, 40);
            assert_eq!(alone.2, (0..40).map(tasks).sum::<usize>() as u64);
            for threads in [2, 8, 32] {
                assert_eq!(rendered(tasks, threads, 40, 0).0, alone.0);
            }
        }
    }

    #[test]
    fn rounds_of_one_task_run_side_by_side() {
        assert_eq!(rendered(|_| 1, 2, 40, 2000).3, 2);
    }

    #[test]
    fn a_stop_drops_the_rounds_in_flight() {
        for stop in [1, 3, 17] {
            let (_, rounds, tasks, _) = rendered(|_| 2, 8, stop, 0);
            assert_eq!((rounds, tasks), (stop, 2 * stop));
        }
    }
}
