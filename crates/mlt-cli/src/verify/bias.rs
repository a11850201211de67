//! Whether two methods have the same mean image: Welch's t-test by region, corrected for their number.

use mlt_core::engine::Grid;
use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::evidence::Evidence;

/// Chance that a right method is found wrong.
pub const SIGNIFICANCE: f64 = 1e-3;
/// Resamples of the bootstrap.
const RESAMPLES: usize = 999;
/// Bars of the histogram of p-values.
const BARS: usize = 10;
/// Error that is injected.
const INJECTED: f64 = 0.01;
/// Quantile of the normal distribution at 0.8: with this much more than the critical value, four in five are caught.
const FOUR_IN_FIVE: f64 = 0.841_6;
/// Values that differ by less, relative to the image's mean, are rounding.
const ROUNDING: f64 = 1e-6;

/// Result of the comparison.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Bias {
    /// Probability of so large a difference if there is none, corrected for the number of regions (Holm).
    pub p: f64,
    /// The same from a bootstrap of the largest t, which knows of skewed replicas and of regions that vary together.
    pub p_bootstrap: f64,
    /// Column and row of the region that differs most; `None`: the whole image.
    pub region: Option<[usize; 2]>,
    /// Its difference from the reference, relative to it.
    pub difference: f64,
    /// Difference of the image's mean, relative to the reference's.
    pub image_difference: f64,
    /// Standard error of that.
    pub image_stderr: f64,
    /// Share of that variance that is the reference's.
    pub reference_share: f64,
    /// Number of regions by p-value, ten bars from 0 to 1.
    pub histogram: [usize; BARS],
    /// Probability of p-values so far from uniform, by Kolmogorov's distance, if there is no difference.
    pub p_uniform: f64,
    /// The smallest relative error of the whole image that would be found in four of five studies.
    pub visible: f64,
    /// The smallest relative error of a single region that would be, for the worst but a tenth of the regions.
    pub visible_in_regions: f64,
    /// One per cent of error in the strongest group of lights.
    pub injected: Option<Injected>,
}

/// A deliberate error.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Injected {
    /// The lights that are made one per cent brighter.
    pub lights: String,
    /// Their share of the image.
    pub share: f64,
    /// Probability as [`Bias::p`], with the error.
    pub p: f64,
    /// Whether it would be found.
    pub caught: bool,
}

/// Values by replica; of each: one number a region, and the image's mean last.
type Table = Vec<Vec<f64>>;

/// Compares the regions' means. Needs two replicas of each.
pub fn bias(evidence: &Evidence) -> Bias {
    let grid = evidence.regions();
    let table = |images: &mut dyn Iterator<Item = &[f64]>| -> Table {
        images.map(|image| regions(&grid, |i| image[i])).collect()
    };
    let (a, b) = (table(&mut evidence.images()), table(&mut evidence.references()));
    let rounding = ROUNDING * mean(&b, b[0].len() - 1);
    let tests = tests(&a, &b, rounding);
    let total = tests[tests.len() - 1];
    let reference = mean(&b, tests.len() - 1);
    let most = (0..tests.len()).min_by(|&i, &j| tests[i].p.total_cmp(&tests[j].p)).unwrap_or(0);
    let (p_bootstrap, p_uniform) = bootstrap(&a, &b, &tests, rounding);
    Bias {
        p: corrected(&tests),
        p_bootstrap,
        region: (most < grid.count()).then(|| [most % grid.cut[0], most / grid.cut[0]]),
        difference: tests[most].difference / mean(&b, most),
        image_difference: total.difference / reference,
        image_stderr: total.stderr / reference,
        reference_share: (moments(&b, tests.len() - 1).1 / total.stderr.powi(2)).min(1.0),
        histogram: histogram(&tests),
        p_uniform,
        visible: visible(&tests, &b, tests.len() - 1),
        visible_in_regions: visible_in_regions(&tests, &b),
        injected: inject(evidence, &a, &b, rounding),
    }
}

