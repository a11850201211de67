use super::*;
use crate::check::{self, Law, Report, Trials};
use crate::engine::{
    Accumulated, Film, Metropolis, Mixture, Mutation, Purpose, Share, Splat, generator, render, uniform,
};
use rand_pcg::rand_core::Rng;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};

const SITES: usize = 4;

/// F(u, v) = u² v_1 … v_n at the site ⌊4u⌋, with n such that the first n of a row of numbers, one beside each v, are below
/// `GO_ON`. ∫ F at a site is ∫ u² du · Σ_n (1 − g) gⁿ 2⁻ⁿ.
#[derive(Clone, Copy)]
struct Toy {
    /// u is drawn from [low, high): the stratum.
    low: f64,
    high: f64,
}

const GO_ON: f64 = 0.6;

#[derive(Clone, Debug, Default, PartialEq)]
struct Value {
    u: f64,
    value: f64,
}

impl Output for Value {
    type Splat = Splat<1>;

    fn importance(&self) -> f64 {
        self.value * (1.5 - self.u)
    }

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        std::iter::once(Splat { site: (self.u * SITES as f64) as u32, value: [self.value] })
    }
}

impl Tracer<2> for Toy {
    type Output = Value;

    fn trace(&self, [first, rest]: &mut Streams<2>, output: &mut Value) -> bool {
        output.u = self.low + (self.high - self.low) * uniform(first);
        output.value = (self.high - self.low) * output.u * output.u;
        while uniform(rest) < GO_ON {
            output.value *= uniform(rest);
        }
        output.value > 0.0
    }
}

fn exact(site: usize) -> f64 {
    let cube = |i: usize| (i as f64 / SITES as f64).powi(3) / 3.0;
    (cube(site + 1) - cube(site)) * (1.0 - GO_ON) / (1.0 - 0.5 * GO_ON)
}

fn strata(cuts: &[f64]) -> Vec<PrimaryStratum<Toy>> {
    let of = |w: &[f64]| PrimaryStratum { tracer: Toy { low: w[0], high: w[1] }, power: w[1] - w[0] };
    cuts.windows(2).map(of).collect()
}

/// The mutations, with an error: a state of smaller u is accepted `factor` times as often as it should be.
struct Skewed {
    mutation: PrimaryMutation,
    factor: f64,
}

type State = PrimaryPath<Value, 2>;

impl Mutation<State, PrimaryStratum<Toy>> for Skewed {
    fn name(&self) -> &'static str {
        Mutation::<State, PrimaryStratum<Toy>>::name(&self.mutation)
    }

    fn suitability(&self, current: &State) -> f64 {
        Mutation::<State, PrimaryStratum<Toy>>::suitability(&self.mutation, current)
    }

    fn propose(
        &self,
        current: &State,
        proposal: &mut State,
        within: &PrimaryStratum<Toy>,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let ratio = self.mutation.propose(current, proposal, within, rng)?;
        Some(if proposal.output().u < current.output().u { self.factor * ratio } else { ratio })
    }
}

fn skewed(factor: f64) -> Mixture<State, PrimaryStratum<Toy>, Skewed> {
    Mixture::new(PrimaryMutation::both(0.2).into_iter().map(|mutation| Skewed { mutation, factor }).collect())
}

