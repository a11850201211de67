//! The independent samples of a stratum in one round.

use super::{Generator, Importance, OwenSobol, Purpose, Stratum, generator, hilbert, uniform};
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Samples whose random numbers are the coordinates of the points of an Owen-scrambled Sobol sequence.
///
/// Each stratum and round scrambles it for itself: a sample is uniform by itself, those of a round are stratified together, and rounds
/// are independent. A sample is known by its number, so that a chosen one is made again instead of being stored.
#[derive(Debug)]
pub(super) struct Batch {
    numbers: OwenSobol,
}

impl Batch {
    pub(super) fn new(seed: u64, round: u64, stratum: usize) -> Self {
        Self { numbers: OwenSobol::new(generator(seed, Purpose::Sample, round, stratum as u64, 0).next_u64()) }
    }

    /// The first samples in the order of a Hilbert curve through their first two numbers, such as a point of the image.
    pub(super) fn order(&mut self, samples: u64) -> Vec<u32> {
        let place = |i| {
            self.numbers.go_to(i);
            [(); 2].map(|()| self.numbers.next_u32() >> (u32::BITS - hilbert::BITS))
        };
        hilbert::order((0..samples).map(place).collect::<Vec<_>>().into_par_iter())
    }

    /// Σ_states w I / p of a sample; `visit` sees each state and its part of the sum.
    #[inline]
    pub(super) fn weight<P>(
        &mut self,
        sample: u64,
        stratum: &impl Stratum<P>,
        importance: &impl Importance<P>,
        visit: &mut impl FnMut(&P, f64),
    ) -> f64 {
        let mut sum = 0.0;
        self.numbers.go_to(sample);
        stratum.sample(&mut self.numbers, &mut |path, weight| {
            let weight = weight * importance.eval(path);
            sum += weight;
            visit(path, weight);
        });
        sum
    }

    /// One state of a sample, drawn with `rng` in proportion to w I / p, and the sample's weight.
    pub(super) fn pick<P: Clone>(
        &mut self,
        sample: u64,
        stratum: &impl Stratum<P>,
        importance: &impl Importance<P>,
        rng: &mut Generator,
    ) -> (Option<P>, f64) {
        let (mut sum, mut picked) = (0.0, None);
        let weight = self.weight(sample, stratum, importance, &mut |path: &P, weight| {
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
    use super::super::bootstrap::Bootstrap;
    use super::*;
    use crate::engine::{Coverage, uniform_f32};

    /// [0, 1)³: a point of an image, and one of a light.
    struct Cube;

    impl Stratum<[f32; 3]> for Cube {
        fn contains(&self, _: &[f32; 3]) -> bool {
            true
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&[f32; 3], f64)) {
            visit(&[(); 3].map(|()| uniform_f32(rng)), 1.0);
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    /// State and weight of each sample, and which of them are starts.
    fn round(
        seed: u64,
        samples: u64,
        starts: u64,
        importance: fn(&[f32; 3]) -> f64,
    ) -> (Vec<[f32; 3]>, Bootstrap, Vec<u64>) {
        let (mut batch, mut states) = (Batch::new(seed, 0, 0), Vec::new());
        let weights = (0..samples).map(|i| batch.weight(i, &Cube, &importance, &mut |x, _| states.push(*x))).collect();
        let bootstrap = Bootstrap::new(weights, Coverage::default(), 0);
        let rng = &mut generator(seed, Purpose::Start, 0, 0, 0);
        let chosen = bootstrap.choose(starts, &batch.order(samples), rng);
        (states, bootstrap, chosen)
    }

    fn cells(states: impl Iterator<Item = [f32; 3]>, [w, h, d]: [usize; 3]) -> Vec<u32> {
        let mut cells = vec![0; w * h * d];
        for x in states {
            let [i, j, k] = [(0, w), (1, h), (2, d)].map(|(axis, n)| (x[axis] * n as f32) as usize);
            cells[(k * h + j) * w + i] += 1;
        }
        cells
    }

    #[test]
    fn samples_are_stratified_and_starts_spread_over_the_image() {
        for seed in 0..8 {
            let (states, _, chosen) = round(seed, 256, 16, |_| 1.0);
            for grid in [[16, 16, 1], [4, 64, 1], [1, 1, 256]] {
                assert!(cells(states.iter().copied(), grid).iter().all(|&n| n == 1), "{grid:?}");
            }
            // The image's halves, each with all of the light.
            assert!(cells(states.iter().copied(), [2, 1, 64]).iter().all(|&n| n == 2));
            assert!(cells(chosen.iter().map(|&i| states[i as usize]), [4, 4, 1]).iter().all(|&n| n == 1));
            // The negative control: every sixteenth sample in the order of their numbers.
            assert!(cells(states.iter().copied().step_by(16), [4, 4, 1]).iter().any(|&n| n != 1));
        }
    }

    #[test]
    fn a_sample_is_made_again() {
        let mut batch = Batch::new(3, 5, 1);
        let mut state = |i| {
            let rng = &mut generator(0, Purpose::Start, 0, 0, 0);
            batch.pick(i, &Cube, &|_: &[f32; 3]| 1.0, rng).0.expect("a state")
        };
        let first = [0, 1, 9].map(&mut state);
        assert_eq!([9, 0, 1].map(&mut state), [first[2], first[0], first[1]]);
        assert_ne!(first, [0, 1, 9].map(|i| round(4, 10, 1, |_| 1.0).0[i]));
    }

    /// z of the mean over rounds of b̂ times the mean of g(x) = x₀ x₂ over four starts of eight samples; b̂ is that of the starts' own
    /// batch, or of another one.
    fn z(another: u64) -> f64 {
        let importance: fn(&[f32; 3]) -> f64 = |x| f64::from(x[0] * x[1] * x[2]).powi(3);
        let n = 4000;
        let of_round = |seed: u64| {
            let (states, _, chosen) = round(seed, 8, 4, importance);
            let b = round(seed + another, 8, 4, importance).1.b();
            b * chosen.iter().map(|&i| states[i as usize]).map(|x| f64::from(x[0] * x[2])).sum::<f64>() / 4.0
        };
        let (sum, squares) = (0..n).map(of_round).fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let (mean, truth) = (sum / n as f64, 0.2 * 0.25 * 0.2);
        (mean - truth) / ((squares / n as f64 - mean * mean) / n as f64).sqrt()
    }

    #[test]
    fn starts_with_their_own_b_are_unbiased() {
        assert!(z(0).abs() < 4.0, "{}", z(0));
        // The negative control.
        assert!(z(1 << 20) < -4.0, "{}", z(1 << 20));
    }
}