/// Contribution of each region to the image's mean, and that mean last.
fn regions(grid: &Grid, pixel: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
    let mut regions: Vec<f64> = grid.shares(|i| [pixel(i)]).into_iter().map(|[share]| share).collect();
    regions.push(regions.iter().sum());
    regions
}

/// Welch's test of one region.
#[derive(Clone, Copy, Debug)]
struct Test {
    difference: f64,
    stderr: f64,
    /// Degrees of freedom.
    freedom: f64,
    p: f64,
    /// Whether the replicas vary by more than rounding.
    varies: bool,
}

impl Test {
    /// Source: [Welch47].
    fn new((a, va, na): (f64, f64, f64), (b, vb, nb): (f64, f64, f64), rounding: f64) -> Self {
        let (difference, variance) = (a - b, va + vb);
        let stderr = variance.sqrt();
        let freedom = variance * variance / (va * va / (na - 1.0) + vb * vb / (nb - 1.0));
        let p = if difference.abs() <= rounding {
            1.0
        } else if variance == 0.0 {
            0.0
        } else {
            StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| 2.0 * t.sf(difference.abs() / stderr)).min(1.0)
        };
        Self { difference, stderr, freedom, p, varies: stderr > rounding }
    }

    fn t(&self) -> f64 {
        if self.stderr > 0.0 { self.difference / self.stderr } else { 0.0 }
    }
}

fn mean(table: &Table, column: usize) -> f64 {
    table.iter().map(|row| row[column]).sum::<f64>() / table.len() as f64
}

/// Mean, variance of the mean, number.
fn moments(table: &Table, column: usize) -> (f64, f64, f64) {
    let (mean, n) = (mean(table, column), table.len() as f64);
    (mean, table.iter().map(|row| (row[column] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)), n)
}

/// `rounding`: differences that say nothing.
fn tests(a: &Table, b: &Table, rounding: f64) -> Vec<Test> {
    (0..b[0].len()).map(|column| Test::new(moments(a, column), moments(b, column), rounding)).collect()
}

/// Smallest of the p-values, corrected for their number: half of the significance is for the image's mean, half for the
/// regions. Source: [Holm79]; for the smallest, his correction is Bonferroni's.
fn corrected(tests: &[Test]) -> f64 {
    let (regions, image) = tests.split_at(tests.len() - 1);
    let least = regions.iter().map(|test| test.p).fold(1.0, f64::min);
    (2.0 * image[0].p.min(least * regions.len() as f64)).min(1.0)
}

fn histogram(tests: &[Test]) -> [usize; BARS] {
    let mut bars = [0; BARS];
    for p in lit(tests) {
        bars[((p * BARS as f64) as usize).min(BARS - 1)] += 1;
    }
    bars
}

/// p-values of the regions that vary: where a method has no noise, as in a plain sky that is seen, they are 1.
fn lit(tests: &[Test]) -> impl Iterator<Item = f64> {
    tests[..tests.len() - 1].iter().filter(|test| test.varies).map(|test| test.p)
}

/// Kolmogorov's distance of the p-values from uniform, times √n.
fn distance(tests: &[Test]) -> f64 {
    let mut p: Vec<f64> = lit(tests).collect();
    p.sort_unstable_by(f64::total_cmp);
    let n = p.len() as f64;
    let gap = |(i, p): (usize, &f64)| (p - i as f64 / n).max((i + 1) as f64 / n - p);
    p.iter().enumerate().map(gap).fold(0.0, f64::max) * n.sqrt()
}

