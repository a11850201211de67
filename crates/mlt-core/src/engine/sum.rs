//! Two estimators of parts of one image.

use super::{Counted, DecodeError, Deposits, Estimator, Reader};

/// An estimator whose rounds are the sum of two others' rounds, each of which samples a part of the space.
///
/// Both give their rounds the same weight; they share no random numbers.
#[derive(Debug)]
pub struct Sum<A, B>(pub A, pub B);

/// Counts of both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SumTally<A, B>(pub A, pub B);

impl<A: Counted, B: Counted> Counted for SumTally<A, B> {
    fn merge(&mut self, other: &Self) {
        self.0.merge(&other.0);
        self.1.merge(&other.1);
    }

    fn write(&self, to: &mut Vec<u8>) {
        self.0.write(to);
        self.1.write(to);
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        Ok(Self(A::read(from)?, B::read(from)?))
    }
}

/// Counts of a task of either.
#[derive(Clone, Copy, Debug)]
pub enum Either<A, B> {
    /// Of the first.
    First(A),
    /// Of the second.
    Second(B),
}

impl<const C: usize, A: Estimator<C>, B: Estimator<C>> Estimator<C> for Sum<A, B> {
    type Prepared = (A::Prepared, B::Prepared);
    type Task = Either<A::Task, B::Task>;
    type Tally = SumTally<A::Tally, B::Tally>;

    fn prepare(&self, round: u64) -> Self::Prepared {
        rayon::join(|| self.0.prepare(round), || self.1.prepare(round))
    }

    fn tasks(&self, (a, b): &Self::Prepared) -> usize {
        self.0.tasks(a) + self.1.tasks(b)
    }

    fn task_deposits(&self) -> usize {
        self.0.task_deposits().max(self.1.task_deposits())
    }

    fn run(&self, (a, b): &Self::Prepared, task: usize, deposits: &mut Deposits<C>) -> Self::Task {
        match task.checked_sub(self.0.tasks(a)) {
            None => Either::First(self.0.run(a, task, deposits)),
            Some(task) => Either::Second(self.1.run(b, task, deposits)),
        }
    }

    fn weight(&self, round: u64) -> u64 {
        self.0.weight(round)
    }

    fn tally(&self, total: &mut Self::Tally, (a, b): &Self::Prepared, tasks: Vec<Self::Task>) {
        let (mut of_a, mut of_b) = (Vec::new(), Vec::new());
        for task in tasks {
            match task {
                Either::First(counts) => of_a.push(counts),
                Either::Second(counts) => of_b.push(counts),
            }
        }
        self.0.tally(&mut total.0, a, of_a);
        self.1.tally(&mut total.1, b, of_b);
    }

    fn tally_round(&self, total: &mut Self::Tally, (a, b): &Self::Prepared) {
        self.0.tally_round(&mut total.0, a);
        self.1.tally_round(&mut total.1, b);
    }
}
