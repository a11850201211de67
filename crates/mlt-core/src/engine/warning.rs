//! Signs of a wrong image that a render's counts hold.

use super::count::total_count;
use super::{MutationStats, StratumStats, Tally};
use std::{fmt, iter};

/// Share of Σ b_j from which a stratum is bright enough that its noise matters to the image.
const NOTABLE: f64 = 0.05;
/// Independent states that are too few to know how bright a part of the image is, let alone its error.
const FEW_STATES: f64 = 50.0;
/// Strata that a warning names.
const NAMED: usize = 4;

/// Kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WarningKind {
    /// Paths with a NaN or infinite importance, or a mutation with such a ratio.
    NonFinite,
    /// Chains without a first state: the sample that they start from had none when it was made again.
    RefusedStarts,
    /// A sample that was made again from the same random numbers had another weight.
    ChangedStarts,
    /// Independent samples of a stratum that it does not contain.
    Astray,
    /// States that no stratum contains, which a mutation proposed: a gap.
    Uncovered,
    /// States that two strata or more contain: an overlap.
    Shared,
    /// Rounds in which a stratum that is bright in others had no light.
    DarkRounds,
    /// No light in any stratum.
    Black,
    /// Chains of a stratum that disagree with each other.
    Disagreement,
}

/// A sign that an image is wrong, or that its error bars say too little; its text is one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The kind of fault.
    pub kind: WarningKind,
    /// Where, in the order of the strata.
    pub strata: Vec<usize>,
    sentence: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)?;
        let named: Vec<_> = self.strata.iter().take(NAMED).map(usize::to_string).collect();
        match (named.len(), self.strata.len() - named.len()) {
            (0, _) => Ok(()),
            (1, _) => write!(f, " (stratum {})", named[0]),
            (_, 0) => write!(f, " (strata {})", named.join(", ")),
            (_, more) => write!(f, " (strata {} and {more} more)", named.join(", ")),
        }
    }
}

impl Warning {
    /// Those that counts give reason to.
    pub(super) fn all(tally: &Tally) -> Vec<Self> {
        let counts =
            COUNTED.iter().map(|counts| counted(tally, counts.kind, counts.of, |n| format!("{n} {}", counts.sentence)));
        let doubts = iter::once(non_finite(tally)).chain(counts).chain([dark(tally), disagreement(tally)]);
        doubts.flatten().collect()
    }
}

/// Something of which a sound stratum counts none.
struct Counted {
    kind: WarningKind,
    of: fn(&StratumStats) -> u64,
    /// The sentence, without the number that it begins with.
    sentence: &'static str,
}

const COUNTED: [Counted; 5] = [
    Counted {
        kind: WarningKind::RefusedStarts,
        of: |stats| stats.refused_starts,
        sentence: "chains could not start; what they would have added is missing: render longer, or by another method",
    },
    Counted {
        kind: WarningKind::ChangedStarts,
        of: |stats| stats.changed_starts,
        sentence: "samples had another weight when they were made again, so the image is wrong: what samples a stratum has to \
                   depend on its random numbers alone",
    },
    Counted {
        kind: WarningKind::Astray,
        of: |stats| stats.coverage.astray,
        sentence: "independent samples lie outside their own stratum, so the image is wrong: a stratum has to show states that it \
                   contains",
    },
    Counted {
        kind: WarningKind::Uncovered,
        of: |stats| stats.coverage.uncovered,
        sentence: "states lie in no stratum, and the image lacks what such states bring: close the gap",
    },
    Counted {
        kind: WarningKind::Shared,
        of: |stats| stats.coverage.shared,
        sentence: "states lie in two strata or more, and the image has what such states bring twice: cut the overlap",
    },
];

/// A warning where a count is not 0 in some strata.
fn counted(
    tally: &Tally,
    kind: WarningKind,
    count: fn(&StratumStats) -> u64,
    sentence: impl Fn(u64) -> String,
) -> Option<Warning> {
    let strata: Vec<_> = (0..tally.strata.len()).filter(|&j| count(&tally.strata[j]) > 0).collect();
    let total = total_count(tally.strata.iter().map(count));
    (!strata.is_empty()).then(|| Warning { kind, strata, sentence: sentence(total) })
}

