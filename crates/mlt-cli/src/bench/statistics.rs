//! Figures from few independent runs: medians, intervals, slopes.

use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Resamples of a bootstrap.
const RESAMPLES: usize = 4000;
/// Probability outside of an interval.
const ALPHA: f64 = 0.05;

/// A statistic of a sample; the sample may be reordered.
pub(crate) type Statistic = fn(&mut [f64]) -> f64;

/// Middle value, or the mean of the two middle values; NaN without values.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match (values.len() / 2, values.len() % 2) {
        (0, 0) => f64::NAN,
        (half, 0) => 0.5 * (values[half - 1] + values[half]),
        (half, _) => values[half],
    }
}

/// Sum over number; NaN without values.
pub(crate) fn mean(values: &mut [f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median of values that come from anywhere.
pub(crate) fn median_of(values: impl Iterator<Item = f64>) -> f64 {
    median(&mut values.collect::<Vec<_>>())
}

/// Mean of values that come from anywhere.
pub(crate) fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    mean(&mut values.collect::<Vec<_>>())
}

/// A figure with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    /// The figure.
    pub value: f64,
    /// Lower and upper end; `None` when there were too few runs to tell.
    pub interval: Option<(f64, f64)>,
}

/// Reading of a ratio's interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// All of the interval is below one.
    Less,
    /// All of the interval is above one.
    Greater,
    /// The interval holds one, or there is none.
    Open,
}

impl Estimate {
    /// Compares a ratio with one.
    pub(crate) fn verdict(&self) -> Verdict {
        match self.interval {
            Some((_, high)) if high < 1.0 => Verdict::Less,
            Some((low, _)) if low > 1.0 => Verdict::Greater,
            _ => Verdict::Open,
        }
    }
}

/// statistic(a) / statistic(b), with the expanded percentile interval of a bootstrap that resamples both.
///
/// The percentiles are Φ(±√(n/(n−1)) t), which corrects the plain percentile interval's lack of width at small n: n is
/// the smaller sample's size, t Student's quantile of n_a + n_b − 2 degrees of freedom. The same samples give the same
/// interval. Source: [Hesterberg15], section 4.
pub(crate) fn ratio(a: &[f64], b: &[f64], statistic: Statistic) -> Estimate {
    let value = statistic(&mut a.to_vec()) / statistic(&mut b.to_vec());
    let percentile = percentile(a.len().min(b.len()), a.len() + b.len());
    let interval = percentile.map(|p| {
        let mut rng = Pcg64Mcg::seed_from_u64(0);
        interval(p, || statistic(&mut resample(a, &mut rng)) / statistic(&mut resample(b, &mut rng)))
    });
    Estimate { value, interval }
}

/// statistic(values), with an interval as [`ratio`]'s of n − 1 degrees of freedom.
pub(crate) fn estimate(values: &[f64], statistic: Statistic) -> Estimate {
    let interval = percentile(values.len(), values.len() + 1).map(|p| {
        let mut rng = Pcg64Mcg::seed_from_u64(0);
        interval(p, || statistic(&mut resample(values, &mut rng)))
    });
    Estimate { value: statistic(&mut values.to_vec()), interval }
}

/// The lower percentile of an interval; `None` from fewer than three values, which say nothing. `total`: two more than
/// the degrees of freedom.
fn percentile(n: usize, total: usize) -> Option<f64> {
    if n < 3 {
        return None;
    }
    let t = StudentsT::new(0.0, 1.0, total as f64 - 2.0).ok()?.inverse_cdf(ALPHA / 2.0);
    Some(Normal::standard().cdf(t * (n as f64 / (n as f64 - 1.0)).sqrt()))
}

/// As many values, each drawn from all.
fn resample(values: &[f64], rng: &mut Pcg64Mcg) -> Vec<f64> {
    values.iter().map(|_| values[((u64::from(rng.next_u32()) * values.len() as u64) >> 32) as usize]).collect()
}

fn interval(percentile: f64, draw: impl FnMut() -> f64) -> (f64, f64) {
    let mut draws: Vec<f64> = std::iter::repeat_with(draw).take(RESAMPLES).collect();
    draws.sort_unstable_by(f64::total_cmp);
    let last = RESAMPLES - 1;
    let at = (percentile * last as f64).round() as usize;
    (draws[at], draws[last - at])
}

