//! How a round is shared among the strata.

use super::{Measure, Share, Stratum};

/// Shortest useful chain, mutations.
pub const LEAST_CHAIN: u64 = 256;
/// Fewest independent samples of a stratum in a round.
pub const LEAST_SAMPLES: u64 = 64;

/// Samples of a stratum that the pilot found dark.
const DARK_SAMPLES: u64 = 32;
/// Longest chain of such a stratum: it is run only in a round whose samples find light.
const MOST_DARK: u64 = 1 << 13;
/// Mutations for each independent sample, unless their noise asks for more.
pub const MUTATIONS_PER_SAMPLE: u64 = 32;
/// Most independent samples of a round, as a share of its mutations.
const MOST_SAMPLES: f64 = 0.125;
/// Share of the mutations that goes by b_j alone, whatever the measured noise says.
const BY_B: f64 = 0.25;

/// n_j in proportion to power, but no chain shorter than [`LEAST_CHAIN`] where a round has room for that; one sample for
/// `mutations_per_sample` of them, [`MUTATIONS_PER_SAMPLE`] if nothing better is known.
pub fn shares_by_power<P>(strata: &[impl Stratum<P>], mutations: f64, mutations_per_sample: u64) -> Vec<Share> {
    let power: f64 = strata.iter().map(Stratum::power).sum();
    let parts: Vec<_> = strata.iter().map(|stratum| stratum.power() / power).collect();
    let room = strata.len() as f64 * LEAST_CHAIN as f64 <= 0.5 * mutations;
    let least = if room { LEAST_CHAIN as f64 } else { 1.0 };
    let weak = |part: f64| mutations * part < least;
    let strong: f64 = parts.iter().filter(|&&part| !weak(part)).sum();
    let rest = mutations - least * parts.iter().filter(|&&part| weak(part)).count() as f64;
    let share = |part: f64| {
        let mutations =
            if weak(part) || strong <= 0.0 { least } else { (rest * part / strong).round().max(least) } as u64;
        Share { mutations, samples: samples_for(mutations, mutations_per_sample) }
    };
    parts.into_iter().map(share).collect()
}

fn samples_for(mutations: u64, mutations_per_sample: u64) -> u64 {
    (mutations / mutations_per_sample.max(1)).max(LEAST_SAMPLES)
}

/// Shares that minimise Σ_j (chain_error_j / n_j · (1 + spread_j / m_j) + sample_error_j / m_j) where Σ n_j = `mutations`:
///
/// n_j = λ √(chain_error_j / mutation_cost_j),  m_j = λ √((sample_error_j + spread_j · chain_error_j / n_j) / sample_cost_j)
///
/// the first as if spread_j / m_j were small, the second so that it becomes so: the chains' noise in a round is b̂_j² times that of
/// their visits, and E[b̂_j²] = b_j² (1 + spread_j / m_j).
///
/// A quarter of n_j goes in proportion to b_j plus its standard error, since a noisy stratum may have looked quiet. No
/// m_j is ever below what is usual for n_j: an error of b_j is small in squares, but it is the same everywhere. No
/// stratum is left out: a dark one, b_j = 0, keeps a few samples a round, and its chain, of a length that `by_power` sets,
/// runs only if they find light; it is not part of Σ n_j. `mutations_per_sample`: what is usual.
pub fn allocate(measures: &[Measure], by_power: &[Share], mutations: f64, mutations_per_sample: u64) -> Vec<Share> {
    let noise = |m: &Measure| m.chain_error.map(|e| e / (m.b * m.b)).filter(|q| q.is_finite());
    let most_noise = measures.iter().filter_map(noise).fold(0.0, f64::max);
    // Of a stratum that hardly ever found light nothing better is known than the worst of the others.
    let error = |m: &Measure| noise(m).unwrap_or(if most_noise > 0.0 { most_noise } else { 1.0 }) * m.b * m.b;
    let by_noise: Vec<_> = measures.iter().map(|m| ideal(error(m), m.mutation_cost)).collect();
    let by_b: Vec<_> = measures.iter().map(|m| if m.b > 0.0 { m.b + m.b_stderr } else { 0.0 }).collect();
    let (noise_sum, b_sum): (f64, f64) = (by_noise.iter().sum(), by_b.iter().sum());
    if noise_sum <= 0.0 || b_sum <= 0.0 {
        return by_power.to_vec();
    }
    let length = |j: usize| {
        let part = BY_B * by_b[j] / b_sum + (1.0 - BY_B) * by_noise[j] / noise_sum;
        ((mutations * part).round() as u64).max(LEAST_CHAIN.min(mutations as u64)).max(1)
    };
    let samples = |(j, m): (usize, &Measure)| {
        let of_chains = m.spread * error(m) / length(j) as f64;
        mutations / noise_sum * ideal(m.sample_error + of_chains, m.sample_cost)
    };
    let samples: Vec<_> = measures.iter().enumerate().map(samples).collect();
    let excess = (samples.iter().sum::<f64>() / (MOST_SAMPLES * mutations)).max(1.0);
    let share = |(j, m): (usize, &Measure)| {
        if m.b <= 0.0 {
            let mutations = by_power[j].mutations.clamp(LEAST_CHAIN, MOST_DARK);
            return Share { mutations, samples: DARK_SAMPLES };
        }
        let usual = samples_for(length(j), mutations_per_sample);
        Share { mutations: length(j), samples: ((samples[j] / excess).round() as u64).max(usual) }
    };
    measures.iter().enumerate().map(share).collect()
}

