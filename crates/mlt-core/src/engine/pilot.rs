//! Pilot rounds: what each stratum contributes, how noisy it is, and what that costs.

use super::{
    Deposits, Estimator, Importance, Metropolis, Mutation, Path, Share, Splat, Stratum, StratumStats, Tally, Watch,
    metropolis::Prepared,
};
use rayon::prelude::*;
use std::ops::Range;

/// Number of the first pilot round: pilot and production rounds share no random numbers.
pub const PILOT: u64 = 1 << 55;

/// Number of the round whose samples tell their spread, and go into no image and no pilot.
const SPREAD: u64 = PILOT << 1;

/// Measurement of one stratum by pilot rounds.
///
/// With n mutations and m independent samples in a round, the stratum leaves the error
/// Σ_p w_p Var(X_jp) ≈ chain_error / n · (1 + spread / m) + sample_error / m in the image, w being weights of the sites, and costs
/// n · mutation_cost + m · sample_cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    /// b_j.
    pub b: f64,
    /// Standard error of `b`.
    pub b_stderr: f64,
    /// b_j² σ_j² τ_j: n Σ_p w_p Var over rounds, from the chains' visits alone; `None` if fewer than two rounds found light.
    pub chain_error: Option<f64>,
    /// How well `chain_error` is known: the number of equal events, each of which may come or not, that would spread as
    /// the rounds' shares of it do; infinite if it is known exactly.
    pub chain_events: f64,
    /// Σ_p w_p μ_jp² times the variance of one sample's weight over b_j², μ_jp the stratum's image.
    pub sample_error: f64,
    /// Variance of one sample's weight over b_j².
    pub spread: f64,
    /// Work of a mutation.
    pub mutation_cost: f64,
    /// Work of an independent sample.
    pub sample_cost: f64,
}

impl Measure {
    /// The error that a share leaves.
    pub fn error(&self, share: &Share) -> f64 {
        let [n, m] = [share.mutations, share.samples].map(|count| count.max(1) as f64);
        self.chain_error.unwrap_or(0.0) / n * (1.0 + self.spread / m) + self.sample_error / m
    }

    /// Expected measurement of the union of disjoint strata, as one stratum whose chains visit each in proportion to its b.
    pub fn of_union(parts: &[Self]) -> Self {
        let sum = |value: &dyn Fn(&Self) -> f64| -> f64 { parts.iter().map(value).sum() };
        let b = sum(&|m| m.b);
        let measured = parts.iter().any(|m| m.chain_error.is_some());
        let noise = |m: &Self| m.chain_error.filter(|_| m.b > 0.0).map_or(0.0, |error| error * b / m.b);
        let most = |value: fn(&Self) -> f64| parts.iter().map(value).fold(0.0, f64::max);
        let mutation_cost = if b > 0.0 { sum(&|m| m.b * m.mutation_cost) / b } else { most(|m| m.mutation_cost) };
        Self {
            b,
            b_stderr: sum(&|m| m.b_stderr * m.b_stderr).sqrt(),
            chain_error: measured.then(|| sum(&noise)),
            chain_events: parts.iter().map(|m| m.chain_events).fold(f64::INFINITY, f64::min),
            sample_error: sum(&|m| m.sample_error),
            // As if the weights of their samples were uncorrelated.
            spread: if b > 0.0 { sum(&|m| m.spread * m.b * m.b) / (b * b) } else { 0.0 },
            mutation_cost,
            sample_cost: most(|m| m.sample_cost),
        }
    }
}

/// Findings of pilot rounds.
#[derive(Debug, Default)]
pub struct Piloted {
    /// Of each stratum.
    pub measures: Vec<Measure>,
    /// Of each stratum: the sites that its chains lit, and the sum over channels that they gave them in the mean over rounds.
    pub images: Vec<Vec<(u32, f64)>>,
    /// Counts of the rounds.
    pub tally: Tally,
}

/// Share of a pilot round that its independent samples take, about: for those who watch it.
const SHARE_OF_STARTS: f64 = 0.3;

/// Visits of a stratum's chains in one round to one site, as a share of all: deposits over b̂_j.
#[derive(Clone, Copy)]
struct Visits {
    site: u32,
    round: u64,
    share: f64,
}

