//! Tables that say where in cumulative sums a share is found.

use std::ops::Range;

/// For each of as many equal intervals of the total as there are sums: where the share at its beginning is found. A search between two
/// neighbouring entries takes about one step, whatever the number of sums.
///
/// Source: Chen & Asau, "On Generating Random Variates from an Empirical Distribution", AIIE Transactions 6, 1974.
#[derive(Clone, Debug, Default)]
pub(super) struct Guide {
    /// Of the share k/n, k = 0 … n: the number of sums that are no larger.
    first: Vec<u32>,
}

impl Guide {
    /// For sums that do not fall.
    pub(super) fn new(sums: &[f64]) -> Self {
        let (n, total) = (sums.len(), sums.last().copied().unwrap_or(0.0));
        let mut at = 0;
        let mut found = |k: usize| {
            let share = total * (k as f64 / n as f64);
            at += sums[at..].iter().take_while(|&&sum| sum <= share).count();
            at as u32
        };
        Self { first: (0..=n).map(&mut found).collect() }
    }

    /// Bounds on the number of sums that are no larger than the share `x` of the total, as far as rounding allows.
    #[inline]
    pub(super) fn range(&self, x: f64) -> Range<usize> {
        let n = self.first.len() - 1;
        let k = ((x * n as f64) as usize).min(n - 1);
        self.first[k] as usize..self.first[k + 1] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_found_within_its_range() {
        let sums: Vec<f64> = [0.0, 0.0, 3.0, 3.5, 3.5, 3.75, 9.0, 9.0].to_vec();
        let guide = Guide::new(&sums);
        let mut widest = 0;
        for i in 0..1000 {
            let x = f64::from(i) / 1000.0;
            let (range, count) = (guide.range(x), sums.iter().filter(|&&sum| sum <= 9.0 * x).count());
            assert!(range.start <= count && count <= range.end, "{x}: {count} of {range:?}");
            widest = widest.max(range.len());
        }
        assert!(widest < 5, "{widest}");
    }
}
