//! Stratified Metropolis sampling as an estimator.

use super::bootstrap::{Bootstrap, SampleKey};
use super::{
    Chain, Coverage, Deposits, Estimator, Generator, Importance, Mixture, Mutation, Path, Purpose, SetupError, Share,
    Splat, Stratum, StratumStats, Tally, Watch, generator,
};
use rayon::prelude::*;

/// Longest chain, in mutations. A longer share of a round is run as several chains, each with a start of its own from the same
/// batch of independent samples: a state that a chain cannot leave costs no more than this.
pub const CHAIN_LENGTH: u64 = 1 << 9;

/// Independent samples made by one parallel step.
const BOOTSTRAP_BLOCK: u64 = 256;

/// The paper's Algorithm 2: for each stratum, Metropolis with importance I_j, deposited in proportion to b̂_j.
///
/// In each round and stratum, b̂_j is the mean importance weight of m_j independent samples, the first state of a chain is
/// one of them drawn in proportion to its weight, and n_j mutations deposit b̂_j/n_j · f/I. The pairing of b̂_j with the
/// start makes every round unbiased, however short.
///
/// Source: [Jankauski15], section 3; [VeachGuibas97], section 5.1 (start-up bias).
#[derive(Debug)]
pub struct Metropolis<'a, P, S, M, I> {
    pub(super) strata: &'a [(S, Share)],
    mixture: &'a Mixture<P, S, M>,
    importance: &'a I,
    seed: u64,
    work: fn() -> u64,
    partial: bool,
}

impl<'a, P, S, M, I> Metropolis<'a, P, S, M, I> {
    /// Chains in the strata Ω_1 … Ω_K, each with its share of every round, with proposals of `mixture`; `importance` is I and `seed`
    /// the key of all random streams.
    ///
    /// # Errors
    ///
    /// Without any stratum, and where one has no mutation or no independent sample in a round.
    pub fn new(
        strata: &'a [(S, Share)],
        mixture: &'a Mixture<P, S, M>,
        importance: &'a I,
        seed: u64,
    ) -> Result<Self, SetupError> {
        SetupError::check(strata.iter().map(|(_, share)| *share))?;
        Ok(Self { strata, mixture, importance, seed, work: || 0, partial: false })
    }

    /// Counts work: `work` tells what the calling thread has spent so far, in a unit of the user's choice, such as rays.
    #[must_use]
    pub fn counting(self, work: fn() -> u64) -> Self {
        Self { work, ..self }
    }

    /// Chains for a part of the space only: states outside all strata are estimated by other means, as in a [`Sum`](super::Sum),
    /// and are nothing to warn of.
    #[must_use]
    pub fn partial(self) -> Self {
        Self { partial: true, ..self }
    }
}

/// A round that is ready to run its chains.
#[derive(Debug)]
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

/// Weights of a block of independent samples, where they lie, and their cost.
struct Weighed {
    weights: Vec<f64>,
    coverage: Coverage,
    work: u64,
}

