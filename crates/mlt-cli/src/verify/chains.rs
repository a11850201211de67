//! Whether rounds and chains agree: split-R̂, effective rounds, spread of b_j, chains that never moved.

use mlt_core::engine::HalfChains;
use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{bias::SIGNIFICANCE, evidence::Replica, fault::Fault};

/// R̂ above this is disagreement, if it is significant as well.
pub const DISAGREEMENT: f64 = 1.05;
/// Ratio of spreads of b_j above this is disagreement, if it is significant as well.
pub const UNDERSTATED: f64 = 1.5;

/// Permutations that a p-value comes from.
const PERMUTATIONS: usize = 1999;

/// Agreement of chains, rounds and replicas.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Chains {
    /// Largest split-R̂ over blocks: sequences are halves of replicas, draws are rounds. `None` with too few rounds.
    pub r_hat: Option<f64>,
    /// Probability of so large a one, in any block, if rounds are independent: from rounds dealt out anew to replicas.
    pub p_r_hat: Option<f64>,
    /// Smallest number of independent rounds, as a share of the rounds made, that the replicas' spread is worth.
    pub effective_rounds: Option<f64>,
    /// Largest ratio over strata of the spread of b_j over replicas to the standard error reported; `None` without
    /// strata.
    pub b_spread: Option<f64>,
    /// Its probability if the reported errors are right, corrected for the number of strata.
    pub p_b_spread: Option<f64>,
    /// Largest split-R̂ of a stratum's chains, halves of chains being the sequences, over all replicas together; `None`
    /// without strata and where all states have the same importance.
    pub r_hat_of_strata: Option<f64>,
    /// Least number of independent states that a stratum's chains are worth, over all replicas together.
    pub effective_states: Option<f64>,
    /// Longest run of proposals without an acceptance.
    pub longest_rejection: u64,
    /// Replicas that show the same image as an earlier one.
    pub repeated: usize,
}

/// Judges the rounds of the replicas.
pub fn chains(replicas: &[Replica]) -> Chains {
    let split = Split::of(replicas);
    let strata = replicas.iter().map(|r| r.strata.len()).min().unwrap_or(0);
    let spreads: Vec<(f64, f64)> = (0..strata).filter_map(|stratum| b_spread(replicas, stratum)).collect();
    let halves: Vec<HalfChains> = (0..strata).map(|stratum| halves(replicas, stratum)).collect();
    let least_p = spreads.iter().map(|s| s.1).reduce(f64::min);
    Chains {
        r_hat: split.as_ref().map(|split| split.r_hat),
        p_r_hat: split.as_ref().map(|split| split.p),
        effective_rounds: split.as_ref().map(|split| split.effective),
        b_spread: spreads.iter().map(|s| s.0).reduce(f64::max),
        p_b_spread: least_p.map(|p| (p * spreads.len() as f64).min(1.0)),
        r_hat_of_strata: halves.iter().filter_map(HalfChains::r_hat).reduce(f64::max),
        effective_states: halves.iter().filter_map(HalfChains::effective_states).reduce(f64::min),
        longest_rejection: replicas.iter().map(|r| r.longest_rejection).max().unwrap_or(0),
        repeated: repeated(replicas),
    }
}

/// R̂² = ((n − 1)/n W + B/n)/W for m sequences of n draws, B/n the variance of their means, W the mean variance inside them;
/// sequences are halves of replicas, draws are rounds.
///
/// Source: [GelmanRubin92], with each sequence cut in halves as in [GelmanEtAl13]. The p-value is exact for any law of the
/// rounds, since rounds that are independent and alike may be dealt out in any order.
struct Split {
    r_hat: f64,
    p: f64,
    effective: f64,
}

impl Split {
    fn of(replicas: &[Replica]) -> Option<Self> {
        let half = replicas.iter().map(|r| r.rounds.len()).min()? / 2;
        if half < 2 {
            return None;
        }
        let halves = |r: &'_ Replica| [0, r.rounds.len() - half].map(|first| first..first + half);
        let mut rounds: Vec<&Vec<f64>> =
            replicas.iter().flat_map(|r| halves(r).into_iter().flatten().map(|i| &r.rounds[i])).collect();
        let means = Means::of(&rounds);
        let f = means.largest_f(&rounds, half)?;
        let (mut rng, mut beyond) = (Pcg64Mcg::seed_from_u64(0), 1);
        for _ in 0..PERMUTATIONS {
            for i in (1..rounds.len()).rev() {
                rounds.swap(i, ((u64::from(rng.next_u32()) * (i as u64 + 1)) >> 32) as usize);
            }
            beyond += usize::from(means.largest_f(&rounds, half).is_some_and(|other| other >= f));
        }
        let n = half as f64;
        let p = beyond as f64 / (PERMUTATIONS + 1) as f64;
        Some(Self { r_hat: ((n - 1.0) / n + f / n).sqrt(), p, effective: (1.0 / f).min(1.0) })
    }
}