fn non_finite(tally: &Tally) -> Option<Warning> {
    let non_finite =
        |s: &StratumStats| total_count(s.mutations.iter().map(|m| m.non_finite).chain([s.non_finite_samples]));
    let made = |m: &MutationStats| m.non_finite > 0;
    let by_mutation = |k: usize| tally.strata.iter().any(|s| s.mutations.get(k).is_some_and(made));
    let mut makers: Vec<_> =
        tally.mutations.iter().enumerate().filter(|(k, _)| by_mutation(*k)).map(|(_, name)| &**name).collect();
    makers.extend(tally.strata.iter().any(|s| s.non_finite_samples > 0).then_some("independent samples"));
    counted(tally, WarningKind::NonFinite, non_finite, |paths| {
        format!(
            "{paths} paths, made by {}, had an importance that is not finite; they are left out: look for materials and \
             lights of extreme values",
            makers.join(", ")
        )
    })
}

fn dark(tally: &Tally) -> Option<Warning> {
    let sampled = tally.strata.iter().any(|s| s.rounds > 0);
    if sampled && tally.strata.iter().all(|s| s.dark_rounds == s.rounds) {
        let sentence = "no independent sample found light, so nothing is in the image".into();
        return Some(Warning { kind: WarningKind::Black, strata: Vec::new(), sentence });
    }
    let bright = bright(tally);
    let strata: Vec<_> = bright.into_iter().filter(|&j| tally.strata[j].dark_rounds > 0).collect();
    let share = |s: &StratumStats| 100.0 * s.dark_rounds as f64 / s.rounds as f64;
    let worst = strata.iter().map(|&j| share(&tally.strata[j])).fold(0.0, f64::max);
    (!strata.is_empty()).then(|| Warning {
        kind: WarningKind::DarkRounds,
        strata,
        sentence: format!(
            "no sample found light in up to {worst:.0} % of the rounds, though others did: take more samples"
        ),
    })
}

fn disagreement(tally: &Tally) -> Option<Warning> {
    let worth = |j: usize| tally.strata[j].halves.effective_states().unwrap_or(f64::INFINITY);
    let strata: Vec<_> = bright(tally).into_iter().filter(|&j| worth(j) < FEW_STATES).collect();
    let worst = strata.iter().copied().min_by(|&a, &b| worth(a).total_cmp(&worth(b)))?;
    let sentence = format!(
        "chains disagree (R-hat {:.2}): they are worth {:.0} independent states; render longer",
        tally.strata[worst].halves.r_hat().unwrap_or(f64::INFINITY),
        worth(worst)
    );
    Some(Warning { kind: WarningKind::Disagreement, strata, sentence })
}