/// One chain: its stratum, number, first sample and length.
#[derive(Debug)]
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
    pub(super) fn bootstraps(&self, round: u64, watch: Watch) -> Option<Vec<Bootstrap>> {
        let first_samples = |(j, (_, share)): (usize, &(S, Share))| {
            (0..share.samples).step_by(BOOTSTRAP_BLOCK as usize).map(move |first| (j, first))
        };
        let blocks: Vec<_> = self.strata.iter().enumerate().flat_map(first_samples).collect();
        let pieces = watch.pieces(blocks.len());
        let weigh = |&(j, first): &(usize, u64)| pieces.unless_stopped(|| self.weigh(round, j, first));
        let mut weighed = blocks.par_iter().map(weigh).collect::<Option<Vec<_>>>()?.into_iter();
        let gather = |(_, share): &(S, Share)| {
            let blocks = share.samples.div_ceil(BOOTSTRAP_BLOCK) as usize;
            let (mut weights, mut coverage, mut work) = (Vec::new(), Coverage::default(), 0);
            for block in weighed.by_ref().take(blocks) {
                weights.extend(block.weights);
                coverage.merge(&block.coverage);
                work += block.work;
            }
            Bootstrap::new(weights, coverage, work)
        };
        Some(self.strata.iter().map(gather).collect())
    }

    /// A round, unless it is stopped.
    pub(super) fn prepared(&self, round: u64, watch: Watch) -> Option<Prepared> {
        let bootstraps = self.bootstraps(round, watch)?;
        let chains = bootstraps.iter().enumerate().flat_map(|(j, b)| self.chains(round, j, b)).collect();
        Some(Prepared { round, bootstraps, chains })
    }

    /// A block of independent samples; finds out where the states of its first one lie.
    fn weigh(&self, round: u64, j: usize, first: u64) -> Weighed {
        let before = (self.work)();
        let (stratum, share) = &self.strata[j];
        let last = share.samples.min(first + BOOTSTRAP_BLOCK);
        let mut coverage = Coverage::default();
        let is_due = self.is_looked_at(round, j, first / BOOTSTRAP_BLOCK);
        let mut weight = |i| {
            self.key(round, j, i).weight(stratum, self.importance, &mut |path, weight| {
                if i == first && is_due && weight > 0.0 {
                    let own = stratum.contains(path);
                    coverage.add_sample(own, self.strata_of(path) - usize::from(own));
                }
            })
        };
        let weights = (first..last).map(&mut weight).collect();
        Weighed { weights, coverage, work: (self.work)() - before }
    }

    /// Whether it is a chain's turn, or a block of samples', to have its states looked at.
    fn is_looked_at(&self, round: u64, stratum: usize, index: u64) -> bool {
        S::OF_ONE_SPACE && Coverage::is_due(round, stratum, index, self.strata.len())
    }

    /// Number of strata that a state lies in.
    fn strata_of(&self, path: &P) -> usize {
        self.strata.iter().filter(|(stratum, _)| stratum.contains(path)).count()
    }

    /// Where a proposal lies that left the stratum of its chain.
    fn outside(&self, path: &P) -> Coverage {
        let mut coverage = Coverage::default();
        let strata = self.strata_of(path);
        coverage.add_stray(strata, strata == 0 && !self.partial && self.importance.eval(path) > 0.0);
        coverage
    }

    /// Chains of equal length with starts drawn from the stratum's bootstrap.
    fn chains(&self, round: u64, stratum: usize, bootstrap: &Bootstrap) -> Vec<ChainTask> {
        let mutations = self.strata[stratum].1.mutations;
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

impl<P, S, M: Mutation<P, S>, I> Metropolis<'_, P, S, M, I> {
    /// Makes room for the counts of all strata and mutations.
    fn make_room(&self, total: &mut Tally) {
        total.strata.resize_with(self.strata.len(), || StratumStats::new(self.mixture.mutations().len()));
        total.mutations = self.mixture.mutations().iter().map(|mutation| mutation.name().into()).collect();
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
    /// A chain's stratum and counts.
    type Task = (usize, StratumStats);
    type Tally = Tally;

    fn prepare(&self, round: u64) -> Prepared {
        self.prepared(round, Watch::NEVER).expect("nothing stops it")
    }

    fn tasks(&self, prepared: &Prepared) -> usize {
        prepared.chains.len()
    }

    fn task_deposits(&self) -> usize {
        // Two deposits a mutation at most; a chain is no longer than the longest share.
        2 * self.strata.iter().map(|(_, share)| share.mutations).max().unwrap_or(0).min(CHAIN_LENGTH) as usize
    }

    fn run(&self, prepared: &Prepared, task: usize, deposits: &mut Deposits<C>) -> (usize, StratumStats) {
        let before = (self.work)();
        let ChainTask { stratum, index, start, mutations } = prepared.chains[task];
        let stream = |purpose| generator(self.seed, purpose, prepared.round, stratum as u64, index);
        let (within, share) = &self.strata[stratum];
        let bootstrap = &prepared.bootstraps[stratum];
        let key = self.key(prepared.round, stratum, start);
        let (first, weight) = key.pick(within, self.importance, &mut stream(Purpose::Start));
        let chain = first.and_then(|x| Chain::new(self.mixture, self.importance, within, x));
        let b = bootstrap.b();
        let scale = b / share.mutations as f64;
        let mut rng: Generator = stream(Purpose::Chain);
        let mut stats = StratumStats::default();
        match chain {
            Some(mut chain) => {
                for half in [mutations / 2, mutations.div_ceil(2)] {
                    (0..half).for_each(|_| chain.step(deposits, scale, &mut rng));
                    chain.end_half(b);
                }
                chain.flush(deposits, scale);
                let is_due = self.is_looked_at(prepared.round, stratum, index);
                let stray = chain.stray().filter(|_| is_due);
                let coverage = stray.map(|path| self.outside(path)).unwrap_or_default();
                stats = StratumStats { coverage, ..chain.into_stats() };
            }
            None => stats.refused_starts = 1,
        }
        stats.changed_starts = u64::from(weight != bootstrap.weight(start));
        stats.chain_work = (self.work)() - before;
        (stratum, stats)
    }

    fn weight(&self, _round: u64) -> u64 {
        1
    }

    fn tally(&self, total: &mut Tally, _: &Prepared, tasks: Vec<(usize, StratumStats)>) {
        self.make_room(total);
        tasks.iter().for_each(|(stratum, stats)| total.strata[*stratum].merge(stats));
    }

    fn tally_round(&self, total: &mut Tally, prepared: &Prepared) {
        self.make_room(total);
        total.strata.iter_mut().zip(&prepared.bootstraps).for_each(|(stats, bootstrap)| bootstrap.count(stats));
    }
}