/// Probabilities, if there were no difference, of the largest |t| and of the distance of the p-values from uniform.
///
/// Whole replicas are drawn again, with the means taken off, so that regions vary together as they do.
/// Source: [WestfallYoung93].
fn bootstrap(a: &Table, b: &Table, tests_found: &[Test], rounding: f64) -> (f64, f64) {
    let largest = |tests: &[Test]| tests.iter().map(|test| test.t().abs()).fold(0.0, f64::max);
    let found = (largest(tests_found), distance(tests_found));
    let (a, b) = (centred(a), centred(b));
    let mut rng = Pcg64Mcg::seed_from_u64(0);
    let mut beyond = (1, 1);
    for _ in 0..RESAMPLES {
        let tests = tests(&redrawn(&a, &mut rng), &redrawn(&b, &mut rng), rounding);
        beyond.0 += usize::from(largest(&tests) >= found.0);
        beyond.1 += usize::from(distance(&tests) >= found.1);
    }
    let share = |count: usize| count as f64 / (RESAMPLES + 1) as f64;
    (share(beyond.0), share(beyond.1))
}

fn centred(table: &Table) -> Table {
    let means: Vec<f64> = (0..table[0].len()).map(|column| mean(table, column)).collect();
    table.iter().map(|row| row.iter().zip(&means).map(|(x, mean)| x - mean).collect()).collect()
}

fn redrawn(table: &Table, rng: &mut Pcg64Mcg) -> Table {
    let draw = |_| table[((u64::from(rng.next_u32()) * table.len() as u64) >> 32) as usize].clone();
    (0..table.len()).map(draw).collect()
}

/// Errors in units of the standard error that are found: Student's quantile of the significance, halved and two-sided, for
/// this number of tests.
fn critical(tests: usize, freedom: f64) -> f64 {
    let beyond = SIGNIFICANCE / (4.0 * tests as f64);
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |law| -law.inverse_cdf(beyond))
}

/// Relative error of a region, or of the image (the last column), that is found in four of five studies.
fn visible(tests: &[Test], reference: &Table, column: usize) -> f64 {
    let regions = tests.len() - 1;
    let made = if column == regions { 1 } else { regions };
    (critical(made, tests[column].freedom) + FOUR_IN_FIVE) * tests[column].stderr / mean(reference, column).abs()
}

/// The same for the region that is worse than nine in ten of those that are lit.
fn visible_in_regions(tests: &[Test], reference: &Table) -> f64 {
    let of_regions = (0..tests.len() - 1).map(|region| visible(tests, reference, region));
    let mut needs: Vec<f64> = of_regions.filter(|need| need.is_finite()).collect();
    needs.sort_unstable_by(f64::total_cmp);
    needs.get(needs.len() * 9 / 10).copied().unwrap_or(f64::INFINITY)
}

