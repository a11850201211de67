//! Stratified Metropolis sampling as an estimator.

use super::bootstrap::{Bootstrap, SampleKey};
use super::{
    Chain, Deposits, Estimator, Generator, Importance, Mixture, Mutation, Path, Purpose, Splat, Stratum, StratumStats,
    generator,
};
use rayon::prelude::*;

/// Longest chain, in mutations. A longer share of a round is run as several chains, each with a start of its own from the same
/// batch of independent samples: a state that a chain cannot leave costs no more than this.
const CHAIN_LENGTH: u64 = 1 << 9;

/// Independent samples made by one parallel step.
const BOOTSTRAP_BLOCK: u64 = 256;

/// A stratum's share of every round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// n_j, mutations of its chains; 0: the stratum is left out, which is right only if it is dark.
    pub mutations: u64,
    /// m_j, independent samples for b̂_j and the chains' starts.
    pub samples: u64,
}

/// The paper's Algorithm 2: for each stratum, Metropolis with importance I_j, deposited in proportion to b̂_j.
///
/// In each round and stratum, b̂_j is the mean importance weight of m_j independent samples, the first state of a chain is
/// one of them drawn in proportion to its weight, and n_j mutations deposit b̂_j/n_j · f/I. The pairing of b̂_j with the
/// start makes every round unbiased, however short.
///
/// Source: [Jankauski15], section 3; [VeachGuibas97], section 5.1 (start-up bias).
pub struct Metropolis<'a, P, S, M, I> {
    /// Ω_1 … Ω_K.
    pub strata: &'a [S],
    /// One share a stratum.
    pub shares: &'a [Share],
    /// Proposals.
    pub mixture: &'a Mixture<P, S, M>,
    /// I.
    pub importance: &'a I,
    /// Key of all random streams.
    pub seed: u64,
    /// What the calling thread has spent so far, in a unit of the user's choice: rays, say.
    pub work: fn() -> u64,
}

/// Counts of a render, one entry a stratum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// In the order of the strata.
    pub strata: Vec<StratumStats>,
}

impl Tally {
    /// Counts over all strata.
    pub fn total(&self) -> StratumStats {
        let mut total = StratumStats::default();
        self.strata.iter().for_each(|s| total.merge(s));
        total
    }

    /// Work of all strata, in the unit of [`Metropolis::work`].
    pub fn work(&self) -> u64 {
        self.strata.iter().map(|s| s.chain_work + s.sample_work).sum()
    }
}

/// A round that is ready to run its chains.
pub struct Prepared {
    round: u64,
    bootstraps: Vec<Bootstrap>,
    chains: Vec<ChainTask>,
}

impl Prepared {
    /// Stratum and b̂ of a task's chain.
    pub(super) fn chain(&self, task: usize) -> (usize, f64) {
        let stratum = self.chains[task].stratum;
        (stratum, self.bootstraps[stratum].b())
    }
}

/// One chain: its stratum, number, first sample and length.
struct ChainTask {
    stratum: usize,
    index: u64,
    start: u64,
    mutations: u64,
}

