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
pub type Statistic = fn(&mut [f64]) -> f64;

/// Middle value, or the mean of the two middle values; NaN without values.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match (values.len() / 2, values.len() % 2) {
        (0, 0) => f64::NAN,
        (half, 0) => 0.5 * (values[half - 1] + values[half]),
        (half, _) => values[half],
    }
}

/// Sum over number; NaN without values.
pub fn mean(values: &mut [f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median of values that come from anywhere.
pub fn median_of(values: impl Iterator<Item = f64>) -> f64 {
    median(&mut values.collect::<Vec<_>>())
}

/// Mean of values that come from anywhere.
pub fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    mean(&mut values.collect::<Vec<_>>())
}

/// A figure with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// Lower and upper end; `None` when there were too few runs to tell.
    pub interval: Option<(f64, f64)>,
}

/// What an interval says about a ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All of the interval is below one.
    Less,
    /// All of the interval is above one.
    Greater,
    /// The interval holds one, or there is none.
    Open,
}

impl Estimate {
    /// Compares a ratio with one.
    pub fn verdict(&self) -> Verdict {
        match self.interval {
            Some((_, high)) if high < 1.0 => Verdict::Less,
            Some((low, _)) if low > 1.0 => Verdict::Greater,
            _ => Verdict::Open,
        }
    }
}

/// statistic(a) / statistic(b), with the expanded percentile interval of a bootstrap that resamples both.
///
/// The percentiles are Φ(±√(n/(n−1)) t_{n−1}), which corrects the plain percentile interval's lack of width at small n;
/// n is the smaller sample's size. The same samples give the same interval. Source: [Hesterberg15], section 4.
pub fn ratio(a: &[f64], b: &[f64], statistic: Statistic) -> Estimate {
    let value = statistic(&mut a.to_vec()) / statistic(&mut b.to_vec());
    let n = a.len().min(b.len());
    Estimate { value, interval: percentile(n).map(|p| bootstrap(a, b, statistic, p)) }
}

/// The lower percentile of an interval from n values; `None` from fewer than three, which say nothing.
fn percentile(n: usize) -> Option<f64> {
    let freedom = n.checked_sub(1).filter(|freedom| *freedom >= 2)? as f64;
    let t = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(ALPHA / 2.0);
    Some(Normal::standard().cdf(t * (n as f64 / freedom).sqrt()))
}

fn bootstrap(a: &[f64], b: &[f64], statistic: Statistic, percentile: f64) -> (f64, f64) {
    let mut rng = Pcg64Mcg::seed_from_u64(0);
    let mut resample = |values: &[f64]| {
        let draw = |_| values[((u64::from(rng.next_u32()) * values.len() as u64) >> 32) as usize];
        statistic(&mut values.iter().map(draw).collect::<Vec<_>>())
    };
    let mut ratios: Vec<f64> = (0..RESAMPLES).map(|_| resample(a) / resample(b)).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let last = RESAMPLES - 1;
    let at = (percentile * last as f64).round() as usize;
    (ratios[at], ratios[last - at])
}

/// Slope of the least-squares line through (ln x, ln y); `None` with fewer than two different x.
pub fn log_log_slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (x, y) = (mean_of(logs.iter().map(|p| p.0)), mean_of(logs.iter().map(|p| p.1)));
    let sum = |f: fn(f64, f64) -> f64| logs.iter().map(|p| f(p.0 - x, p.1 - y)).sum::<f64>();
    let slope = sum(|x, y| x * y) / sum(|x, _| x * x);
    slope.is_finite().then_some(slope)
}

/// Where a falling curve reaches a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The abscissa.
    pub x: f64,
    /// True when it lies outside of the measured points, on the line that continues them.
    pub extrapolated: bool,
}

/// The first x at which the curve through `points` (x rising) is down at `y`: straight between points in log-log, beyond
/// them with the fitted slope. `None` when the curve does not fall.
pub fn crossing(points: &[(f64, f64)], y: f64) -> Option<Crossing> {
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

    /// Ten values each of two log-normal distributions whose medians have the ratio 0.8: the interval holds it in about
    /// 95 of 100 studies. The negative control asks for a ratio that is wrong by half.
    #[test]
    fn intervals_cover() {
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        let mut uniform = || (f64::from(rng.next_u32()) + 0.5) / f64::from(u32::MAX);
        let mut sample = |scale: f64| -> Vec<f64> {
            let normal = Normal::standard();
            (0..10).map(|_| scale * (0.3 * normal.inverse_cdf(uniform())).exp()).collect()
        };
        for statistic in [mean as Statistic, median] {
            let (mut holds, mut holds_wrong) = (0, 0);
            for _ in 0..300 {
                let (a, b) = (sample(0.8), sample(1.0));
                let (low, high) = ratio(&a, &b, statistic).interval.expect("ten values");
                holds += i32::from(low <= 0.8 && 0.8 <= high);
                holds_wrong += i32::from(low <= 1.2 && 1.2 <= high);
            }
            assert!((275..=298).contains(&holds), "{holds} of 300");
            assert!(holds_wrong < 150, "{holds_wrong} of 300");
        }
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
