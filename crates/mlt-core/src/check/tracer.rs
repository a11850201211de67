//! Whether a tracer is a function of its numbers.

use super::{Law, Report, Trials};
use crate::engine::{Purpose, Splat, generator};
use crate::primary::{Output, PrimaryPath, Stream, Tracer};

/// Tries a tracer of primary sample space: with the same numbers it has to give the same output and draw as many of them,
/// whatever was in its output before; its importance has to be finite, and positive where it deposits anything.
pub fn tracer<T, const STREAMS: usize, const C: usize>(tracer: &T, trials: Trials) -> Report
where
    T: Tracer<STREAMS, Output: Output<Splat = Splat<C>>>,
{
    let mut report = Report::default();
    let [mut changed, mut left_over, mut not_finite, mut unlit] = [0; 4];
    let mut used = T::Output::default();
    let mut path = PrimaryPath::<T::Output, STREAMS>::default();
    for trial in 0..trials.count {
        let lit = path.propose(None, tracer, &mut generator(trials.seed, Purpose::Sample, 0, 0, trial));
        let first = Traced::new(lit, path.output(), path.streams().each_ref().map(Stream::drawn));
        let again = |output: &mut T::Output| {
            let mut streams = path.streams().each_ref().map(Stream::again);
            let lit = tracer.trace(&mut streams, output);
            Traced::new(lit, output, streams.each_ref().map(Stream::drawn))
        };
        let fresh = again(&mut T::Output::default());
        changed += u64::from(fresh != first);
        left_over += u64::from(again(&mut used) != fresh);
        not_finite += u64::from(!first.is_finite());
        unlit += u64::from(first.deposits_in_the_dark());
    }
    report.count(Law::Repeatable, changed, trials.count, "outputs of the tracer");
    report.count(Law::Overwritten, left_over, trials.count, "outputs of the tracer");
    report.count(Law::Finite, not_finite, trials.count, "outputs of the tracer");
    report.count(Law::Lit, unlit, trials.count, "outputs of the tracer");
    report
}

/// Site and value of a splat, in bits.
type Bits<const C: usize> = (u32, [u64; C]);

/// Result of a tracer for some numbers; nothing where it said that F = 0.
#[derive(PartialEq)]
struct Traced<const STREAMS: usize, const C: usize> {
    output: Option<(u64, Vec<Bits<C>>)>,
    drawn: [usize; STREAMS],
}

impl<const STREAMS: usize, const C: usize> Traced<STREAMS, C> {
    fn new(lit: bool, output: &impl Output<Splat = Splat<C>>, drawn: [usize; STREAMS]) -> Self {
        let splats = || output.splats().map(|splat| (splat.site, splat.value.map(f64::to_bits))).collect();
        Self { output: lit.then(|| (output.importance().to_bits(), splats())), drawn }
    }

    fn is_finite(&self) -> bool {
        self.output.as_ref().is_none_or(|(importance, splats)| {
            let value = f64::from_bits(*importance);
            let finite = |bits: &u64| f64::from_bits(*bits).is_finite();
            value.is_finite() && value >= 0.0 && splats.iter().flat_map(|(_, value)| value).all(finite)
        })
    }

    fn deposits_in_the_dark(&self) -> bool {
        self.output.as_ref().is_some_and(|(importance, splats)| {
            let deposits = splats.iter().flat_map(|(_, value)| value).any(|bits| f64::from_bits(*bits) != 0.0);
            f64::from_bits(*importance) == 0.0 && deposits
        })
    }
}
