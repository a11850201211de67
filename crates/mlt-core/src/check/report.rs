//! Report of a check.

use super::trial::{SIGNIFICANCE, Zero};
use std::fmt;

/// A law that samplers, strata and mutations have to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Law {
    /// The same random numbers give the same sample.
    Repeatable,
    /// Weights, ratios and importance are finite and not negative.
    Finite,
    /// A stratum shows states that it contains.
    Inside,
    /// No state lies in two strata.
    Disjoint,
    /// Every state of positive importance lies in a stratum.
    Covered,
    /// E[Σ w/p · I] over a stratum's samples is ∫ I over the stratum.
    Integral,
    /// T(y→x)/T(x→y) is the inverse of T(x→y)/T(y→x).
    Inverse,
    /// A chain that starts from the target's distribution keeps it.
    Stationary,
    /// An output is the same whatever stood in its place before.
    Overwritten,
    /// Where the importance is 0, nothing is deposited.
    Lit,
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Repeatable => "the same random numbers give the same sample",
            Self::Finite => "weights, ratios and importance are finite and not negative",
            Self::Inside => "a stratum shows states that it contains",
            Self::Disjoint => "no state lies in two strata",
            Self::Covered => "every state of positive importance lies in a stratum",
            Self::Integral => "a stratum's samples estimate its integral of the importance",
            Self::Inverse => "the ratios of densities there and back are inverse",
            Self::Stationary => "chains keep the target's distribution",
            Self::Overwritten => "what is written does not depend on what was there before",
            Self::Lit => "where the importance is 0, nothing is deposited",
        })
    }
}

/// A law that is broken.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The law.
    pub law: Law,
    /// Where: a stratum or a mutation by name or number, and what was found there.
    pub evidence: String,
}

/// Report of a check; its text is one line for each law that is broken.
#[derive(Clone, Debug, Default, PartialEq)]
#[must_use]
pub struct Report {
    /// The laws that are broken.
    pub broken: Vec<Finding>,
}

impl Report {
    /// Whether no law was found to be broken.
    pub fn is_sound(&self) -> bool {
        self.broken.is_empty()
    }

    /// Whether this law was found to be broken.
    pub fn breaks(&self, law: Law) -> bool {
        self.broken.iter().any(|finding| finding.law == law)
    }

    /// Notes a law that so many states broke.
    pub(super) fn count(&mut self, law: Law, states: u64, trials: u64, place: &str) {
        if states > 0 {
            self.broken.push(Finding { law, evidence: format!("{place}: not in {states} of {trials} trials") });
        }
    }

    /// Notes the worst of some expectations that ought to be 0, if it is not.
    pub(super) fn expect(&mut self, law: Law, tests: &[Zero], place: impl Fn(usize) -> String) {
        let z = tests.iter().map(Zero::z).enumerate().filter_map(|(i, z)| Some((i, z?)));
        let Some((worst, z)) = z.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else { return };
        let p = (libm::erfc(z.abs() / std::f64::consts::SQRT_2) * tests.len() as f64).min(1.0);
        if p < SIGNIFICANCE {
            self.broken.push(Finding { law, evidence: format!("{}: z = {z:.1}, p = {p:.0e}", place(worst)) });
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_sound() {
            return f.write_str("no law was found to be broken");
        }
        let line = |Finding { law, evidence }: &Finding| format!("{law}: broken by {evidence}");
        f.write_str(&self.broken.iter().map(line).collect::<Vec<_>>().join("\n"))
    }
}