/// Of each block over all rounds: the mean, and Σ (x − mean)².
struct Means(Vec<(f64, f64)>);

impl Means {
    fn of(rounds: &[&Vec<f64>]) -> Self {
        let blocks = rounds.first().map_or(0, |round| round.len());
        let of_block = |block: usize| {
            let mean = rounds.iter().map(|round| round[block]).sum::<f64>() / rounds.len() as f64;
            (mean, rounds.iter().map(|round| (round[block] - mean).powi(2)).sum())
        };
        Self((0..blocks).map(of_block).collect())
    }

    /// The largest B/W over blocks, for sequences of n rounds each. Blocks that vary no more than rounding does count not.
    fn largest_f(&self, rounds: &[&Vec<f64>], n: usize) -> Option<f64> {
        let m = (rounds.len() / n) as f64;
        let mut between = vec![0.0; self.0.len()];
        for sequence in rounds.chunks_exact(n) {
            for (block, (between, (mean, _))) in between.iter_mut().zip(&self.0).enumerate() {
                let sum: f64 = sequence.iter().map(|round| round[block] - mean).sum();
                *between += sum * sum / n as f64;
            }
        }
        let f = |(between, (mean, total)): (f64, &(f64, f64))| {
            let within = total - between;
            let varies = *total > 1e-18 * mean * mean * rounds.len() as f64;
            (varies && within > 0.0).then(|| (between / (m - 1.0)) / (within / (m * (n as f64 - 1.0))))
        };
        between.into_iter().zip(&self.0).filter_map(f).reduce(f64::max)
    }
}

fn mean_and_variance(x: impl AsRef<[f64]>) -> (f64, f64) {
    let x = x.as_ref();
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (mean, x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// Moments over the halves of a stratum's chains in all replicas.
fn halves(replicas: &[Replica], stratum: usize) -> HalfChains {
    let mut all = HalfChains::default();
    replicas.iter().for_each(|r| all.merge(&r.strata[stratum].halves));
    all
}

/// Spread of b_j over replicas, relative to the standard error that they report, and the probability of so large a one.
fn b_spread(replicas: &[Replica], stratum: usize) -> Option<(f64, f64)> {
    let of = |r: &Replica| r.strata.get(stratum).map(|s| (s.b, s.b_stderr.powi(2)));
    let values: Vec<(f64, f64)> = replicas.iter().map(of).collect::<Option<_>>()?;
    let reported = values.iter().map(|v| v.1).sum::<f64>() / values.len() as f64;
    let (_, spread) = mean_and_variance(values.iter().map(|v| v.0).collect::<Vec<_>>());
    if !(reported > 0.0 && reported.is_finite()) {
        return None;
    }
    let freedom = values.len() as f64 - 1.0;
    let p = ChiSquared::new(freedom).map_or(1.0, |law| law.sf(freedom * spread / reported));
    Some(((spread / reported).sqrt(), p))
}

/// Replicas with seeds of their own that show the same image, which is not black.
fn repeated(replicas: &[Replica]) -> usize {
    let lit = |r: &Replica| r.pixels.iter().any(|&x| x != 0.0);
    (1..replicas.len())
        .filter(|&i| lit(&replicas[i]) && replicas[..i].iter().any(|earlier| earlier.pixels == replicas[i].pixels))
        .count()
}

impl Chains {
    /// The faults, each in a word and in a sentence.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        if self.repeated > 0 {
            let sentence =
                format!("{} replicas repeat another's image: their random numbers are the same", self.repeated);
            faults.push(Fault::new("seeds", sentence));
        }
        if let (Some(r_hat), Some(p)) = (self.r_hat, self.p_r_hat)
            && r_hat > DISAGREEMENT
            && p <= SIGNIFICANCE
        {
            let sentence =
                format!("rounds of a replica agree more than replicas do (split R-hat {r_hat:.2}, p = {p:.0e})");
            faults.push(Fault::new("rounds", sentence));
        }
        if let (Some(ratio), Some(p)) = (self.b_spread, self.p_b_spread)
            && ratio > UNDERSTATED
            && p < SIGNIFICANCE
        {
            let sentence = format!("a stratum's b scatters {ratio:.1} times as far as it says (p = {p:.0e})");
            faults.push(Fault::new("b", sentence));
        }
        faults
    }
}
