//! Independent samples of a stratum: its b_j, and where its chains start.

use super::count::add_count;
use super::{Coverage, Generator, Importance, Purpose, Stratum, StratumStats, generator, uniform};

/// Importance weights of the independent samples of one stratum in one round.
///
/// Sample i has a random stream of its own, so a chosen sample is made again instead of being stored.
#[derive(Debug)]
pub(super) struct Bootstrap {
    /// Σ_states w I / p of each sample.
    weights: Vec<f64>,
    /// Their sum.
    total: f64,
    /// How many weights were not finite; they are 0 in `weights`.
    non_finite: u64,
    /// Where some of the states lie.
    coverage: Coverage,
    /// Their cost.
    work: u64,
}

impl Bootstrap {
    pub(super) fn new(mut weights: Vec<f64>, coverage: Coverage, work: u64) -> Self {
        let mut non_finite = 0;
        for weight in &mut weights {
            if !(weight.is_finite() && *weight >= 0.0) {
                *weight = 0.0;
                non_finite += 1;
            }
        }
        Self { total: weights.iter().sum(), weights, non_finite, coverage, work }
    }

    /// b̂_j = mean weight.
    pub(super) fn b(&self) -> f64 {
        if self.weights.is_empty() { 0.0 } else { self.total / self.weights.len() as f64 }
    }

    /// Weight of a sample.
    pub(super) fn weight(&self, sample: u64) -> f64 {
        self.weights[sample as usize]
    }

    /// Adds a round's samples to the counts of their stratum.
    pub(super) fn count(&self, stats: &mut StratumStats) {
        add_count(&mut stats.samples, self.weights.len() as u64);
        stats.weight_sum.add(self.total);
        stats.weight_squares.add(self.weights.iter().map(|w| w * w).sum());
        add_count(&mut stats.non_finite_samples, self.non_finite);
        add_count(&mut stats.sample_work, self.work);
        add_count(&mut stats.rounds, 1);
        add_count(&mut stats.dark_rounds, u64::from(self.b() == 0.0));
        stats.coverage.merge(&self.coverage);
    }

    /// Draws `count` samples in proportion to their weights, by systematic resampling: sample i is drawn
    /// ⌊count · w_i/Σw⌋ or one more times. Empty if all weights are 0.
    pub(super) fn choose(&self, count: u64, rng: &mut Generator) -> Vec<u64> {
        let total = self.total;
        if total <= 0.0 {
            return Vec::new();
        }
        let step = total / count as f64;
        let mut next = uniform(rng) * step;
        let mut chosen = Vec::with_capacity(count as usize);
        let mut cumulative = 0.0;
        for (i, &weight) in self.weights.iter().enumerate() {
            cumulative += weight;
            while next < cumulative && (chosen.len() as u64) < count {
                chosen.push(i as u64);
                next += step;
            }
        }
        chosen
    }
}

/// Which sample of which render.
#[derive(Clone, Copy)]
pub(super) struct SampleKey {
    pub(super) seed: u64,
    pub(super) round: u64,
    pub(super) stratum: u64,
    pub(super) sample: u64,
}

impl SampleKey {
    fn generator(self, purpose: Purpose) -> Generator {
        generator(self.seed, purpose, self.round, self.stratum, self.sample)
    }

    /// Σ_states w I / p of this sample; `visit` sees each state and its part of the sum.
    #[inline]
    pub(super) fn weight<P>(
        self,
        stratum: &impl Stratum<P>,
        importance: &impl Importance<P>,
        visit: &mut impl FnMut(&P, f64),
    ) -> f64 {
        let mut sum = 0.0;
        stratum.sample(&mut self.generator(Purpose::Sample), &mut |path, weight| {
            let weight = weight * importance.eval(path);
            sum += weight;
            visit(path, weight);
        });
        sum
    }

    /// One state of this sample, drawn with `rng` in proportion to w I / p, and the sample's weight.
    pub(super) fn pick<P: Clone>(
        self,
        stratum: &impl Stratum<P>,
        importance: &impl Importance<P>,
        rng: &mut Generator,
    ) -> (Option<P>, f64) {
        let (mut sum, mut picked) = (0.0, None);
        let weight = self.weight(stratum, importance, &mut |path: &P, weight| {
            sum += weight;
            if weight > 0.0 && uniform(rng) * sum < weight {
                picked = Some(path.clone());
            }
        });
        (picked, weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_drawn_in_proportion_to_weight() {
        let bootstrap = Bootstrap::new(vec![0.0, 1.0, f64::NAN, 2.5, 0.5, f64::INFINITY], Coverage::default(), 0);
        assert_eq!(bootstrap.non_finite, 2);
        let mut counts = [0f64; 6];
        for round in 0..2000 {
            let mut rng = generator(1, Purpose::Start, round, 0, 0);
            let chosen = bootstrap.choose(3, &mut rng);
            assert_eq!(chosen.len(), 3);
            chosen.iter().for_each(|&i| counts[i as usize] += 1.0);
        }
        for (count, weight) in counts.iter().zip([0.0, 1.0, 0.0, 2.5, 0.5, 0.0]) {
            let expected = 6000.0 * weight / 4.0;
            assert!((count - expected).abs() < 4.0 * 1500f64.sqrt(), "{counts:?}");
        }
    }

    #[test]
    fn a_dark_batch_starts_nothing() {
        let bootstrap = Bootstrap::new(vec![0.0; 5], Coverage::default(), 0);
        assert!(bootstrap.choose(4, &mut generator(0, Purpose::Start, 0, 0, 0)).is_empty());
        assert_eq!(bootstrap.b(), 0.0);
    }
}
