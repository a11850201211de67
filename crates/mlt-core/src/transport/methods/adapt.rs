//! The pilot of a render: strata and their shares, fitted to what they contribute.

use crate::engine::{LEAST_CHAIN, Measure, PILOT, Share, Tally, allocate};
use crate::transport::lights::{LightStrata, LightTree, Node, Stratification};
use crate::transport::scene::Lights;
use std::ops::Range;

/// How n_j is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Weights {
    /// In proportion to power.
    Power,
    /// From the noise and cost that pilot rounds measure.
    #[default]
    Adaptive,
}

/// Options of the pilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Adaptation {
    /// How n_j is chosen.
    pub weights: Weights,
    /// Rounds of each measurement; at least 2.
    pub pilot_rounds: u64,
}

impl Default for Adaptation {
    fn default() -> Self {
        Self { weights: Weights::default(), pilot_rounds: 4 }
    }
}

/// Size of a pilot round, as a share of a production round: it has to find light, not to make an image.
const PILOT_SHARE: f64 = 0.25;
/// Fewest mutations of a pilot round, unless a production round has fewer.
const LEAST_PILOT: f64 = 16_384.0;
/// Most mutations of a pilot round.
const MOST_PILOT: f64 = 262_144.0;
/// Strata that `auto` starts from.
const COARSE: usize = 8;
/// Most strata of `auto`.
const FINE: usize = 64;
/// Measurements, each of which may double the strata.
const LEVELS: u64 = 3;
/// Mutations of an average stratum in a round, so that `auto` does not cut any finer.
const MUTATIONS_PER_STRATUM: f64 = 8.0 * LEAST_CHAIN as f64;

/// Most of a round that strata may take if each gets no more than the shortest useful chain.
const MOST_IN_SHORT_CHAINS: f64 = 0.25;

/// Runs pilot rounds of given strata with given shares.
pub(crate) type Measurement<'a> = dyn Fn(&LightStrata, &[Share], Range<u64>) -> Option<(Vec<Measure>, Tally)> + 'a;

/// Parts of a pilot: the settings, and a way to measure given strata with given shares.
pub(crate) struct Pilot<'a> {
    pub(crate) lights: &'a Lights,
    pub(crate) adaptation: Adaptation,
    /// Mutations of a production round.
    pub(crate) mutations: f64,
    /// Number of classes that each part is cut into where the lights have so many.
    pub(crate) classes: &'a dyn Fn(usize) -> usize,
    /// Mutations for one independent sample, if their noise does not ask for more.
    pub(crate) mutations_per_sample: u64,
    /// n_j by power for so many mutations.
    pub(crate) by_power: &'a dyn Fn(&LightStrata, f64) -> Vec<Share>,
    /// Runs pilot rounds.
    pub(crate) measure: &'a Measurement<'a>,
}

/// Strata and shares for a render.
pub(crate) struct Adapted {
    pub(crate) strata: LightStrata,
    /// `None`: in proportion to power.
    pub(crate) shares: Option<Vec<Share>>,
    /// Cost of the pilot.
    pub(crate) tally: Tally,
}

impl Pilot<'_> {
    /// The strata asked for, with shares by power or fitted. One stratum has nothing to share.
    pub(crate) fn run(&self, stratification: Stratification) -> Option<Adapted> {
        let mut tally = Tally::default();
        let strata = match stratification {
            Stratification::Auto => self.refine(&mut tally)?,
            _ => self.cut(stratification),
        };
        if self.adaptation.weights == Weights::Power || self.strata_of(strata.regions().len()) == 1 {
            return Some(Adapted { strata, shares: None, tally });
        }
        let measures = self.measure(&strata, LEVELS, &mut tally)?;
        let by_power = (self.by_power)(&strata, self.mutations);
        let shares = allocate(&measures, &by_power, self.mutations, self.mutations_per_sample);
        Some(Adapted { strata, shares: Some(shares), tally })
    }

    /// Strata of so many parts of the lights, without what is met by chance.
    fn strata_of(&self, parts: usize) -> usize {
        parts * (self.classes)(parts)
    }

    /// The strata asked for. Where a round has no room for a useful chain in each, weak ones are joined.
    fn cut(&self, stratification: Stratification) -> LightStrata {
        let strata = LightStrata::new(self.lights, stratification);
        let parts = strata.regions().len();
        let shortest = LEAST_CHAIN as f64 / self.mutations;
        if self.strata_of(parts) as f64 * shortest <= MOST_IN_SHORT_CHAINS {
            return strata;
        }
        let shortest = shortest * (self.classes)(parts) as f64;
        LightStrata::with_least_share(self.lights, stratification, shortest.min(1.0))
    }

    /// Starts from a coarse cut by power; in each measurement halves the nodes that leave more than an average node's
    /// error at the best allocation, √(chain_error · cost), as long as there is room.
    fn refine(&self, tally: &mut Tally) -> Option<LightStrata> {
        let tree = LightTree::new(self.lights);
        let room = (self.mutations / (self.classes)(FINE) as f64 / MUTATIONS_PER_STRATUM) as usize;
        let most = room.clamp(1, FINE);
        let mut nodes = tree.cut(COARSE.min(most), 0.0);
        for level in 0..LEVELS {
            let strata = LightStrata::of_cut(self.lights, &tree, &nodes, 0.0);
            if nodes.len() >= most {
                break;
            }
            let measures = self.measure(&strata, level, tally)?;
            let of_nodes = measures.chunks((self.classes)(strata.regions().len())).take(nodes.len());
            let errors: Vec<_> = of_nodes.map(|m| m.iter().map(error).sum::<f64>()).collect();
            let before = nodes.len();
            nodes = split(&tree, nodes, &errors, most);
            if nodes.len() == before {
                break;
            }
        }
        Some(LightStrata::of_cut(self.lights, &tree, &nodes, 0.0))
    }

    fn measure(&self, strata: &LightStrata, level: u64, tally: &mut Tally) -> Option<Vec<Measure>> {
        let mutations = (PILOT_SHARE * self.mutations).clamp(LEAST_PILOT, MOST_PILOT).min(self.mutations);
        let mut shares = (self.by_power)(strata, mutations);
        for share in &mut shares {
            share.mutations = share.mutations.max(LEAST_CHAIN);
            share.samples = share.samples.max(share.mutations / 8);
        }
        let first = PILOT + (level << 32);
        let rounds = first..first + self.adaptation.pilot_rounds.max(2);
        let (measures, spent) = (self.measure)(strata, &shares, rounds)?;
        tally.strata.extend(spent.strata);
        Some(measures)
    }
}

/// A stratum's part of what an image of given noise costs.
fn error(m: &Measure) -> f64 {
    (m.chain_error.unwrap_or(0.0) * m.mutation_cost).sqrt()
}

/// Halves the nodes with more than their average of `errors`, the worst first, up to `most` nodes.
fn split(tree: &LightTree, nodes: Vec<Node>, errors: &[f64], most: usize) -> Vec<Node> {
    let average = errors.iter().sum::<f64>() / errors.len() as f64;
    let mut by_error: Vec<_> = (0..nodes.len()).filter(|&i| errors[i] > average).collect();
    by_error.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]));
    by_error.truncate(most - nodes.len());
    let halves = |(i, node): (usize, Node)| match tree.halves(node).filter(|_| by_error.contains(&i)) {
        Some(halves) => halves.to_vec(),
        None => vec![node],
    };
    nodes.into_iter().enumerate().flat_map(halves).collect()
}
