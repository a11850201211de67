//! Whether mutations keep what they are to sample.

use super::trial::Zero;
use super::{Law, Report, Trials};
use crate::engine::{Chain, Generator, Importance, Mixture, Mutation, Path, Purpose, Sink, Stratum, generator};

/// Steps of a chain.
const STEPS: usize = 16;

/// Tries the mutations of a mixture in a stratum. `bin` sorts states into a few bins, numbered from 0, that a wrong mutation would
/// fill wrongly: the more it has to do with what mutations change, the more it finds.
///
/// With samples x of weights w = 1/p, and y ~ T(x→·) by one mutation, for any two bins A and B
///
/// E[w h(x, y) (1_A(x) 1_B(y) T(y→x)/T(x→y) − 1_B(x) 1_A(y))] = 0,   h = I(x) I(y)/(I(x) + I(y)),
///
/// which tests the mutation's ratio alone; and for a chain of some steps from x to z, E[w I(x) (1_A(z) − 1_A(x))] = 0, which tests
/// all that a chain does.
pub fn mutation<P, S, M>(
    mixture: &Mixture<P, S, M>,
    stratum: &S,
    importance: &impl Importance<P>,
    bin: impl Fn(&P) -> usize,
    trials: Trials,
) -> Report
where
    P: Path,
    S: Stratum<P>,
    M: Mutation<P, S>,
{
    let mut report = Report::default();
    let mut kept = Vec::new();
    let mut of_mutations: Vec<_> = mixture.mutations().iter().map(|_| OfMutation::default()).collect();
    for trial in 0..trials.count {
        let stream = |purpose| generator(trials.seed, purpose, 0, 0, trial);
        let rng = &mut stream(Purpose::Chain);
        for (x, weight) in samples(stratum, &mut stream(Purpose::Sample)) {
            let value = importance.eval(&x);
            if !(value > 0.0 && weight > 0.0) {
                continue;
            }
            for (mutation, found) in mixture.mutations().iter().zip(&mut of_mutations) {
                let start = Start { x: &x, value, weight, trials };
                found.add(mutation, &start, (stratum, importance), &bin, rng);
            }
            let Some(mut chain) = Chain::new(mixture, importance, stratum, x.clone()) else { continue };
            (0..STEPS).for_each(|_| chain.step(&mut Nowhere, 1.0, rng));
            add(&mut kept, bin(chain.current()), weight * value, trials);
            add(&mut kept, bin(&x), -weight * value, trials);
        }
    }
    for (mutation, found) in mixture.mutations().iter().zip(&of_mutations) {
        found.report(mutation.name(), trials, &mut report);
    }
    report.expect(Law::Stationary, &kept, |bin| format!("bin {bin} after {STEPS} steps"));
    report
}

/// Samples of a stratum, with their weights.
fn samples<P: Path>(stratum: &impl Stratum<P>, rng: &mut Generator) -> Vec<(P, f64)> {
    let mut samples = Vec::new();
    stratum.sample(rng, &mut |path: &P, weight| samples.push((path.clone(), weight)));
    samples
}

/// Swallows deposits.
struct Nowhere;

impl<S> Sink<S> for Nowhere {
    fn deposit(&mut self, _: S, _: f64) {}
}

fn add(to: &mut Vec<Zero>, at: usize, value: f64, trials: Trials) {
    if to.len() <= at {
        to.resize(at + 1, Zero::new(trials.count));
    }
    to[at].add(value);
}

/// A state that a mutation changes.
struct Start<'a, P> {
    x: &'a P,
    /// I(x).
    value: f64,
    /// 1/p(x).
    weight: f64,
    trials: Trials,
}

/// Findings of the check of one mutation.
#[derive(Default)]
struct OfMutation {
    /// For each two bins, numbered as [`pair`] says.
    inverse: Vec<Zero>,
    not_finite: u64,
    left_over: u64,
}

/// Number of the pair of bins (a, b): those of bins below n come before those with n.
fn pair(a: usize, b: usize) -> usize {
    let n = a.max(b);
    n * n + if a < b { a } else { n + b }
}

/// The bins of a pair.
fn bins(pair: usize) -> [usize; 2] {
    let n = pair.isqrt();
    let rest = pair - n * n;
    if rest < n { [rest, n] } else { [n, rest - n] }
}

impl OfMutation {
    fn add<P: Path, S: Stratum<P>, M: Mutation<P, S>>(
        &mut self,
        mutation: &M,
        &Start { x, value, weight, trials }: &Start<P>,
        (stratum, importance): (&S, &impl Importance<P>),
        bin: &impl Fn(&P) -> usize,
        rng: &mut Generator,
    ) {
        if mutation.suitability(x) <= 0.0 {
            return;
        }
        let mut y = x.clone();
        let mut again = rng.clone();
        let ratio = mutation.propose(x, &mut y, stratum, rng);
        // The same numbers over what another proposal left behind.
        let mut used = x.clone();
        let _ = mutation.propose(&y, &mut used, stratum, &mut generator(trials.seed, Purpose::Start, 0, 0, 0));
        let other = mutation.propose(x, &mut used, stratum, &mut again);
        let seen = |ratio: Option<f64>, y: &P| ratio.map(|r| (r.to_bits(), importance.eval(y).to_bits(), bin(y)));
        self.left_over += u64::from(seen(ratio, &y) != seen(other, &used));
        let Some(ratio) = ratio.filter(|_| stratum.contains(&y) && mutation.suitability(&y) > 0.0) else { return };
        let of_y = importance.eval(&y);
        if !([ratio, of_y].iter().all(|x| x.is_finite() && *x >= 0.0)) {
            self.not_finite += 1;
        } else if of_y > 0.0 {
            let h = weight * value * of_y / (value + of_y);
            let [a, b] = [bin(x), bin(&y)];
            if a == b {
                add(&mut self.inverse, pair(a, a), h * (ratio - 1.0), trials);
            } else {
                add(&mut self.inverse, pair(a, b), h * ratio, trials);
                add(&mut self.inverse, pair(b, a), -h, trials);
            }
        }
    }

