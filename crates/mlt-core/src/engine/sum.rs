//! Two estimators of parts of one image.

use super::{Deposits, Estimator};

/// An estimator whose rounds are the sum of two others' rounds, each of which samples a part of the space.
///
/// Both give their rounds the same weight; they share no random numbers.
pub struct Sum<A, B>(pub A, pub B);

/// Counts of one task of a sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SumTally<A, B>(pub A, pub B);

impl<const C: usize, A: Estimator<C>, B: Estimator<C>> Estimator<C> for Sum<A, B> {
    type Prepared = (A::Prepared, B::Prepared);
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

    fn run(&self, (a, b): &Self::Prepared, task: usize, deposits: &mut Deposits<C>) -> Self::Tally {
        match task.checked_sub(self.0.tasks(a)) {
            None => SumTally(self.0.run(a, task, deposits), B::Tally::default()),
            Some(task) => SumTally(A::Tally::default(), self.1.run(b, task, deposits)),
        }
    }

    fn weight(&self, round: u64) -> u64 {
        self.0.weight(round)
    }

    fn tally(&self, total: &mut Self::Tally, (a, b): &Self::Prepared, tasks: Vec<Self::Tally>) {
        let (of_a, of_b): (Vec<_>, Vec<_>) = tasks.into_iter().map(|SumTally(x, y)| (x, y)).unzip();
        let first = self.0.tasks(a);
        self.0.tally(&mut total.0, a, of_a.into_iter().take(first).collect());
        self.1.tally(&mut total.1, b, of_b.into_iter().skip(first).collect());
    }
}
