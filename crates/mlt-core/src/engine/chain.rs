//! One Metropolis–Hastings chain.

use super::agreement::{Half, log2};
use super::mixture::Suitabilities;
use super::{Importance, Mixture, Mutation, Path, Sink, Stratum, StratumStats, uniform};
use rand_pcg::rand_core::Rng;

/// A chain in one stratum. It owns two states and swaps their places, so a step copies no more than its mutation does.
#[derive(Debug)]
pub struct Chain<'a, P, S, M, I> {
    mixture: &'a Mixture<P, S, M>,
    importance: &'a I,
    stratum: &'a S,
    current: Box<State<P>>,
    proposal: Box<State<P>>,
    /// log₂ I at `current`, and over the states of this half.
    level: f64,
    half: Half,
    pending: f64,
    rejections: Rejections,
    /// The first proposal outside the stratum.
    stray: Option<P>,
    stats: StratumStats,
}

/// A path, and what depends on it alone.
#[derive(Debug)]
struct State<P> {
    path: P,
    importance: f64,
    suitabilities: Suitabilities,
}

impl<'a, P, S, M, I> Chain<'a, P, S, M, I>
where
    P: Path,
    S: Stratum<P>,
    M: Mutation<P, S>,
    I: Importance<P>,
{
    /// A chain that starts at `start`; `None` if that state's importance is not positive and finite in the stratum.
    pub fn new(mixture: &'a Mixture<P, S, M>, importance: &'a I, stratum: &'a S, start: P) -> Option<Self> {
        let value = importance.eval(&start);
        let valid = value > 0.0 && value.is_finite() && stratum.contains(&start);
        let state = |path| {
            let suitabilities = mixture.suitabilities(&path);
            Box::new(State { path, importance: value, suitabilities })
        };
        valid.then(|| Self {
            mixture,
            importance,
            stratum,
            proposal: state(start.clone()),
            current: state(start),
            level: log2(value),
            half: Half::default(),
            pending: 0.0,
            rejections: Rejections { of_any: 0, of_each: vec![0; mixture.mutations().len()] },
            stray: None,
            stats: StratumStats::new(mixture.mutations().len()),
        })
    }

    /// The state that the chain stands at.
    pub fn current(&self) -> &P {
        &self.current.path
    }

    /// The first proposal that lay outside the stratum.
    pub fn stray(&self) -> Option<&P> {
        self.stray.as_ref()
    }

    /// One Metropolis–Hastings step; deposits both states by expected value, times `scale`.
    ///
    /// a(x→y) = min(1, I_j(y) T(y→x) / (I_j(x) T(x→y))); y gets a, x gets 1 − a, and what x is due is deposited once,
    /// when the chain leaves it.
    ///
    /// Source: [VeachGuibas97], sections 4.1 and 5.1.
    pub fn step(&mut self, sink: &mut impl Sink<P::Splat>, scale: f64, rng: &mut impl Rng) {
        self.advance(sink, scale, rng);
        self.half.add(self.level);
    }

    fn advance(&mut self, sink: &mut impl Sink<P::Splat>, scale: f64, rng: &mut impl Rng) {
        let Candidate { mutation, acceptance } = match self.propose(rng) {
            Ok(candidate) => candidate,
            Err(mutation) => {
                self.pending += 1.0;
                return self.stay(mutation);
            }
        };
        self.pending += 1.0 - acceptance;
        if uniform(rng) < acceptance {
            self.flush(sink, scale);
            std::mem::swap(&mut self.current, &mut self.proposal);
            self.level = log2(self.current.importance);
            self.pending = acceptance;
            self.rejections.of_any = 0;
            self.rejections.of_each[mutation] = 0;
            self.stats.mutations[mutation].accepted += 1;
        } else {
            if acceptance > 0.0 {
                self.proposal.deposit(self.importance, acceptance * scale, sink);
            }
            self.stats.mutations[mutation].rejected += 1;
            self.stay(Some(mutation));
        }
    }

    /// Deposits what the current state is still due, times `scale`.
    pub fn flush(&mut self, sink: &mut impl Sink<P::Splat>, scale: f64) {
        if self.pending > 0.0 {
            self.current.deposit(self.importance, self.pending * scale, sink);
        }
        self.pending = 0.0;
    }

    /// Ends a half of the chain, in a round of b̂ = `b`: [`HalfChains`](super::HalfChains) compares it with all others, and
    /// [`Rarity`](super::Rarity) takes in its last state.
    pub fn end_half(&mut self, b: f64) {
        self.half.close(&mut self.stats.halves);
        let State { path, importance, .. } = &*self.current;
        self.stats.rarity.add(*importance, self.stratum.density(path), b);
    }

    /// Counts so far.
    pub fn into_stats(self) -> StratumStats {
        self.stats
    }

    /// Counts a step that `mutation`, if any applied, did not bring anywhere.
    fn stay(&mut self, mutation: Option<usize>) {
        let Rejections { of_any, of_each } = &mut self.rejections;
        *of_any += 1;
        self.stats.longest_rejection = self.stats.longest_rejection.max(*of_any);
        if let Some(mutation) = mutation {
            of_each[mutation] += 1;
            let longest = &mut self.stats.mutations[mutation].longest_rejection;
            *longest = of_each[mutation].max(*longest);
        }
    }

    /// Writes a proposal; where there is none that could be accepted, which is counted here, the mutation that failed.
    fn propose(&mut self, rng: &mut impl Rng) -> Result<Candidate, Option<usize>> {
        let Self { mixture, importance, stratum, current, proposal, stray, stats, .. } = self;
        let Some(mutation) = current.suitabilities.choose(rng) else {
            stats.idle += 1;
            return Err(None);
        };
        let proposed = mixture.mutations()[mutation].propose(&current.path, &mut proposal.path, stratum, rng);
        let stats = &mut stats.mutations[mutation];
        let Some(ratio) = proposed else {
            stats.failed += 1;
            return Err(Some(mutation));
        };
        proposal.importance = if stratum.contains(&proposal.path) {
            importance.eval(&proposal.path)
        } else {
            if stray.is_none() {
                *stray = Some(proposal.path.clone());
            }
            0.0
        };
        let flow = proposal.importance * ratio;
        let acceptance = if flow == 0.0 {
            0.0
        } else {
            mixture.weigh(&proposal.path, &mut proposal.suitabilities);
            // p_m(y) / p_m(x) = s_m(y) Σ_n s_n(x) / (s_m(x) Σ_n s_n(y)). s_m(y) = 0 says that there is no way back, whatever the
            // total is.
            let (x, y) = (&current.suitabilities, &proposal.suitabilities);
            let flow = flow * (y.each[mutation] * x.total);
            if flow == 0.0 { 0.0 } else { flow / (current.importance * x.each[mutation] * y.total) }
        };
        if !(proposal.importance.is_finite() && acceptance.is_finite() && acceptance >= 0.0) {
            stats.non_finite += 1;
            return Err(Some(mutation));
        }
        Ok(Candidate { mutation, acceptance: acceptance.min(1.0) })
    }
}

