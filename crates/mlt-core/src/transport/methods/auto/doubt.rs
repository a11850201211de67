//! How far a measured noise may be from the true one.
//!
//! A noise that rests on few events is hardly known. It is bounded as a number of equal events is that come by Poisson's law:
//! of k that were met, the expected number μ is at most that of k = μ − t √μ. By Cantelli's inequality,
//! P(μ − X ≥ t σ) ≤ 1/(1 + t²), such a bound holds with 90 % for every law if t = 3.

use super::constants::DEVIATIONS;

/// Upper bound of a noise over its estimate, which rests on so many [`events`](crate::engine::events): μ/k.
pub(super) fn upper(events: f64) -> f64 {
    bound(events, DEVIATIONS)
}

fn bound(k: f64, t: f64) -> f64 {
    if k.is_infinite() { 1.0 } else { (0.5 * (t + (t * t + 4.0 * k).sqrt())).powi(2) / k }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, events, generator, uniform};

    /// Sums of values that are rare and large, the law that a pilot meets where light comes through a gap: the bounds hold
    /// in nine studies of ten. The negative control: bounds of one standard deviation do not.
    #[test]
    fn the_bounds_hold_in_nine_of_ten() {
        let mut rng = generator(1, Purpose::Image, 0, 0, 0);
        for p in [0.01, 0.1] {
            let study = |_| -> [f64; 2] {
                let values: Vec<f64> = (0..500).map(|_| f64::from(u8::from(uniform(&mut rng) < p))).collect();
                [values.iter().sum::<f64>() / (500.0 * p), events(values.into_iter())]
            };
            let studies: Vec<_> = (0..1000).map(study).filter(|[ratio, _]| *ratio > 0.0).collect();
            let share = |holds: &dyn Fn(&[f64; 2]) -> bool| {
                studies.iter().filter(|study| holds(study)).count() as f64 / studies.len() as f64
            };
            assert!(share(&|[ratio, k]| ratio * upper(*k) > 1.0) > 0.9);
            assert!(share(&|[ratio, k]| ratio * bound(*k, 1.0) > 1.0) < 0.9);
        }
    }

    #[test]
    fn what_is_known_exactly_has_no_other_bound() {
        assert_eq!(upper(f64::INFINITY), 1.0);
        assert!((upper(1e6) - 1.003).abs() < 1e-4 && (10.0..11.0).contains(&upper(1.0)));
    }
}