/// Mean and variance over rounds at one site.
struct Moments {
    site: u32,
    mean: f64,
    variance: f64,
}

impl<P, S, M, I> Metropolis<'_, P, S, M, I> {
    /// Σ_j V_j / Σ_j b_j², V_j being the variance of one independent sample's weight, from a round's samples that go into
    /// no image; `None` if they found no light. And the work that they took. Nothing if it is stopped.
    pub fn spread(&self, watch: Watch) -> Option<(Option<f64>, u64)>
    where
        P: Path,
        S: Stratum<P> + Sync,
        I: Importance<P> + Sync,
        Self: Sync,
    {
        let mut total = [0.0; 2];
        let mut work = 0;
        for bootstrap in self.bootstraps(SPREAD, watch)? {
            let mut stats = StratumStats::default();
            bootstrap.count(&mut stats);
            // E[b̂²] = b² + V/m.
            let variance = stats.weight_variance();
            let square = stats.b() * stats.b() - variance / stats.samples as f64;
            total = [total[0] + variance, total[1] + square];
            work += stats.sample_work;
        }
        let [variance, square] = total;
        Some(((square > 0.0).then_some(variance / square), work))
    }

    /// Runs rounds that go into no image, and measures. `weigh` makes the weights w from the image (sums over channels)
    /// of these rounds. Nothing if it is stopped.
    pub fn pilot<const C: usize>(
        &self,
        sites: u32,
        rounds: Range<u64>,
        weigh: &dyn Fn(&[f64]) -> Vec<f64>,
        watch: Watch,
    ) -> Option<Piloted>
    where
        P: Path<Splat = Splat<C>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
        Self: Estimator<C, Prepared = Prepared, Task = (usize, StratumStats), Tally = Tally>,
    {
        let count = rounds.end.saturating_sub(rounds.start);
        let (tally, visits) = self.visit(sites, rounds, watch)?;
        let lit_rounds = |stats: &StratumStats| count - stats.dark_rounds;
        let moments: Vec<_> =
            (visits.par_iter().zip(&tally.strata)).map(|(visits, stats)| moments(visits, lit_rounds(stats))).collect();
        let images: Vec<Vec<_>> = (tally.strata.iter().zip(&moments))
            .map(|(stats, moments)| moments.iter().map(|m| (m.site, stats.b() * m.mean)).collect())
            .collect();
        let mut image = vec![0.0; sites as usize];
        images.iter().flatten().for_each(|&(site, value)| image[site as usize] += value);
        let weights = weigh(&image);
        let strata = self.strata.iter().zip(&tally.strata);
        let measures = strata
            .zip(visits.iter().zip(&moments))
            .map(|(((_, share), stats), (visits, moments))| {
                measure(share.mutations, stats, (visits, moments), lit_rounds(stats), &weights)
            })
            .collect();
        Some(Piloted { measures, images, tally })
    }

    /// Runs rounds that go into no image: their counts, and the visits of each stratum, in order of the sites.
    fn visit<const C: usize>(&self, sites: u32, rounds: Range<u64>, watch: Watch) -> Option<(Tally, Vec<Vec<Visits>>)>
    where
        P: Path<Splat = Splat<C>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        I: Importance<P> + Sync,
        Self: Estimator<C, Prepared = Prepared, Task = (usize, StratumStats), Tally = Tally>,
    {
        let (mut tally, mut visits) = (Tally::default(), Vec::new());
        visits.resize_with(self.strata.len(), Vec::new);
        let count = rounds.end.saturating_sub(rounds.start);
        for (made, round) in (0..count).zip(rounds) {
            let watch = watch.part(made as f64 / count as f64, (made + 1) as f64 / count as f64);
            let prepared = self.prepared(round, watch.part(0.0, SHARE_OF_STARTS))?;
            let tasks = self.tasks(&prepared);
            let pieces = watch.part(SHARE_OF_STARTS, 1.0).pieces(tasks);
            let run = |task| {
                pieces.unless_stopped(|| {
                    let mut deposits = Deposits::new(sites, 31);
                    (self.run(&prepared, task, &mut deposits), deposits.sums())
                })
            };
            let ran = (0..tasks).into_par_iter().map(run).collect::<Option<Vec<_>>>()?;
            let (tallies, sums): (Vec<_>, Vec<_>) = ran.into_iter().unzip();
            for (task, sums) in sums.into_iter().enumerate() {
                let (stratum, b) = prepared.chain(task);
                visits[stratum].extend(sums.into_iter().map(|(site, sum)| Visits { site, round, share: sum / b }));
            }
            self.tally(&mut tally, &prepared, tallies);
            self.tally_round(&mut tally, &prepared);
        }
        Some((tally, visits.into_par_iter().map(by_site).collect()))
    }
}

