//! Which rounds a film holds.

use std::fmt;
use std::ops::Range;

/// A set of rounds by their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rounds {
    /// In order; they neither overlap nor touch.
    ranges: Vec<Range<u64>>,
}

impl Rounds {
    /// How many there are.
    pub fn count(&self) -> u64 {
        self.ranges.iter().map(|range| range.end - range.start).sum()
    }

    /// Ranges of consecutive rounds, in order.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.ranges
    }

    /// Adds some consecutive rounds.
    pub fn insert(&mut self, added: Range<u64>) {
        if added.is_empty() {
            return;
        }
        let first = self.ranges.partition_point(|range| range.end < added.start);
        let last = self.ranges.partition_point(|range| range.start <= added.end);
        let joined = match &self.ranges[first..last] {
            [] => added,
            touching => {
                let ends = (touching[0].start, touching[touching.len() - 1].end);
                added.start.min(ends.0)..added.end.max(ends.1)
            }
        };
        self.ranges.splice(first..last, [joined]);
    }

    /// Those of `range` that are not in the set, as ranges in order.
    pub fn missing(&self, range: Range<u64>) -> Vec<Range<u64>> {
        let mut next = range.start;
        let mut missing = Vec::new();
        for held in self.ranges.iter().filter(|held| held.start < range.end && held.end > range.start) {
            missing.push(next..held.start.max(next));
            next = held.end;
        }
        missing.push(next..range.end.max(next));
        missing.retain(|range| !range.is_empty());
        missing
    }

    /// Those that are in both sets.
    pub fn common(&self, other: &Self) -> Self {
        let mut common = Self::default();
        for range in &self.ranges {
            let held = other.ranges.iter().map(|held| held.start.max(range.start)..held.end.min(range.end));
            held.for_each(|both| common.insert(both));
        }
        common
    }
}

impl fmt::Display for Rounds {
    /// As in `0 to 15, 20`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |range: &Range<u64>| match range.end - range.start {
            1 => range.start.to_string(),
            _ => format!("{} to {}", range.start, range.end - 1),
        };
        f.write_str(&self.ranges.iter().map(word).collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator};
    use rand_pcg::rand_core::Rng;
    use std::collections::BTreeSet;

    fn set(rounds: &Rounds) -> BTreeSet<u64> {
        rounds.ranges.iter().cloned().flatten().collect()
    }

    #[test]
    fn it_is_a_set() {
        let mut rng = generator(1, Purpose::Image, 0, 0, 0);
        let mut number = |below: u32| u64::from(rng.next_u32() % below);
        for _ in 0..if cfg!(miri) { 3 } else { 300 } {
            let mut made = || {
                let (mut rounds, mut expected) = (Rounds::default(), BTreeSet::new());
                for _ in 0..number(8) {
                    let start = number(30);
                    let range = start..start + number(6);
                    rounds.insert(range.clone());
                    expected.extend(range);
                }
                assert_eq!(set(&rounds), expected);
                assert!(rounds.ranges.windows(2).all(|pair| pair[0].end < pair[1].start), "{rounds:?}");
                rounds
            };
            let [a, b] = [made(), made()];
            assert_eq!(set(&a.common(&b)), &set(&a) & &set(&b));
            let missing: BTreeSet<u64> = a.missing(5..25).into_iter().flatten().collect();
            assert_eq!(missing, &(5..25).collect::<BTreeSet<_>>() - &set(&a));
            assert_eq!(a.count(), set(&a).len() as u64);
        }
    }

    #[test]
    fn it_reads_as_ranges() {
        let mut rounds = Rounds::default();
        [3..4, 7..9, 9..12].into_iter().for_each(|range| rounds.insert(range));
        assert_eq!(rounds.to_string(), "3, 7 to 11");
    }
}