    fn report(&self, name: &str, trials: Trials, report: &mut Report) {
        report.count(Law::Finite, self.not_finite, trials.count, &format!("proposals of \"{name}\""));
        report.count(Law::Overwritten, self.left_over, trials.count, &format!("proposals of \"{name}\""));
        report.expect(Law::Inverse, &self.inverse, |at| {
            let [a, b] = bins(at);
            format!("the ratio of \"{name}\" from bin {a} to bin {b}")
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Splat, uniform};
    use rand_pcg::rand_core::Rng;

    /// A number in [0, 1) with what a mutation may leave behind.
    #[derive(Clone)]
    struct X {
        x: f64,
        stain: f64,
    }

    impl Path for X {
        type Splat = Splat<1>;

        fn splats(&self) -> impl Iterator<Item = Splat<1>> {
            std::iter::empty()
        }
    }

    struct Unit;

    impl Stratum<X> for Unit {
        fn contains(&self, x: &X) -> bool {
            (0.0..1.0).contains(&x.x)
        }

        /// Density 2x.
        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
            let x = (1.0 - uniform(rng)).sqrt();
            visit(&X { x, stain: 0.0 }, 0.5 / x);
        }

        fn density(&self, x: &X) -> f64 {
            2.0 * x.x
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    #[derive(Clone, Copy)]
    enum Move {
        /// x·r with log r uniform in ±½: T(y→x)/T(x→y) = y/x. `exponent`: of the ratio, which ought to be 1.
        Scale { exponent: f64 },
        /// A step up or down, but not as often; the ratio says how often, if `told`.
        Drift { told: bool },
        /// To anywhere, with a ratio that depends on the last proposal.
        Stained,
        /// To anywhere, with a ratio that is not always a number.
        NotANumber,
    }

    impl Mutation<X, Unit> for Move {
        fn name(&self) -> &'static str {
            "move"
        }

        fn propose(&self, x: &X, y: &mut X, _: &Unit, rng: &mut impl Rng) -> Option<f64> {
            let u = uniform(rng);
            match self {
                Self::Scale { exponent } => {
                    *y = X { x: x.x * (u - 0.5).exp(), stain: 0.0 };
                    Some((y.x / x.x).powf(*exponent))
                }
                Self::Drift { told } => {
                    let up = uniform(rng) < 0.7;
                    *y = X { x: x.x + if up { 0.2 * u } else { -0.2 * u }, stain: 0.0 };
                    Some(if !told {
                        1.0
                    } else if up {
                        3.0 / 7.0
                    } else {
                        7.0 / 3.0
                    })
                }
                Self::Stained => {
                    let stain = y.stain;
                    *y = X { x: u, stain: 1.0 };
                    Some(1.0 + stain)
                }
                Self::NotANumber => {
                    *y = X { x: u, stain: 0.0 };
                    Some(if u > 0.99 { f64::NAN } else { 1.0 })
                }
            }
        }
    }

    fn broken(moves: Vec<Move>) -> Vec<Law> {
        let importance = |x: &X| 0.2 + x.x * x.x;
        let trials = Trials { count: 200_000, seed: 4 };
        let report = mutation(&Mixture::new(moves), &Unit, &importance, |x: &X| (5.0 * x.x) as usize, trials);
        report.broken.iter().map(|finding| finding.law).collect()
    }

    #[test]
    fn each_law_is_named_where_it_is_broken() {
        assert_eq!(broken(vec![Move::Scale { exponent: 1.0 }, Move::Drift { told: true }]), []);
        assert_eq!(broken(vec![Move::Scale { exponent: 0.0 }]), [Law::Inverse, Law::Stationary]);
        assert_eq!(broken(vec![Move::Scale { exponent: 1.2 }]), [Law::Inverse, Law::Stationary]);
        assert_eq!(broken(vec![Move::Drift { told: false }]), [Law::Inverse, Law::Stationary]);
        assert!(broken(vec![Move::Stained]).contains(&Law::Overwritten));
        assert!(broken(vec![Move::NotANumber]).contains(&Law::Finite));
    }

    #[test]
    fn pairs_of_bins_are_numbered_without_gaps() {
        let mut numbers: Vec<_> = (0..25).map(|i| pair(i / 5, i % 5)).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..25).collect::<Vec<_>>());
        (0..25).for_each(|i| assert_eq!(bins(pair(i / 5, i % 5)), [i / 5, i % 5]));
    }
}