/// Makes the strongest group of lights one per cent brighter in every replica of the method, and looks again. What was
/// found without it is taken off, so that the outcome tells of the test and not of the method.
fn inject(evidence: &Evidence, a: &Table, b: &Table, rounding: f64) -> Option<Injected> {
    let sum = |pixels: &[f64]| pixels.iter().sum::<f64>();
    let all: f64 = evidence.groups.iter().map(|group| sum(&group.pixels)).sum();
    let strongest = evidence.groups.iter().max_by(|x, y| sum(&x.pixels).total_cmp(&sum(&y.pixels)))?;
    let share = sum(&strongest.pixels) / all;
    if !share.is_finite() {
        return None;
    }
    let error = regions(&evidence.regions(), |i| strongest.pixels[i] * INJECTED);
    let shift = |(column, x): (usize, &f64)| x - mean(a, column) + mean(b, column) + error[column];
    let wrong: Table = a.iter().map(|row| row.iter().enumerate().map(shift).collect()).collect();
    let p = corrected(&tests(&wrong, b, rounding));
    Some(Injected { lights: strongest.name.clone(), share, p, caught: p < SIGNIFICANCE })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use statrs::distribution::Normal;

    use super::super::evidence::{Group, Replica};
    use super::*;

    const SIZE: [usize; 2] = [8, 8];
    const REPLICAS: usize = 12;

    /// Two methods of the same law, level 1 in every pixel, the first one's images multiplied by `factor`; `noise`: of a
    /// uniform number, the rest of a pixel.
    fn study(seed: u64, factor: f64, noise: impl Fn(f64) -> f64) -> Bias {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut image = || -> Vec<f64> {
            let uniform = |rng: &mut Pcg64Mcg| (f64::from(rng.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
            (0..SIZE[0] * SIZE[1]).map(|_| 1.0 + noise(uniform(&mut rng))).collect()
        };
        let replica = |pixels: Vec<f64>| Replica {
            pixels: pixels.into_iter().map(|x| factor * x).collect(),
            stderr: Vec::new(),
            rounds: Vec::new(),
            strata: Vec::new(),
            longest_rejection: 0,
            warnings: Vec::new(),
            doubted: false,
        };
        let method = (0..REPLICAS).map(|_| replica(image())).collect();
        let reference = (0..REPLICAS).map(|_| image()).collect();
        let groups = vec![Group { name: "lamp".into(), pixels: vec![1.0; SIZE[0] * SIZE[1]] }];
        bias(&Evidence { size: SIZE, method, reference, groups })
    }

    fn normal(deviation: f64) -> impl Fn(f64) -> f64 {
        move |u| deviation * Normal::standard().inverse_cdf(u)
    }

    /// Of 60 right studies few have p < 0.1, corrected or by the bootstrap, and their p-values look uniform.
    #[test]
    fn what_is_right_is_rarely_found_wrong() {
        let studies: Vec<Bias> = (0..60).map(|seed| study(seed, 1.0, normal(0.1))).collect();
        let below = |p: fn(&Bias) -> f64| studies.iter().filter(|bias| p(bias) < 0.1).count();
        let counts = [below(|bias| bias.p), below(|bias| bias.p_bootstrap), below(|bias| bias.p_uniform)];
        assert!(counts.iter().all(|&count| count <= 14), "{counts:?} of 60");
        let mut bars = [0; BARS];
        studies.iter().for_each(|bias| bars.iter_mut().zip(bias.histogram).for_each(|(bar, n)| *bar += n));
        assert!(bars.iter().all(|n| (280..=490).contains(n)), "{bars:?}");
    }

    /// Regions without noise, as those that show nothing but sky, say nothing of how the others' p-values lie.
    #[test]
    fn regions_without_noise_are_no_doubt() {
        let doubted = |seed: u64| {
            let drawn = Cell::new(0);
            let noise = |u: f64| {
                drawn.set(drawn.get() + 1);
                if drawn.get() % 64 < 32 { 1e-8 * u } else { normal(0.1)(u) }
            };
            study(seed, 1.0, noise).p_uniform < 0.01
        };
        let count = (0..40).filter(|&seed| doubted(seed)).count();
        assert!(count <= 3, "{count} of 40");
    }

    /// The error that is said to be visible in four of five studies is visible in about as many.
    #[test]
    fn the_visible_error_is_what_it_says() {
        let visible = (0..20).map(|seed| study(seed, 1.0, normal(0.1)).visible).sum::<f64>() / 20.0;
        let found = (0..40).filter(|seed| study(100 + seed, 1.0 + visible, normal(0.1)).p < SIGNIFICANCE).count();
        assert!((20..=39).contains(&found), "{found} of 40");
        let wrong = study(7, 1.0 + 2.0 * visible, normal(0.1));
        assert!(
            wrong.p < SIGNIFICANCE
                && wrong.p_bootstrap < 0.01
                && (wrong.image_difference - 2.0 * visible).abs() < visible
        );
    }

    /// Values that are hardly ever large, and then by far: Student's t alone would find a difference too often.
    #[test]
    fn uneven_replicas_are_no_proof() {
        let rare = |u: f64| if u < 1e-3 { 100.0 } else { 0.001 * u };
        let studies: Vec<Bias> = (0..40).map(|seed| study(seed, 1.0, rare)).collect();
        let alone = studies.iter().filter(|bias| bias.p < SIGNIFICANCE).count();
        let both = studies.iter().filter(|bias| bias.p < SIGNIFICANCE && bias.p_bootstrap <= 5e-3).count();
        assert!(both <= alone && both <= 2, "{both} and {alone} of 40");
    }
}