/// Slope of the least-squares line through (ln x, ln y); `None` with fewer than two different x.
pub(crate) fn log_log_slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (x, y) = (mean_of(logs.iter().map(|p| p.0)), mean_of(logs.iter().map(|p| p.1)));
    let sum = |f: fn(f64, f64) -> f64| logs.iter().map(|p| f(p.0 - x, p.1 - y)).sum::<f64>();
    let slope = sum(|x, y| x * y) / sum(|x, _| x * x);
    slope.is_finite().then_some(slope)
}

/// Where a falling curve reaches a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// The abscissa.
    pub x: f64,
    /// True when it lies outside of the measured points, on the line that continues them.
    pub extrapolated: bool,
}

/// The first x at which the curve through `points` (x rising) is down at `y`: straight between points in log-log, beyond
/// them with the fitted slope. `None` when the curve does not fall.
pub(crate) fn crossing(points: &[(f64, f64)], y: f64) -> Option<Crossing> {
    let (&first, &last) = (points.first()?, points.last()?);
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        if y0 >= y && y >= y1 && y0 > y1 {
            let share = (y0 / y).ln() / (y0 / y1).ln();
            return Some(Crossing { x: x0 * (x1 / x0).powf(share), extrapolated: false });
        }
    }
    let slope = log_log_slope(points).filter(|slope| *slope < 0.0)?;
    let (x, from) = if y > first.1 { first } else { last };
    Some(Crossing { x: x * (y / from).powf(1.0 / slope), extrapolated: true })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_means() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(mean(&mut [4.0, 1.0, 1.0]), 2.0);
        assert!(median(&mut []).is_nan() && mean(&mut []).is_nan());
    }

    #[test]
    fn few_values_give_no_interval() {
        assert_eq!(ratio(&[2.0, 2.0], &[1.0, 1.0], mean), Estimate { value: 2.0, interval: None });
        let estimate = ratio(&[2.0; 3], &[1.0; 3], median);
        assert_eq!(estimate, Estimate { value: 2.0, interval: Some((2.0, 2.0)) });
        assert_eq!(estimate.verdict(), Verdict::Greater);
    }

    /// Ten values each of two log-normal distributions whose medians, and whose means, have the ratio 0.8: the intervals
    /// hold it in about 95 of 100 studies (those of a median in more, as its bootstrap has few values to choose from).
    /// The negative control asks for a ratio that is wrong by half.
    #[test]
    fn intervals_cover() {
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        let mut uniform = || (f64::from(rng.next_u32()) + 0.5) / f64::from(u32::MAX);
        let mut sample = |scale: f64| -> Vec<f64> {
            let normal = Normal::standard();
            (0..10).map(|_| scale * (0.3 * normal.inverse_cdf(uniform())).exp()).collect()
        };
        let holds = |estimate: Estimate, truth: f64| {
            let (low, high) = estimate.interval.expect("ten values");
            usize::from(low <= truth && truth <= high)
        };
        let mean_of_all = 0.8 * (0.5 * 0.3_f64.powi(2)).exp();
        let mut counts = [0; 4];
        for _ in 0..400 {
            let (a, b) = (sample(0.8), sample(1.0));
            counts[0] += holds(ratio(&a, &b, mean), 0.8);
            counts[1] += holds(ratio(&a, &b, median), 0.8);
            counts[2] += holds(estimate(&a, mean), mean_of_all);
            counts[3] += holds(ratio(&a, &b, mean), 1.2);
        }
        assert!([0, 2].iter().all(|i| (366..=394).contains(&counts[*i])) && counts[1] >= 372, "{counts:?} of 400");
        assert!(counts[3] < 200, "{counts:?} of 400");
    }

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let points = [1.0, 2.0, 5.0, 30.0].map(|x: f64| (x, 3.0 * x.powf(-0.9)));
        assert!((log_log_slope(&points).expect("four points") + 0.9).abs() < 1e-12);
        assert_eq!(log_log_slope(&points[..1]), None);
        assert_eq!(log_log_slope(&[]), None);
    }

    #[test]
    fn a_curve_is_crossed_between_and_beyond_its_points() {
        let points = [1.0, 10.0, 100.0].map(|x: f64| (x, 1.0 / x));
        let inside = crossing(&points, 0.05).expect("falls");
        assert!((inside.x - 20.0).abs() < 1e-9 && !inside.extrapolated);
        for (y, x) in [(4.0, 0.25), (0.001, 1000.0)] {
            let outside = crossing(&points, y).expect("falls");
            assert!((outside.x - x).abs() < 1e-9 * x && outside.extrapolated);
        }
        assert_eq!(crossing(&[(1.0, 1.0), (2.0, 1.0)], 0.5), None);
        assert_eq!(crossing(&[], 0.5), None);
    }
}