/// In order of the sites, with those of all chains of a round as one.
fn by_site(mut visits: Vec<Visits>) -> Vec<Visits> {
    visits.sort_by_key(|v| (v.site, v.round));
    let same = |a: &Visits, b: &Visits| (a.site, a.round) == (b.site, b.round);
    let sum = |v: &[Visits]| Visits { share: v.iter().map(|v| v.share).sum(), ..v[0] };
    visits.chunk_by(same).map(sum).collect()
}

fn moments(visits: &[Visits], rounds: u64) -> Vec<Moments> {
    let at_site = |visits: &[Visits]| {
        let (sum, squares) = visits.iter().fold((0.0, 0.0), |(s, q), v| (s + v.share, q + v.share * v.share));
        let mean = sum / rounds as f64;
        let variance = (squares - sum * mean).max(0.0) / (rounds as f64 - 1.0).max(1.0);
        Moments { site: visits[0].site, mean, variance }
    };
    visits.chunk_by(|a, b| a.site == b.site).map(at_site).collect()
}

fn measure(
    mutations: u64,
    stats: &StratumStats,
    (visits, moments): (&[Visits], &[Moments]),
    rounds: u64,
    weights: &[f64],
) -> Measure {
    let b = stats.b();
    let weighted =
        |value: fn(&Moments) -> f64| -> f64 { moments.iter().map(|m| weights[m.site as usize] * value(m)).sum() };
    let variance = weighted(|m| m.variance);
    // The noise of the means is in their squares too.
    let square = (weighted(|m| m.mean * m.mean) - variance / rounds.max(1) as f64).max(0.0);
    let each = |work: u64, count: u64| work as f64 / count.max(1) as f64;
    Measure {
        b,
        b_stderr: stats.b_stderr(),
        chain_error: (rounds > 1).then_some(b * b * variance * mutations as f64),
        chain_events: chain_events(visits, moments, rounds, weights),
        sample_error: square * stats.weight_variance(),
        spread: if b > 0.0 { stats.weight_variance() / (b * b) } else { 0.0 },
        mutation_cost: each(stats.chain_work, stats.steps()),
        sample_cost: each(stats.sample_work, stats.samples),
    }
}

/// [`Measure::chain_events`], from d_r = Σ_p w_p (X_pr − μ_p)² of each round r.
fn chain_events(visits: &[Visits], moments: &[Moments], rounds: u64, weights: &[f64]) -> f64 {
    let unlit: f64 = moments.iter().map(|m| weights[m.site as usize] * m.mean * m.mean).sum();
    let mut deviations: Vec<(u64, f64)> = Vec::new();
    for (visits, m) in visits.chunk_by(|a, b| a.site == b.site).zip(moments) {
        for v in visits {
            let more = weights[m.site as usize] * v.share * (v.share - 2.0 * m.mean);
            match deviations.iter_mut().find(|(round, _)| *round == v.round) {
                Some((_, sum)) => *sum += more,
                None => deviations.push((v.round, unlit + more)),
            }
        }
    }
    events(deviations.into_iter().map(|(_, d)| d).chain(std::iter::repeat(unlit)).take(rounds as usize))
}