impl<P: Path> State<P> {
    /// Deposits it with a weight of `due` over what `importance` says.
    #[inline]
    fn deposit(&self, importance: &impl Importance<P>, due: f64, sink: &mut impl Sink<P::Splat>) {
        let weight = due / importance.divisor(&self.path, self.importance);
        self.path.splats().for_each(|splat| sink.deposit(splat, weight));
    }
}

/// Lengths of the present runs without an acceptance.
#[derive(Debug)]
struct Rejections {
    /// Of steps.
    of_any: u64,
    /// Of each mutation's proposals.
    of_each: Vec<u64>,
}

/// A proposal that the chain may accept.
struct Candidate {
    mutation: usize,
    acceptance: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Film, Purpose, Splat, generator};

    #[test]
    fn runs_of_rejections_are_counted_by_mutation() {
        /// A state that nothing leaves, or a step that is always taken.
        struct Coin {
            moves: bool,
        }
        #[derive(Clone)]
        struct Here;
        struct Everywhere;
        impl Path for Here {
            type Splat = Splat<1>;

            fn splats(&self) -> impl Iterator<Item = Splat<1>> {
                std::iter::empty()
            }
        }
        impl Stratum<Here> for Everywhere {
            fn contains(&self, _: &Here) -> bool {
                true
            }
            fn sample(&self, _: &mut impl Rng, visit: &mut impl FnMut(&Here, f64)) {
                visit(&Here, 1.0);
            }
            fn density(&self, _: &Here) -> f64 {
                1.0
            }
            fn power(&self) -> f64 {
                1.0
            }
        }
        impl Mutation<Here, Everywhere> for Coin {
            fn name(&self) -> &'static str {
                if self.moves { "moves" } else { "stays" }
            }
            fn propose(&self, _: &Here, _: &mut Here, _: &Everywhere, _: &mut impl Rng) -> Option<f64> {
                self.moves.then_some(1.0)
            }
        }
        let mixture = Mixture::new(vec![Coin { moves: true }, Coin { moves: false }]);
        let importance = |_: &Here| 1.0;
        let mut chain = Chain::new(&mixture, &importance, &Everywhere, Here).expect("a start");
        let mut rng = generator(1, Purpose::Chain, 0, 0, 0);
        (0..1000).for_each(|_| chain.step(&mut Film::<1>::new(1, 1.0).deposits(), 1.0, &mut rng));
        let stats = chain.into_stats();
        let [moves, stays] = [&stats.mutations[0], &stats.mutations[1]];
        assert_eq!((moves.longest_rejection, moves.accepted), (0, moves.total()));
        assert_eq!((stays.longest_rejection, stays.failed), (stays.total(), stays.total()));
        // Of all steps, only those between two moves: ln 1000 / ln 2 is about 10.
        assert!((5..25).contains(&stats.longest_rejection), "{}", stats.longest_rejection);
    }
}