/// √(error / cost).
fn ideal(error: f64, cost: f64) -> f64 {
    if error > 0.0 { (error / cost.max(1.0)).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(b: f64, error: f64, cost: f64) -> Measure {
        Measure { b, chain_error: Some(error), mutation_cost: cost, sample_cost: cost, ..Measure::default() }
    }

    const BY_POWER: Share = Share { mutations: 50_000, samples: 1000 };

    #[test]
    fn mutations_follow_noise_and_cost() {
        let measures = [measure(1.0, 1.0, 2.0), measure(1.0, 16.0, 2.0), measure(1.0, 16.0, 8.0)];
        let shares = allocate(&measures, &[BY_POWER; 3], 1e6, MUTATIONS_PER_SAMPLE);
        let n: Vec<_> = shares.iter().map(|s| s.mutations as f64 / 1e6).collect();
        for (n, ideal) in n.iter().zip([1.0 / 7.0, 4.0 / 7.0, 2.0 / 7.0]) {
            assert!((n - (0.25 / 3.0 + 0.75 * ideal)).abs() < 1e-5, "{n}");
        }
    }

    #[test]
    fn nothing_lit_is_starved_and_the_dark_costs_little() {
        let measures = [measure(1.0, 1.0, 1.0), measure(1e-9, 0.0, 1.0), measure(0.0, f64::NAN, 1.0)];
        let shares = allocate(&measures, &[BY_POWER; 3], 1e6, MUTATIONS_PER_SAMPLE);
        assert_eq!(shares[1], Share { mutations: LEAST_CHAIN, samples: LEAST_SAMPLES });
        assert_eq!(shares[2], Share { mutations: MOST_DARK, samples: DARK_SAMPLES });
        assert_eq!(shares[0].mutations, 1_000_000);
    }

    #[test]
    fn by_power_the_weak_get_the_shortest_useful_chain_if_there_is_room() {
        struct Part(f64);
        impl Stratum<()> for Part {
            fn contains(&self, _: &()) -> bool {
                true
            }
            fn sample(&self, _: &mut impl rand_pcg::rand_core::Rng, _: &mut impl FnMut(&(), f64)) {}
            fn density(&self, _: &()) -> f64 {
                1.0
            }
            fn power(&self) -> f64 {
                self.0
            }
        }
        let parts = [Part(1.0), Part(297.0), Part(2.0)];
        let n = |mutations| {
            shares_by_power(&parts, mutations, MUTATIONS_PER_SAMPLE).iter().map(|s| s.mutations).collect::<Vec<_>>()
        };
        assert_eq!(n(300_000.0), [1000, 297_000, 2000]);
        assert_eq!(n(10_000.0), [256, 9488, 256]);
        assert_eq!(n(300.0), [1, 297, 2]);
    }

    #[test]
    fn without_any_light_shares_stay_by_power() {
        assert_eq!(allocate(&[Measure::default(); 2], &[BY_POWER; 2], 1e6, MUTATIONS_PER_SAMPLE), [BY_POWER; 2]);
    }

    #[test]
    fn samples_follow_the_noise_of_b_and_have_a_limit() {
        let with = |sample_error| Measure { sample_error, ..measure(1.0, 1.0, 1.0) };
        let samples = |error| allocate(&[with(error); 2], &[BY_POWER; 2], 1e6, MUTATIONS_PER_SAMPLE)[0].samples;
        assert_eq!([0.0, 0.0001, 1e9].map(samples), [15_625, 15_625, 62_500]);
    }

    /// A stratum whose b̂ is uncertain makes its chains' noise larger; one whose samples all weigh alike does not.
    #[test]
    fn samples_follow_the_noise_that_they_bring_to_chains() {
        let with = |spread| Measure { spread, ..measure(1.0, 1.0, 1.0) };
        let shares = allocate(&[with(0.0), with(1e6)], &[BY_POWER; 2], 1e6, MUTATIONS_PER_SAMPLE);
        // m = λ √(spread / n) with λ = n = 500,000, more than a share of an eighth of the mutations.
        assert_eq!([shares[0].samples, shares[1].samples], [15_625, 125_000]);
        let shares = allocate(&[with(0.0), with(2e3)], &[BY_POWER; 2], 1e6, MUTATIONS_PER_SAMPLE);
        assert_eq!(shares[1].samples, 31_623);
    }
}