/// How many equal events, each of which comes or not by Poisson's law, would vary as a sum of independent values of one law
/// does: one over its relative variance; infinite if all values are the same.
///
/// The mean of n values x has the relative variance n/(n − 1) (Σ x²/(Σ x)² − 1/n).
pub fn events(values: impl Iterator<Item = f64>) -> f64 {
    let (n, sum, squares) = values.fold((0.0, 0.0, 0.0), |(n, s, q), x| (n + 1.0, s + x, q + x * x));
    let variance = n / (n - 1.0) * (squares / (sum * sum) - 1.0 / n);
    if variance > 0.0 { variance.recip() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{
        Accumulated, Film, MUTATIONS_PER_SAMPLE, Mixture, allocate, render, shares_by_power, uniform, with_shares,
    };
    use rand_pcg::rand_core::Rng;
    use std::ops::ControlFlow;

    /// x in [0, 1), in one of four strata; it lights one of 16 sites with I(x), which is 0 in the second stratum.
    #[derive(Clone)]
    struct Point(f64);

    const BRIGHT: [f64; 4] = [0.01, 0.0, 1.0, 0.3];

    fn importance(x: &Point) -> f64 {
        BRIGHT[(4.0 * x.0) as usize] * (1.0 + (10.0 * x.0).sin().powi(2))
    }

    impl Path for Point {
        type Splat = Splat<1>;

        fn splats(&self) -> impl Iterator<Item = Splat<1>> {
            std::iter::once(Splat { site: (16.0 * self.0) as u32, value: [importance(self)] })
        }
    }

    /// A quarter of [0, 1). `exaggerated`: a factor of its samples' weights that has no business there.
    struct Quarter {
        index: u32,
        power: f64,
        exaggerated: f64,
    }

    impl Stratum<Point> for Quarter {
        fn contains(&self, x: &Point) -> bool {
            (4.0 * x.0) as u32 == self.index
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&Point, f64)) {
            visit(&Point(0.25 * (f64::from(self.index) + uniform(rng))), 0.25 * self.exaggerated);
        }

        fn density(&self, _: &Point) -> f64 {
            4.0
        }

        fn power(&self) -> f64 {
            self.power
        }
    }

    struct Step;

    impl Mutation<Point, Quarter> for Step {
        fn name(&self) -> &'static str {
            "step"
        }

        fn propose(&self, current: &Point, proposal: &mut Point, _: &Quarter, rng: &mut impl Rng) -> Option<f64> {
            proposal.0 = (current.0 + 0.1 * (uniform(rng) - 0.5)).rem_euclid(1.0);
            Some(1.0)
        }
    }

    const MUTATIONS: f64 = 20_000.0;

    fn strata(exaggerated: [f64; 4]) -> Vec<Quarter> {
        // By power, the darkest strata look the brightest.
        let quarter = |(index, (power, exaggerated))| Quarter { index, power, exaggerated };
        (0..).zip([30.0, 60.0, 1.0, 1.0].into_iter().zip(exaggerated)).map(quarter).collect()
    }

    fn with_estimator<T>(
        strata: Vec<Quarter>,
        shares: &[Share],
        run: impl FnOnce(&Metropolis<Point, Quarter, Step, fn(&Point) -> f64>) -> T,
    ) -> T {
        let (mixture, importance) = (Mixture::new(vec![Step]), importance as fn(&Point) -> f64);
        let strata = with_shares(strata, shares).expect("a share for each");
        run(&Metropolis::new(&strata, &mixture, &importance, 5).expect("sound"))
    }

    fn measured(rounds: u64) -> (Vec<Measure>, Vec<Share>) {
        let strata = strata([1.0; 4]);
        let shares = shares_by_power(&strata, MUTATIONS, MUTATIONS_PER_SAMPLE);
        let weigh = |image: &[f64]| vec![1.0; image.len()];
        let Piloted { measures, .. } = with_estimator(strata, &shares, |e| {
            e.pilot(16, PILOT..PILOT + rounds, &weigh, Watch::NEVER).expect("nothing stops it")
        });
        let fitted = allocate(&measures, &shares, MUTATIONS, MUTATIONS_PER_SAMPLE);
        (measures, fitted)
    }

    #[test]
    fn the_spread_is_the_strata_s_variance_over_their_b_squared() {
        let shares = [Share { mutations: 1, samples: 20_000 }; 4];
        let moments = |j: u32| {
            let weights =
                (0..1000).map(|i| importance(&Point((f64::from(j) + (f64::from(i) + 0.5) / 1000.0) / 4.0)) / 4.0);
            let [sum, squares] = weights.fold([0.0, 0.0], |[s, q], w| [s + w, q + w * w]);
            [sum / 1000.0, squares / 1000.0 - sum * sum / 1e6]
        };
        let of = |part: usize| (0..4).map(|j| moments(j)[part].powi(2 - part as i32)).sum::<f64>();
        let (spread, _) =
            with_estimator(strata([1.0; 4]), &shares, |e| e.spread(Watch::NEVER)).expect("nothing stops it");
        let (found, exact) = (spread.expect("light"), of(1) / of(0));
        assert!((found / exact - 1.0).abs() < 0.04, "{found}, exactly {exact}");
        let dark = strata([1.0; 4]).drain(1..2).collect();
        assert_eq!(with_estimator(dark, &shares[1..2], |e| e.spread(Watch::NEVER)).map(|found| found.0), Some(None));
    }

    /// Means and standard errors of the sites after many rounds with the given shares.
    fn image(exaggerated: [f64; 4], shares: &[Share]) -> Vec<(f64, f64)> {
        let mut sums = Accumulated::new(Film::<1>::new(16, 0.1));
        with_estimator(strata(exaggerated), shares, |e| {
            render(e, 0..200, &mut sums, &mut |_, _| ControlFlow::Continue(()))
        });
        (0..16).map(|i| sums.film().pixel(i)[0]).map(|p| (p.mean, p.stderr)).collect()
    }

    fn exact(site: usize) -> f64 {
        let at = |i: u32| (site as f64 + (f64::from(i) + 0.5) / 1000.0) / 16.0;
        (0..1000).map(|i| importance(&Point(at(i))) / 16_000.0).sum()
    }

    fn worst_z(image: &[(f64, f64)]) -> f64 {
        let z = |(i, &(mean, error)): (usize, &(f64, f64))| (mean - exact(i)).abs() / error.max(1e-12);
        image.iter().enumerate().map(z).fold(0.0, f64::max)
    }

    #[test]
    fn fitted_shares_keep_the_mean_and_lower_the_noise() {
        let (measures, fitted) = measured(8);
        for (j, m) in measures.iter().enumerate() {
            let b: f64 = (4 * j..4 * j + 4).map(exact).sum();
            assert!((m.b - b).abs() < 5.0 * m.b_stderr + 1e-12, "{m:?}");
        }
        assert!(fitted[2].mutations > fitted[3].mutations && fitted[3].mutations > fitted[0].mutations, "{fitted:?}");
        let (by_power, adapted) = (
            image([1.0; 4], &shares_by_power(&strata([1.0; 4]), MUTATIONS, MUTATIONS_PER_SAMPLE)),
            image([1.0; 4], &fitted),
        );
        assert!(worst_z(&by_power) < 4.0 && worst_z(&adapted) < 4.0);
        let noise = |image: &[(f64, f64)]| image.iter().map(|(_, error)| error * error).sum::<f64>();
        assert!(noise(&adapted) < 0.1 * noise(&by_power), "{} and {}", noise(&adapted), noise(&by_power));
    }

    /// The negative control: a stratum's deposits over N/K, the mean of n_j, in place of n_j.
    #[test]
    fn shares_that_are_not_divided_out_are_found() {
        let (_, fitted) = measured(8);
        let mean = fitted.iter().map(|s| s.mutations as f64).sum::<f64>() / 4.0;
        let wrong = std::array::from_fn(|j| fitted[j].mutations as f64 / mean);
        assert!(worst_z(&image(wrong, &fitted)) > 20.0);
    }

    /// chain_error / n predicts the variance that a round with n mutations has.
    #[test]
    fn the_predicted_noise_is_the_noise() {
        let (measures, _) = measured(64);
        let shares = shares_by_power(&strata([1.0; 4]), MUTATIONS, MUTATIONS_PER_SAMPLE);
        let rendered = image([1.0; 4], &shares);
        for j in [0, 2, 3] {
            let Share { mutations: n, samples: m } = shares[j];
            let chain = measures[j].chain_error.expect("measured") / n as f64;
            let variance = chain + measures[j].sample_error / m as f64;
            let seen: f64 = rendered[4 * j..4 * j + 4].iter().map(|(_, error)| 200.0 * error * error).sum();
            assert!((seen / variance - 1.0).abs() < 0.5, "stratum {j}: {seen:e} against {variance:e}");
        }
        assert_eq!((measures[1].b, measures[1].chain_error), (0.0, None));
    }
}
