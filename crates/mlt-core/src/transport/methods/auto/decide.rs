//! From errors and costs to numbers of samples and the work of chains.

use super::constants::{DOUBT, FEW, GAIN, LEAST_CHAIN_WORK, WORK};

/// Path tracing in one of the ways in which it may take its share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Walks that go on from the first surface.
    pub(super) branches: u32,
    /// Most edges of a path.
    pub(super) max_edges: usize,
    /// Work of a sample.
    pub(super) work: f64,
    /// Error of one sample a pixel in its share of paths of at most two edges, and of longer ones.
    pub(super) errors: [f64; 2],
    /// The error that it would leave besides, if it were alone.
    pub(super) tail: f64,
    /// Error × work of the chains that take the others' share.
    pub(super) chains: f64,
}

/// The work of a round, by its parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    pub(super) candidate: Candidate,
    /// Samples of each pixel.
    pub(super) samples: f64,
    /// Work of chains for each pixel; 0: path tracing alone.
    pub(super) chain_work: f64,
    /// Error × work to be expected.
    pub(super) product: f64,
}

impl Candidate {
    /// Error that n samples a pixel leave, `usual` being the number that errors were measured with. What comes to the first surface at once is
    /// well stratified: its variance falls as n^(−3/2).
    fn error(&self, n: f64, usual: f64) -> f64 {
        let [short, long] = self.errors;
        (short * (usual / n).sqrt() + long) / n
    }

    /// Path tracing alone with n samples a pixel.
    fn alone(self, n: f64, usual: f64) -> Decision {
        let product = (self.error(n, usual) + self.tail / n) * n * self.work;
        Decision { candidate: self, samples: n, chain_work: 0.0, product }
    }

    /// With chains, which get what n samples leave of the work.
    fn with_chains(self, n: f64, usual: f64, budget: f64) -> Option<Decision> {
        let chain_work = (budget - n * self.work).max(LEAST_CHAIN_WORK * budget);
        let work = n * self.work + chain_work;
        let product = (self.error(n, usual) + self.chains / chain_work) * work;
        fits(work, budget).then_some(Decision { candidate: self, samples: n, chain_work, product })
    }
}

fn fits(work: f64, budget: f64) -> bool {
    (WORK[0]..=WORK[1]).contains(&(work / budget))
}

/// The best alone, and the best with chains, for the work of `usual` samples a pixel of the first candidate. Numbers of samples are powers of two,
/// but for the one that was asked for.
pub(super) fn decide(candidates: &[Candidate], usual: f64) -> [Decision; 2] {
    let budget = usual.max(1.0) * candidates[0].work;
    let powers = || (0..20).map(|i| f64::from(1u32 << i));
    let best = |of: &mut dyn Iterator<Item = Decision>| of.min_by(|a, b| a.product.total_cmp(&b.product));
    let alone = candidates.iter().enumerate().filter_map(|(i, candidate)| {
        let power = (budget / candidate.work).log2().round();
        let n = if i == 0 { usual } else { power.exp2() };
        (i == 0 || power >= 0.0).then(|| candidate.alone(n, usual))
    });
    let mixed = candidates.iter().flat_map(|c| powers().filter_map(|n| c.with_chains(n, usual, budget)));
    let alone = best(&mut { alone }).expect("the first is there");
    [alone, best(&mut { mixed }).unwrap_or(alone)]
}

