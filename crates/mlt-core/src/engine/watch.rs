//! A way to stop what makes no rounds, and to see how far it is.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Asked by a pilot, which has no [`Observer`](super::Observer), after each piece of work: it breaks to stop the pilot.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    go_on: &'a (dyn Fn() -> ControlFlow<()> + Sync),
    /// Takes the share of the work that is done.
    report: &'a (dyn Fn(f64) + Sync),
    /// Shares of the whole work between which this part of it lies.
    part: [f64; 2],
}

impl<'a> Watch<'a> {
    /// Stops nothing.
    pub const NEVER: Watch<'static> = Watch { go_on: &|| ControlFlow::Continue(()), report: &|_| (), part: [0.0, 1.0] };

    /// Asks `go_on`, from any thread.
    pub fn new(go_on: &'a (dyn Fn() -> ControlFlow<()> + Sync)) -> Self {
        Self { go_on, ..Self::NEVER }
    }

    /// The same that tells `report`, from any thread, which share of the work is done, about.
    #[must_use]
    pub fn reporting(self, report: &'a (dyn Fn(f64) + Sync)) -> Self {
        Self { report, ..self }
    }

    /// For the part of this work between two shares of it.
    #[must_use]
    pub(crate) fn part(self, from: f64, to: f64) -> Self {
        let [start, end] = self.part;
        Self { part: [from, to].map(|share| start + share * (end - start)), ..self }
    }

    /// Breaks where it is told to stop.
    pub(crate) fn go_on(self) -> ControlFlow<()> {
        (self.go_on)()
    }

    /// For work in `count` pieces.
    pub(crate) fn pieces(self, count: usize) -> Pieces<'a> {
        Pieces { watch: self, count: count as u64, done: AtomicU64::new(0) }
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}

/// Work in pieces of about the same size.
pub(crate) struct Pieces<'a> {
    watch: Watch<'a>,
    count: u64,
    done: AtomicU64,
}

impl Pieces<'_> {
    /// Does a piece, unless it is told to stop.
    pub(crate) fn unless_stopped<T>(&self, work: impl FnOnce() -> T) -> Option<T> {
        if self.watch.go_on().is_break() {
            return None;
        }
        let found = work();
        let done = self.done.fetch_add(1, Relaxed) + 1;
        let [start, end] = self.watch.part;
        (self.watch.report)(start + (end - start) * (done as f64 / self.count as f64));
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_parts_add_up_to_the_whole() {
        let told = AtomicU64::new(0);
        let report = |share: f64| told.store((1000.0 * share).round() as u64, Relaxed);
        let watch = Watch::NEVER.reporting(&report);
        let mut seen = Vec::new();
        for part in [watch.part(0.0, 0.5), watch.part(0.5, 1.0).part(0.0, 0.5), watch.part(0.75, 1.0)] {
            let pieces = part.pieces(2);
            for _ in 0..2 {
                assert_eq!(pieces.unless_stopped(|| 7), Some(7));
                seen.push(told.load(Relaxed));
            }
        }
        assert_eq!(seen, [250, 500, 625, 750, 875, 1000]);
        assert_eq!(Watch::new(&|| ControlFlow::Break(())).pieces(1).unless_stopped(|| 7), None);
    }
}
