//! Sums without rounding, so that their order does not matter.

/// An exact sum of numbers: whatever the order and the grouping, the same numbers give the same [`value`](Self::value).
///
/// It is kept as a few numbers none of which overlaps another, smallest first.
///
/// Source: [Shewchuk97], section 2.4 (expansions); the last rounding as in Python's `math.fsum`.
#[derive(Clone, Debug, Default)]
pub struct ExactSum {
    parts: Vec<f64>,
    /// Numbers that were not finite, and overflow.
    not_finite: f64,
}

impl ExactSum {
    /// Adds a number.
    pub fn add(&mut self, number: f64) {
        if !number.is_finite() {
            self.not_finite += number;
            return;
        }
        let mut x = number;
        let mut kept = 0;
        for i in 0..self.parts.len() {
            let (sum, error) = two_sum(x, self.parts[i]);
            if !sum.is_finite() {
                self.not_finite += sum;
                self.parts.clear();
                return;
            }
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
            x = sum;
        }
        self.parts.truncate(kept);
        if x != 0.0 {
            self.parts.push(x);
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &Self) {
        other.parts.iter().for_each(|&part| self.add(part));
        self.not_finite += other.not_finite;
    }

    /// The sum, rounded once.
    pub fn value(&self) -> f64 {
        if self.not_finite != 0.0 {
            return self.not_finite;
        }
        let Some((&largest, mut rest)) = self.parts.split_last() else { return 0.0 };
        let mut sum = largest;
        while let Some((&part, smaller)) = rest.split_last() {
            let (rounded, error) = two_sum(sum, part);
            (sum, rest) = (rounded, smaller);
            if error != 0.0 {
                // A tie that was rounded to even goes the way of what is left.
                let next = smaller.last().copied().unwrap_or(0.0);
                let twice = 2.0 * error;
                if next * error > 0.0 && (sum + twice) - sum == twice {
                    sum += twice;
                }
                break;
            }
        }
        sum
    }

    /// The sum as numbers of which each is what is left, rounded: the same for the same sum.
    pub(super) fn canonical(&self) -> Vec<f64> {
        let (mut left, mut parts) = (self.clone(), Vec::new());
        loop {
            let value = left.value();
            if value == 0.0 {
                return parts;
            }
            parts.push(value);
            if !value.is_finite() {
                return parts;
            }
            left.add(-value);
        }
    }
}

impl PartialEq for ExactSum {
    fn eq(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|sum| sum.canonical());
        a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
    }
}

impl From<f64> for ExactSum {
    fn from(number: f64) -> Self {
        let mut sum = Self::default();
        sum.add(number);
        sum
    }
}

impl FromIterator<f64> for ExactSum {
    fn from_iter<T: IntoIterator<Item = f64>>(numbers: T) -> Self {
        let mut sum = Self::default();
        numbers.into_iter().for_each(|number| sum.add(number));
        sum
    }
}

/// a + b, rounded, and what that left out.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let (large, small) = if a.abs() < b.abs() { (b, a) } else { (a, b) };
    let sum = large + small;
    (sum, small - (sum - large))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform};

    #[test]
    fn order_and_grouping_change_nothing() {
        let mut rng = generator(1, Purpose::Image, 0, 0, 0);
        for _ in 0..if cfg!(miri) { 2 } else { 200 } {
            let number = |u: f64, v: f64| (2.0 * u - 1.0) * (80.0 * (v - 0.5)).exp2();
            let numbers: Vec<_> = (0..40).map(|_| number(uniform(&mut rng), uniform(&mut rng))).collect();
            let forward: ExactSum = numbers.iter().copied().collect();
            let backward: ExactSum = numbers.iter().rev().copied().collect();
            let mut grouped = ExactSum::default();
            numbers.chunks(7).rev().for_each(|chunk| grouped.merge(&chunk.iter().copied().collect()));
            assert_eq!(forward.value().to_bits(), backward.value().to_bits());
            assert!(forward == backward && forward == grouped);
            // The control: plain sums do depend on the order, mostly.
            let undone: ExactSum = numbers.iter().copied().chain(numbers.iter().map(|x| -x)).collect();
            assert_eq!(undone.value(), 0.0);
        }
    }

    #[test]
    fn nothing_is_rounded_but_the_end() {
        let sum = |numbers: &[f64]| numbers.iter().copied().collect::<ExactSum>().value();
        assert_eq!(sum(&[1e100, 1.0, -1e100]), 1.0);
        assert_eq!(sum(&[0.1; 10]), 1.0);
        // A tie, and a little more on either side.
        let (one, half) = (1.0, f64::EPSILON / 2.0);
        assert_eq!(sum(&[one, half]), one);
        assert_eq!(sum(&[one, half, 1e-40]), one + f64::EPSILON);
        assert_eq!(sum(&[one, half, -1e-40]), one);
        assert_eq!(sum(&[f64::INFINITY, 1.0]), f64::INFINITY);
        assert_eq!(sum(&[f64::MAX, f64::MAX]), f64::INFINITY);
        assert_eq!(sum(&[]), 0.0);
    }
}