/// The better of both. Where most of what path tracing leaves alone is what chains tell, and its samples meet that fewer than [`FEW`] times a
/// round (`met`), both together are taken in doubt.
pub(super) fn better([alone, mixed]: [Decision; 2], met: f64) -> Decision {
    let Candidate { errors, tail, .. } = alone.candidate;
    let factor = if tail > errors.iter().sum() && met < FEW { DOUBT } else { GAIN };
    if mixed.product < factor * alone.product { mixed } else { alone }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMPS: Candidate =
        Candidate { branches: 1, max_edges: 1, work: 1.0, errors: [0.0; 2], tail: f64::INFINITY, chains: 500.0 };

    fn candidate(error: f64, tail: f64, chains: f64) -> Candidate {
        Candidate { branches: 1, max_edges: 9, work: 5.0, errors: [0.0, error], tail, chains }
    }

    #[test]
    fn what_samples_find_easy_is_theirs() {
        let [alone, mixed] = decide(&[candidate(1.0, 0.1, 5.0), LAMPS], 64.0);
        assert!(alone.product < mixed.product && alone.samples == 64.0 && alone.chain_work == 0.0);
        assert!((alone.product / (1.1 * 5.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rare_light_is_for_chains() {
        let [alone, mixed] = decide(&[candidate(1.0, 1e4, 5.0), LAMPS], 64.0);
        assert!(mixed.product < 25.0 && alone.product > 1e4);
        assert_eq!((mixed.candidate.max_edges, mixed.samples), (9, 32.0));
    }

    #[test]
    fn where_all_light_is_rare_samples_take_lamps_only() {
        let [_, mixed] = decide(&[candidate(9.0, 1e5, 450.0), LAMPS], 64.0);
        assert_eq!(mixed.candidate.max_edges, 1);
        assert!(mixed.chain_work > 0.9 * 64.0 * 5.0);
    }

    /// A camera's ray may go on as eight walks of many rays each: half of a sample is no sample.
    #[test]
    fn branches_that_miss_the_budget_are_not_taken() {
        let eight = Candidate { branches: 8, work: 33.0, errors: [0.0, 0.1], ..candidate(0.0, 0.0, 1e9) };
        let [alone, _] = decide(&[candidate(9.0, 0.0, 1e9), eight], 4.0);
        assert_eq!((alone.candidate.branches, alone.samples), (1, 4.0));
        assert_eq!(decide(&[candidate(9.0, 0.0, 1e9), eight], 32.0)[0].candidate.branches, 8);
    }

    #[test]
    fn what_is_in_doubt_is_for_both() {
        let chosen =
            |error, tail, chains, met| better(decide(&[candidate(error, tail, chains)], 64.0), met).chain_work > 0.0;
        assert!(chosen(1.0, 0.9, 0.1, 1.0) && !chosen(1.0, 0.9, 5.0, 1.0));
        assert!(chosen(1.0, 20.0, 60.0, 1.0) && !chosen(1.0, 20.0, 1000.0, 1.0));
        // What samples meet often is no matter of doubt.
        assert!(chosen(1.0, 20.0, 1.0, 100.0) && !chosen(1.0, 20.0, 60.0, 100.0));
    }

    #[test]
    fn branches_pay_where_long_paths_are_noisy() {
        let four = Candidate { branches: 4, work: 14.0, errors: [0.01, 0.25], tail: 0.0, ..candidate(0.0, 0.0, 1e9) };
        let one = Candidate { branches: 1, errors: [0.01, 1.0], ..candidate(0.0, 0.0, 1e9) };
        assert_eq!(decide(&[one, four], 64.0)[0].candidate.branches, 4);
        let direct = Candidate { errors: [1.0, 0.01], ..one };
        assert_eq!(decide(&[direct, Candidate { errors: [1.0, 0.0], ..four }], 64.0)[0].candidate.branches, 1);
    }

    #[test]
    fn rounds_keep_to_their_work() {
        for usual in [1.0, 3.0, 40.0] {
            for chains in [0.01, 1.0, 100.0] {
                let [_, mixed] = decide(&[candidate(1.0, 9.0, chains), LAMPS], usual);
                let work = mixed.samples * mixed.candidate.work + mixed.chain_work;
                assert!((WORK[0]..=WORK[1]).contains(&(work / (5.0 * usual))), "{mixed:?}");
                assert!(mixed.chain_work >= LEAST_CHAIN_WORK * 5.0 * usual);
            }
        }
    }
}
