//! Sums of counts, which stay at the largest number: counts from a file may be anything.

/// Adds to a count.
#[inline]
pub fn add_count(total: &mut u64, more: u64) {
    *total = total.saturating_add(more);
}

/// The sum of counts.
pub fn total_count(counts: impl IntoIterator<Item = u64>) -> u64 {
    counts.into_iter().fold(0, u64::saturating_add)
}