impl<P, S, M, I> Metropolis<'_, P, S, M, I>
where
    P: Path,
    S: Stratum<P> + Sync,
    I: Importance<P> + Sync,
    Self: Sync,
{
    fn key(&self, round: u64, stratum: usize, sample: u64) -> SampleKey {
        SampleKey { seed: self.seed, round, stratum: stratum as u64, sample }
    }

    /// The independent samples of all strata in a round, in blocks so that one large stratum keeps all threads busy.
    pub(super) fn bootstraps(&self, round: u64) -> Vec<Bootstrap> {
        let blocks: Vec<_> = (self.shares.iter().enumerate())
            .flat_map(|(j, share)| (0..share.samples).step_by(BOOTSTRAP_BLOCK as usize).map(move |first| (j, first)))
            .collect();
        let weigh = |&(j, first): &(usize, u64)| -> (Vec<f64>, u64) {
            let before = (self.work)();
            let last = self.shares[j].samples.min(first + BOOTSTRAP_BLOCK);
            let key = |i| self.key(round, j, i);
            let weights = (first..last).map(|i| key(i).weight(&self.strata[j], self.importance)).collect();
            (weights, (self.work)() - before)
        };
        let mut weighed = blocks.par_iter().map(weigh).collect::<Vec<_>>().into_iter();
        let gather = |share: &Share| {
            let blocks = share.samples.div_ceil(BOOTSTRAP_BLOCK) as usize;
            let (weights, work): (Vec<_>, Vec<_>) = weighed.by_ref().take(blocks).unzip();
            Bootstrap::new(weights.concat(), work.iter().sum())
        };
        self.shares.iter().map(gather).collect()
    }

    /// Chains of equal length with starts drawn from the stratum's bootstrap.
    fn chains(&self, round: u64, stratum: usize, bootstrap: &Bootstrap) -> Vec<ChainTask> {
        let mutations = self.shares[stratum].mutations;
        let count = mutations.div_ceil(CHAIN_LENGTH);
        let mut rng = generator(self.seed, Purpose::Start, round, stratum as u64, u64::MAX);
        let starts = bootstrap.choose(count, &mut rng);
        let task = |(index, start): (u64, u64)| ChainTask {
            stratum,
            index,
            start,
            mutations: mutations * (index + 1) / count - mutations * index / count,
        };
        (0..).zip(starts).map(task).collect()
    }
}

impl<const C: usize, P, S, M, I> Estimator<C> for Metropolis<'_, P, S, M, I>
where
    P: Path<Splat = Splat<C>> + Send,
    S: Stratum<P> + Sync,
    M: Mutation<P, S> + Sync,
    I: Importance<P> + Sync,
{
    type Prepared = Prepared;
    type Tally = Tally;

    fn prepare(&self, round: u64) -> Prepared {
        let bootstraps = self.bootstraps(round);
        let chains = bootstraps.iter().enumerate().flat_map(|(j, b)| self.chains(round, j, b)).collect();
        Prepared { round, bootstraps, chains }
    }

    fn tasks(&self, prepared: &Prepared) -> usize {
        prepared.chains.len()
    }

    fn task_deposits(&self) -> usize {
        // Two deposits a mutation at most; a chain is no longer than the longest share.
        2 * self.shares.iter().map(|s| s.mutations).max().unwrap_or(0).min(CHAIN_LENGTH) as usize
    }

    fn run(&self, prepared: &Prepared, task: usize, deposits: &mut Deposits<C>) -> Tally {
        let before = (self.work)();
        let ChainTask { stratum, index, start, mutations } = prepared.chains[task];
        let stream = |purpose| generator(self.seed, purpose, prepared.round, stratum as u64, index);
        let start = self.key(prepared.round, stratum, start).pick(
            &self.strata[stratum],
            self.importance,
            &mut stream(Purpose::Start),
        );
        let chain = start.and_then(|x| Chain::new(self.mixture, self.importance, &self.strata[stratum], x));
        let b = prepared.bootstraps[stratum].b();
        let scale = b / self.shares[stratum].mutations as f64;
        let mut rng: Generator = stream(Purpose::Chain);
        let mut stats = StratumStats::default();
        match chain {
            Some(mut chain) => {
                for half in [mutations / 2, mutations.div_ceil(2)] {
                    (0..half).for_each(|_| chain.step(deposits, scale, &mut rng));
                    chain.end_half(b);
                }
                chain.flush(deposits, scale);
                stats = chain.into_stats();
            }
            None => stats.refused_starts = 1,
        }
        stats.chain_work = (self.work)() - before;
        Tally { strata: vec![stats] }
    }

    fn weight(&self, _round: u64) -> u64 {
        1
    }

    fn tally(&self, total: &mut Tally, prepared: &Prepared, tasks: Vec<Tally>) {
        total.strata.resize_with(self.strata.len(), || StratumStats::new(self.mixture.mutations().len()));
        for (chain, tally) in prepared.chains.iter().zip(tasks) {
            total.strata[chain.stratum].merge(&tally.strata[0]);
        }
        for (stats, bootstrap) in total.strata.iter_mut().zip(&prepared.bootstraps) {
            bootstrap.count(stats);
        }
    }
}