/// The strata whose noise matters to the image.
fn bright(tally: &Tally) -> Vec<usize> {
    let total: f64 = tally.strata.iter().map(StratumStats::b).sum();
    (0..tally.strata.len()).filter(|&j| tally.strata[j].b() > NOTABLE * total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{
        Accumulated, Film, Metropolis, Mixture, Mutation, Path, SetupError, Share, Splat, Stratum, render, uniform,
    };
    use crate::engine::{Importance, with_shares};
    use rand_pcg::rand_core::Rng;
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A number in [0, 1) that brings itself to the film's one site: the image is ½.
    #[derive(Clone)]
    struct X(f64);

    impl Path for X {
        type Splat = Splat<1>;

        fn splats(&self) -> impl Iterator<Item = Splat<1>> {
            iter::once(Splat { site: 0, value: [self.0] })
        }
    }

    /// [low, high). `samples_from`: where its samples lie, which ought to be the same.
    struct Cell {
        low: f64,
        high: f64,
        samples_from: f64,
    }

    impl Cell {
        fn new(low: f64, high: f64) -> Self {
            Self { low, high, samples_from: low }
        }
    }

    impl Stratum<X> for Cell {
        fn contains(&self, x: &X) -> bool {
            (self.low..self.high).contains(&x.0)
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
            let width = self.high - self.low;
            visit(&X(self.samples_from + width * uniform(rng)), width);
        }

        fn density(&self, _: &X) -> f64 {
            1.0 / (self.high - self.low)
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    /// A step of up to ± `most`, round the ends.
    struct Nudge {
        most: f64,
    }

    impl Mutation<X, Cell> for Nudge {
        fn name(&self) -> &'static str {
            "nudge"
        }

        fn propose(&self, x: &X, y: &mut X, _: &Cell, rng: &mut impl Rng) -> Option<f64> {
            y.0 = (x.0 + self.most * (2.0 * uniform(rng) - 1.0)).rem_euclid(1.0);
            Some(1.0)
        }
    }

    const SHARE: Share = Share { mutations: 200, samples: 50 };

    /// Mean of the film's site over 400 rounds, and what is warned of.
    fn rendered(cells: Vec<Cell>, most: f64, importance: &(impl Importance<X> + Sync)) -> (f64, Vec<Warning>) {
        let strata: Vec<_> = cells.into_iter().map(|cell| (cell, SHARE)).collect();
        let mixture = Mixture::new(vec![Nudge { most }]);
        let metropolis = Metropolis::new(&strata, &mixture, importance, 7).expect("sound");
        let mut sums = Accumulated::new(Film::new(1, 1.0));
        render(&metropolis, 0..400, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let (film, tally) = sums.into_parts();
        (film.pixel(0)[0].mean, tally.warnings())
    }

    fn of_cells(cells: &[[f64; 2]]) -> (f64, Vec<WarningKind>) {
        let cells = cells.iter().map(|&[low, high]| Cell::new(low, high)).collect();
        let (mean, warnings) = rendered(cells, 0.2, &|x: &X| x.0);
        (mean, warnings.iter().map(|warning| warning.kind).collect())
    }

    #[test]
    fn a_partition_is_nothing_to_warn_of() {
        let fine: Vec<_> = (0..200).map(|i| [f64::from(i) / 200.0, f64::from(i + 1) / 200.0]).collect();
        for cells in [&[[0.0, 1.0]][..], &[[0.0, 0.5], [0.5, 1.0]], &[[0.0, 0.1], [0.1, 0.7], [0.7, 1.0]], &fine] {
            let (mean, warnings) = of_cells(cells);
            assert!((mean - 0.5).abs() < 0.01 && warnings.is_empty(), "{mean}: {warnings:?}");
        }
    }

    #[test]
    fn a_gap_between_strata_is_found() {
        for cells in [&[[0.5, 1.0]][..], &[[0.0, 0.4], [0.45, 1.0]], &[[0.0, 0.7], [0.7, 0.99]]] {
            let (mean, warnings) = of_cells(cells);
            assert!((mean - 0.5).abs() > 0.005 && warnings == [WarningKind::Uncovered], "{mean}: {warnings:?}");
        }
        let many: Vec<_> =
            (0..200).filter(|i| *i != 77).map(|i| [f64::from(i) / 200.0, f64::from(i + 1) / 200.0]).collect();
        assert_eq!(of_cells(&many).1, [WarningKind::Uncovered]);
    }

    #[test]
    fn an_overlap_of_strata_is_found() {
        for cells in [&[[0.0, 1.0], [0.5, 1.0]][..], &[[0.0, 0.5], [0.49, 1.0]]] {
            let (mean, warnings) = of_cells(cells);
            assert!(mean > 0.504 && warnings == [WarningKind::Shared], "{mean}: {warnings:?}");
        }
    }

    #[test]
    fn a_part_of_the_space_has_no_gaps() {
        let strata = [(Cell::new(0.5, 1.0), SHARE)];
        let (mixture, importance) = (Mixture::new(vec![Nudge { most: 0.2 }]), |x: &X| x.0);
        let metropolis = Metropolis::new(&strata, &mixture, &importance, 7).expect("sound").partial();
        let mut sums = Accumulated::new(Film::new(1, 1.0));
        render(&metropolis, 0..400, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let (_, tally) = sums.into_parts();
        assert_eq!(tally.warnings(), []);
    }

    #[test]
    fn samples_that_their_stratum_does_not_contain_are_found() {
        let cells = vec![Cell::new(0.0, 0.5), Cell { samples_from: 0.45, ..Cell::new(0.5, 1.0) }];
        let warnings = rendered(cells, 0.2, &|x: &X| x.0).1;
        assert!(warnings.iter().any(|w| w.kind == WarningKind::Astray && w.strata == [1]), "{warnings:?}");
    }

    /// Two peaks that no step joins, with chains too few to be in both as often as they should.
    #[test]
    fn chains_that_disagree_are_found() {
        let peaks = |x: &X| if (x.0 - 0.5).abs() > 0.45 { 1.0 } else { 1e-6 };
        let sorts = |most| rendered(vec![Cell::new(0.0, 1.0)], most, &peaks).1;
        assert_eq!(sorts(0.2), []);
        let stuck = |x: &X| if x.0 < 0.5 { 1.0 } else { 2.0 };
        let strata = [(Cell::new(0.0, 1.0), SHARE)];
        let mixture = Mixture::new(vec![Nudge { most: 1e-9 }]);
        let metropolis = Metropolis::new(&strata, &mixture, &stuck, 7).expect("sound");
        let mut sums = Accumulated::new(Film::new(1, 1.0));
        render(&metropolis, 0..20, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let (_, tally) = sums.into_parts();
        let [warning] = &tally.warnings()[..] else { panic!("{:?}", tally.warnings()) };
        assert!(warning.kind == WarningKind::Disagreement && warning.to_string().contains("R-hat"), "{warning}");
    }

    #[test]
    fn rounds_that_find_no_light_are_found() {
        let speck = |x: &X| if x.0 > 0.99 { 1.0 } else { 0.0 };
        let kinds = |importance: &(dyn Fn(&X) -> f64 + Sync)| -> Vec<_> {
            let cells = vec![Cell::new(0.0, 0.5), Cell::new(0.5, 1.0)];
            rendered(cells, 0.2, &|x: &X| importance(x)).1.iter().map(|w| (w.kind, w.strata.clone())).collect()
        };
        assert_eq!(kinds(&speck), [(WarningKind::DarkRounds, vec![1])]);
        assert_eq!(kinds(&|_| 0.0), [(WarningKind::Black, vec![])]);
        // A stratum that is always dark is what strata are for.
        assert_eq!(kinds(&|x| if x.0 > 0.5 { 1.0 } else { 0.0 }), []);
    }

    /// A stratum whose samples count how often they were drawn.
    struct Forgetful {
        drawn: AtomicU32,
        hidden: bool,
    }

    impl Stratum<X> for Forgetful {
        fn contains(&self, _: &X) -> bool {
            true
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
            let drawn = if self.hidden { self.drawn.fetch_add(1, Ordering::Relaxed) % 7 } else { 0 };
            visit(&X((uniform(rng) + f64::from(drawn) / 7.0).rem_euclid(1.0)), 1.0);
        }

        fn density(&self, _: &X) -> f64 {
            1.0
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    impl Mutation<X, Forgetful> for Nudge {
        fn name(&self) -> &'static str {
            "nudge"
        }

        fn propose(&self, x: &X, y: &mut X, _: &Forgetful, rng: &mut impl Rng) -> Option<f64> {
            self.propose(x, y, &Cell::new(0.0, 1.0), rng)
        }
    }

    #[test]
    fn a_sampler_with_a_state_of_its_own_is_found() {
        let kinds = |hidden| -> Vec<_> {
            let strata = [(Forgetful { drawn: AtomicU32::new(0), hidden }, SHARE)];
            let (mixture, importance) = (Mixture::new(vec![Nudge { most: 0.2 }]), |x: &X| x.0);
            let metropolis = Metropolis::new(&strata, &mixture, &importance, 7).expect("sound");
            let mut sums = Accumulated::new(Film::new(1, 1.0));
            render(&metropolis, 0..50, &mut sums, &mut |_, _| ControlFlow::Continue(()));
            let (_, tally) = sums.into_parts();
            tally.warnings().iter().map(|w| w.kind).collect()
        };
        assert_eq!(kinds(false), []);
        assert_eq!(kinds(true), [WarningKind::ChangedStarts]);
    }

    #[test]
    fn what_gives_no_image_is_refused_in_a_sentence() {
        let halves = || vec![Cell::new(0.0, 0.5), Cell::new(0.5, 1.0)];
        let refused = |shares: &[Share]| {
            let (mixture, importance) = (Mixture::new(vec![Nudge { most: 0.2 }]), |x: &X| x.0);
            with_shares(halves(), shares)
                .and_then(|strata| Metropolis::new(&strata, &mixture, &importance, 7).map(|_| ()))
                .err()
        };
        let [no_mutation, no_sample] = [Share { mutations: 0, ..SHARE }, Share { samples: 0, ..SHARE }];
        assert_eq!(refused(&[SHARE, SHARE]), None);
        for (shares, error, words) in [
            (&[SHARE][..], SetupError::Shares { strata: 2, shares: 1 }, "2 strata and 1 shares"),
            (&[SHARE; 3], SetupError::Shares { strata: 2, shares: 3 }, "2 strata and 3 shares"),
            (&[SHARE, no_mutation], SetupError::NoMutations { stratum: 1 }, "stratum 1 has no mutation"),
            (&[no_sample, SHARE], SetupError::NoSamples { stratum: 0 }, "stratum 0 has no independent sample"),
        ] {
            assert_eq!(refused(shares), Some(error));
            assert!(error.to_string().contains(words), "{error}");
        }
        let mixture = Mixture::<X, Cell, Nudge>::new(Vec::new());
        assert_eq!(Metropolis::new(&[], &mixture, &|x: &X| x.0, 7).err(), Some(SetupError::NoStratum));
    }
}