/// Largest |z| of a site's mean over 3,000 rounds of 40 mutations a stratum.
fn largest_z(cuts: &[f64], factor: f64) -> f64 {
    let (strata, mixture) = (strata(cuts), skewed(factor));
    let share = Share { mutations: 40, samples: 8 };
    let strata: Vec<_> = strata.into_iter().map(|stratum| (stratum, share)).collect();
    let metropolis = Metropolis::new(&strata, &mixture, &PrimaryImportance, 5).expect("sound");
    let mut sums = Accumulated::new(Film::<1>::new(SITES as u32, 1.0));
    render(&metropolis, 0..3000, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let (film, _) = sums.into_parts();
    let z = |site| {
        let [pixel] = film.pixel(site);
        (pixel.mean - exact(site)) / pixel.stderr
    };
    (0..SITES).map(|site| z(site).abs()).fold(0.0, f64::max)
}

#[test]
fn short_rounds_are_unbiased_in_any_strata() {
    for cuts in [&[0.0, 1.0][..], &[0.0, 0.3, 1.0], &[0.0, 0.25, 0.5, 0.9, 1.0]] {
        let z = largest_z(cuts, 1.0);
        assert!(z < 4.0, "{cuts:?}: z = {z}");
    }
    let z = largest_z(&[0.0, 1.0], 1.7);
    assert!(z > 6.0, "the control goes unnoticed: z = {z}");
}

/// Of (site, n) after some steps, and of each mutation's ratio.
fn checked(factor: f64) -> Report {
    let bin = |path: &State| {
        let n = (path.streams()[1].numbers().len() - 1) / 2;
        4 * (path.output().u * 4.0) as usize + n.min(3)
    };
    check::mutation(&skewed(factor), &strata(&[0.0, 1.0])[0], &PrimaryImportance, bin, TRIALS)
}

const TRIALS: Trials = Trials { count: 200_000, seed: 9 };

#[test]
fn steps_are_symmetric_and_keep_the_target() {
    assert!(checked(1.0).is_sound(), "{}", checked(1.0));
    let report = checked(1.3);
    assert!(report.breaks(Law::Inverse) && report.breaks(Law::Stationary), "the control goes unnoticed: {report}");
}

/// A tracer that counts its calls, and one that adds to what was there.
struct Impure {
    calls: AtomicU32,
    adds: bool,
}

impl Tracer<2> for Impure {
    type Output = Value;

    fn trace(&self, streams: &mut Streams<2>, output: &mut Value) -> bool {
        let before = output.value;
        let lit = Toy { low: 0.0, high: 1.0 }.trace(streams, output);
        if self.adds {
            output.value += before;
        } else {
            output.value *= f64::from(1 + self.calls.fetch_add(1, Ordering::Relaxed) % 3);
        }
        lit
    }
}

#[test]
fn a_tracer_is_a_function_of_its_numbers() {
    let broken = |report: Report| report.broken.iter().map(|finding| finding.law).collect::<Vec<_>>();
    let impure = |adds| Impure { calls: AtomicU32::new(0), adds };
    let trials = Trials { count: 100, seed: 1 };
    assert_eq!(broken(check::tracer(&Toy { low: 0.0, high: 1.0 }, trials)), []);
    assert!(broken(check::tracer(&impure(false), trials)).contains(&Law::Repeatable));
    assert!(broken(check::tracer(&impure(true), trials)).contains(&Law::Overwritten));
}

/// Of all streams, one after the other.
fn numbers(path: &State) -> Vec<u32> {
    path.streams().iter().flat_map(Stream::numbers).copied().collect()
}

/// χ² with 255 degrees of freedom of the first four bits of pairs of numbers, from many states of which each began a stream: two of
/// one block, of two blocks, of two streams.
#[test]
fn fresh_numbers_are_independent_of_each_other() {
    let tracer = Long;
    let mut rng = generator(6, Purpose::Sample, 0, 0, 0);
    let pairs = [[0, 1], [3, 7], [0, 8], [5, 17], [2, 24], [9, 40]];
    let mut counts = [[[0.0; 16]; 16]; 6];
    let states = 40_000;
    let mut path = PrimaryPath::<Value, 2>::default();
    for _ in 0..states {
        path.propose(None, &tracer, &mut rng);
        let numbers = numbers(&path);
        for ([i, j], counts) in pairs.iter().zip(&mut counts) {
            counts[(numbers[*i] >> 28) as usize][(numbers[*j] >> 28) as usize] += 1.0;
        }
    }
    let expected = f64::from(states) / 256.0;
    for (pair, counts) in pairs.iter().zip(&counts) {
        let x: f64 = counts.iter().flatten().map(|n: &f64| (n - expected).powi(2) / expected).sum();
        assert!((160.0..380.0).contains(&x), "{pair:?}: χ² = {x}");
    }
}

/// Draws three blocks from each stream.
struct Long;

impl Tracer<2> for Long {
    type Output = Value;

    fn trace(&self, streams: &mut Streams<2>, output: &mut Value) -> bool {
        output.value = streams.iter_mut().map(|stream| (0..24).map(|_| uniform(stream)).sum::<f64>()).sum();
        true
    }
}

#[test]
fn small_steps_are_symmetric_and_log_uniform_between_their_bounds() {
    let near = StepSize::new(1.0 / 1024.0, 1.0 / 64.0);
    let mut rng = generator(2, Purpose::Sample, 0, 0, 0);
    let (mut up, mut octaves) = (0, [0; 4]);
    for _ in 0..40_000 {
        let number = rng.next_u32();
        let offset = near.apply(number, rng.next_u32()).wrapping_sub(number) as i32;
        up += i32::from(offset > 0);
        let size = f64::from(offset.unsigned_abs()) / 4_294_967_296.0;
        assert!((1.0 / 1024.0..=1.0 / 64.0).contains(&size), "{size}");
        octaves[((1.0 / 64.0 / size).log2() as usize).min(3)] += 1;
    }
    assert!((up - 20_000).abs() < 400, "{up}");
    assert!(octaves.iter().all(|n: &i32| (n - 10_000).abs() < 400), "{octaves:?}");
}

#[test]
fn a_small_step_moves_every_number_a_little_and_none_to_another_place() {
    let stratum = &strata(&[0.0, 1.0])[0];
    let small = PrimaryMutation::Small(SmallStep::new(1.0, 1.0 / 1024.0, 1.0 / 64.0));
    let mut rng = generator(3, Purpose::Sample, 0, 0, 0);
    let (mut x, mut y) = (State::default(), State::default());
    x.propose(None, &stratum.tracer, &mut rng);
    for _ in 0..1000 {
        small.propose(&x, &mut y, stratum, &mut rng).expect("never dark");
        let [of_x, of_y] = [&x, &y].map(|path| path.streams()[1].numbers().len());
        for (a, b) in numbers(&x).into_iter().zip(numbers(&y)).take(2 + of_x) {
            let distance = a.wrapping_sub(b).min(b.wrapping_sub(a));
            let shared = of_y >= of_x;
            assert!(!shared || (1 << 21..=1 << 26).contains(&distance), "{distance}");
        }
        std::mem::swap(&mut x, &mut y);
    }
}
