//! The film: exact sums over rounds, whatever their order.

use super::bytes::{put, put_list};
use super::{DecodeError, Deposits, Lost, Reader, Rounds};
use rayon::prelude::*;
use std::error::Error;
use std::fmt;

/// Most sites of a band, log₂: 2^13 sites of three f64 channels are 192 KiB.
const MOST_SITES: u32 = 13;
/// Least sites of a band, log₂: a list for each band and task has to be worth its while.
const LEAST_SITES: u32 = 9;
/// Bands of a small film, log₂: as many threads can merge into it at once.
const BANDS: u32 = 6;

/// Sums of rounds in fixed point, and the round that is being made.
///
/// Within a round deposits are added in the order of its tasks. Over rounds each site keeps Σ w X and Σ w X² as integers,
/// so that any grouping of the same rounds, over threads, processes or machines, gives the same bits.
#[derive(Clone, Debug)]
pub struct Film<const C: usize> {
    round: Vec<[f64; C]>,
    sums: Vec<[Sums; C]>,
    whole: Whole<C>,
    unit: f64,
    weight: u64,
    rounds: Rounds,
    lost: Lost,
    /// log₂ of the number of sites in a band, which one thread merges.
    shift: u32,
}

/// Σ w X in 2⁻⁶⁰ units and Σ w X² in 2⁻⁶⁰ units².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sums {
    first: i128,
    second: i128,
}

impl Sums {
    /// Adds a round. Squares that do not fit stay at the largest integer, in any order of the rounds, since none is negative.
    #[inline]
    fn add(&mut self, value: f64, weight: i128) {
        if value == 0.0 {
            return;
        }
        let [first, second] = [quantise(value), quantise(value * value)];
        // Most rounds count once, and a product that stays in its range is slow.
        let [first, second] =
            if weight == 1 { [first, second] } else { [first, second].map(|x| x.saturating_mul(weight)) };
        self.first = self.first.saturating_add(first);
        self.second = self.second.saturating_add(second);
    }
}

/// The same of X̄, the mean over all sites: Σ w X̄ of each channel, and Σ w X̄ X̄′ of each two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Whole<const C: usize> {
    first: [i128; C],
    second: [[i128; C]; C],
}

impl<const C: usize> Whole<C> {
    /// Adds a round.
    fn add(&mut self, mean: [f64; C], weight: i128) {
        let mut products = [[0; C]; C];
        for (row, a) in products.iter_mut().zip(mean) {
            *row = mean.map(|b| quantise(a * b).saturating_mul(weight));
        }
        self.merge(&Self { first: mean.map(|a| quantise(a).saturating_mul(weight)), second: products });
    }

    /// Adds others.
    fn merge(&mut self, other: &Self) {
        let sums = self.first.iter_mut().chain(self.second.iter_mut().flatten());
        let others = other.first.iter().chain(other.second.iter().flatten());
        sums.zip(others).for_each(|(a, b)| *a = a.saturating_add(*b));
    }
}

/// Mean and standard error of one channel of one site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Σ w X / Σ w over the rounds.
    pub mean: f64,
    /// Standard error of `mean`; infinite with fewer than two rounds and where the squares left their range.
    pub stderr: f64,
}

impl<const C: usize> Film<C> {
    /// A black film. `unit` is a value of a site, right to within a factor of 10⁴ or so: it sets the quanta of the
    /// sums, 2⁻⁶⁰ units and 2⁻⁶⁰ units², and their ranges, 2⁶⁷ units and units².
    pub fn new(sites: u32, unit: f64) -> Self {
        let unit = if unit.is_normal() && unit > 0.0 { libm::exp2(libm::floor(libm::log2(unit))) } else { 1.0 };
        let n = sites as usize;
        let (round, sums) = (vec![[0.0; C]; n], vec![[Sums::default(); C]; n]);
        let shift = (sites.checked_ilog2().unwrap_or(0)).saturating_sub(BANDS).clamp(LEAST_SITES, MOST_SITES);
        let whole = Whole { first: [0; C], second: [[0; C]; C] };
        Self { round, sums, whole, unit, weight: 0, rounds: Rounds::default(), lost: Lost::default(), shift }
    }

    /// Number of sites.
    pub fn sites(&self) -> u32 {
        self.sums.len() as u32
    }

    /// Number of rounds in the sums.
    pub fn rounds(&self) -> u64 {
        self.rounds.count()
    }

    /// Which rounds these are.
    pub fn rounds_held(&self) -> &Rounds {
        &self.rounds
    }

    /// Σ w over them.
    pub fn weight(&self) -> u64 {
        self.weight
    }

    /// Deposits left out because they were not finite or lay outside.
    pub fn lost(&self) -> &Lost {
        &self.lost
    }

    /// An empty list for one task's deposits.
    pub fn deposits(&self) -> Deposits<C> {
        Deposits::new(self.sites(), self.shift)
    }

    /// Adds tasks' deposits to the current round, in their order.
    pub fn add(&mut self, tasks: &[Deposits<C>]) {
        tasks.iter().for_each(|task| self.lost.merge(task.lost()));
        let shift = self.shift;
        self.round.par_chunks_mut(1 << shift).enumerate().for_each(|(band, sites)| {
            let first = band << shift;
            for deposit in tasks.iter().flat_map(|t| t.band(band)) {
                let site = &mut sites[deposit.site as usize - first];
                site.iter_mut().zip(deposit.value).for_each(|(s, v)| *s += f64::from(v));
            }
        });
    }

    /// Ends the current round, which has this number and is an estimate X of the film, and adds it to the sums with weight
    /// `weight`.
    ///
    /// Var(X) ∝ 1/weight is assumed: a round's weight is its number of samples.
    pub fn close_round(&mut self, number: u64, weight: u64) {
        let scale = 1.0 / self.unit;
        let sites = 1 << self.shift;
        let bands = self.round.par_chunks_mut(sites).zip(self.sums.par_chunks_mut(sites));
        let close = |(round, sums): (&mut [[f64; C]], &mut [[Sums; C]])| {
            let mut total = [0.0; C];
            for (x, s) in round.iter_mut().zip(sums) {
                let value = std::mem::replace(x, [0.0; C]).map(|x| x * scale);
                for c in 0..C {
                    s[c].add(value[c], i128::from(weight));
                    total[c] += value[c];
                }
            }
            total
        };
        let totals: Vec<_> = bands.map(close).collect();
        let mean = std::array::from_fn(|c| totals.iter().map(|t| t[c]).sum::<f64>() / f64::from(self.sites()));
        self.whole.add(mean, i128::from(weight));
        self.weight += weight;
        self.rounds.insert(number..number + 1);
    }

    /// Drops the current round.
    pub fn drop_round(&mut self) {
        self.round.par_iter_mut().for_each(|x| *x = [0.0; C]);
    }

    /// Frees the memory of the current round; the film takes no more of them.
    pub fn finish(&mut self) {
        self.round = Vec::new();
    }

    /// Adds the sums of another film.
    ///
    /// # Errors
    ///
    /// Changes nothing if the films differ in size or unit, or have a round in common.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        if self.sites() != other.sites() {
            return Err(MergeError::Sites([self.sites(), other.sites()]));
        }
        if self.unit != other.unit {
            return Err(MergeError::Unit);
        }
        let common = self.rounds.common(&other.rounds);
        if common.count() > 0 {
            return Err(MergeError::Rounds(common));
        }
        for (a, b) in self.sums.iter_mut().flatten().zip(other.sums.iter().flatten()) {
            a.first = a.first.saturating_add(b.first);
            a.second = a.second.saturating_add(b.second);
        }
        self.whole.merge(&other.whole);
        self.weight += other.weight;
        other.rounds.ranges().iter().for_each(|range| self.rounds.insert(range.clone()));
        self.lost.merge(&other.lost);
        Ok(())
    }

    /// Appends the sums to bytes: the same bytes for the same rounds. The current round is left out.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        [u64::from(self.sites()), self.unit.to_bits(), self.weight, self.lost.count]
            .into_iter()
            .for_each(|x| put(to, x));
        put_list(to, &self.lost.sites, |to, site| put(to, u64::from(*site)));
        self.rounds.write(to);
        let sums = self.sums.iter().flatten().flat_map(|sums| [sums.first, sums.second]);
        let whole = self.whole.first.iter().chain(self.whole.second.iter().flatten());
        sums.chain(whole.copied()).for_each(|sum| to.extend(sum.to_le_bytes()));
    }

    /// Reads what [`write`](Self::write) has written.
    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let [sites, unit, weight, lost] = [from.number()?, from.number()?, from.number()?, from.number()?];
        let sites = u32::try_from(sites).map_err(|_| DecodeError::Damaged)?;
        from.expect(u64::from(sites) * C as u64 * size_of::<Sums>() as u64)?;
        let mut film = Self::new(sites, f64::from_bits(unit));
        if film.unit.to_bits() != unit {
            return Err(DecodeError::Damaged);
        }
        film.lost = Lost { count: lost, sites: from.list(|from| from.number().map(|site| site as u32))? };
        (film.weight, film.rounds) = (weight, Rounds::read(from)?);
        let sums = film.sums.iter_mut().flatten().flat_map(|sums| [&mut sums.first, &mut sums.second]);
        let whole = film.whole.first.iter_mut().chain(film.whole.second.iter_mut().flatten());
        for sum in sums.chain(whole) {
            *sum = from.bytes().map(i128::from_le_bytes)?;
        }
        Ok(film)
    }

    /// Means of a site's channels, of the rounds closed so far; 0 without any.
    #[inline]
    pub fn mean(&self, site: usize) -> [f64; C] {
        let scale = if self.weight == 0 { 0.0 } else { self.unit / (QUANTA * self.weight as f64) };
        self.sums[site].map(|s| s.first as f64 * scale)
    }

    /// Mean and standard error of a site's channels, of the rounds closed so far; 0 without any.
    pub fn pixel(&self, site: usize) -> [Pixel; C] {
        self.sums[site].map(|s| {
            let Moments { mean, variance } = self.moments(dequantise(s.first), dequantise(s.second));
            let stderr = if s.second == i128::MAX { f64::INFINITY } else { variance.sqrt() * self.unit };
            Pixel { mean: mean * self.unit, stderr }
        })
    }

    /// Mean over all sites of Σ_c weights_c × channel c, and its standard error: the scatter over rounds of that mean. What
    /// sites have in common in a round is in it, which no sum over the sites' own errors has.
    pub fn whole(&self, weights: [f64; C]) -> Pixel {
        let Whole { first, second } = &self.whole;
        let weighted = |row: &[i128; C]| row.iter().zip(weights).map(|(&x, w)| w * dequantise(x)).sum::<f64>();
        let square = second.iter().zip(weights).map(|(row, w)| w * weighted(row)).sum();
        let Moments { mean, variance } = self.moments(weighted(first), square);
        Pixel { mean: mean * self.unit, stderr: variance.sqrt() * self.unit }
    }

    /// From Σ w X and Σ w X² over the rounds, in the same unit.
    ///
    /// mean = Σ w X / W,  stderr² = (Σ w X² − W mean²) / ((R − 1) W),  W = Σ w,  and what rounding may hide of X².
    fn moments(&self, first: f64, second: f64) -> Moments {
        let rounds = self.rounds.count() as f64;
        if rounds == 0.0 {
            return Moments { mean: 0.0, variance: f64::INFINITY };
        }
        let w = self.weight as f64;
        let mean = first / w;
        let rounding = if first == 0.0 { 0.0 } else { 0.5 / QUANTA };
        let scatter = (second / w - mean * mean).max(0.0) + rounding;
        Moments { mean, variance: if rounds < 2.0 { f64::INFINITY } else { scatter / (rounds - 1.0) } }
    }
}

/// Why two films cannot be added.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MergeError {
    /// They differ in the number of sites.
    Sites([u32; 2]),
    /// They differ in the unit of their sums.
    Unit,
    /// They were made of other scenes or with other settings.
    Key {
        /// The property that differs.
        name: String,
        /// Its values.
        values: [String; 2],
    },
    /// Both hold these rounds, which would count twice.
    Rounds(Rounds),
}

impl Error for MergeError {}

impl fmt::Display for MergeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sites([a, b]) => write!(f, "one film has {a} sites and the other {b}; they are not of one image"),
            Self::Unit => write!(f, "the films have different units; they are not of one scene and view"),
            Self::Key { name, values: [a, b] } => {
                write!(f, "{name} is {a} in one and {b} in the other; they are not of one render")
            }
            Self::Rounds(rounds) => write!(f, "both films hold the rounds {rounds}, which would count twice"),
        }
    }
}

/// Of a mean over rounds.
struct Moments {
    mean: f64,
    /// Squared standard error; infinite with fewer than two rounds.
    variance: f64,
}

const QUANTA: f64 = (1u64 << 60) as f64;

/// Nearest multiple of 2⁻⁶⁰.
#[inline]
fn quantise(x: f64) -> i128 {
    let scaled = x * QUANTA;
    // Most values fit 64 bits, whose conversion is one instruction.
    let nearest = scaled + 0.5f64.copysign(scaled);
    if nearest.abs() < 9.0e18 { i128::from(nearest as i64) } else { nearest as i128 }
}

fn dequantise(sum: i128) -> f64 {
    sum as f64 / QUANTA
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Sink, Splat};

    fn rounds(film: &mut Film<1>, values: &[(f64, u64)]) {
        from_round(film, 0, values);
    }

    fn from_round(film: &mut Film<1>, first: u64, values: &[(f64, u64)]) {
        for (number, &(value, weight)) in (first..).zip(values) {
            let mut deposits = film.deposits();
            deposits.deposit(Splat { site: 1, value: [value] }, 0.5);
            deposits.deposit(Splat { site: 1, value: [value] }, 0.5);
            film.add(&[deposits]);
            film.close_round(number, weight);
        }
    }

    #[test]
    fn mean_and_standard_error_match_the_textbook() {
        let mut film = Film::<1>::new(2, 1.0);
        rounds(&mut film, &[(1.0, 1), (2.0, 1), (4.0, 1), (5.0, 1)]);
        let [pixel] = film.pixel(1);
        assert_eq!(pixel.mean, 3.0);
        assert!((pixel.stderr - (10.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
        assert_eq!(film.pixel(0)[0], Pixel { mean: 0.0, stderr: 0.0 });
    }

    #[test]
    fn any_grouping_of_rounds_gives_the_same_bits() {
        let values: Vec<_> = (1..20).map(|i| (1e-3 * 1.7f64.powi(i), i as u64)).collect();
        let mut whole = Film::new(2, 0.3);
        rounds(&mut whole, &values);
        let (mut a, mut b) = (Film::new(2, 0.3), Film::new(2, 0.3));
        from_round(&mut b, 7, &values[7..]);
        rounds(&mut a, &values[..7]);
        assert_eq!(b.merge(&a), Ok(()));
        assert_eq!(b.rounds_held(), whole.rounds_held());
        assert_eq!(whole.pixel(1), b.pixel(1));
        assert_eq!(whole.whole([1.0]), b.whole([1.0]));
        assert_eq!(b.merge(&Film::new(3, 0.3)), Err(MergeError::Sites([2, 3])));
        assert_eq!(b.merge(&Film::new(2, 8.0)), Err(MergeError::Unit));
    }

    #[test]
    fn a_round_does_not_count_twice() {
        let (mut a, mut b) = (Film::new(2, 1.0), Film::new(2, 1.0));
        rounds(&mut a, &[(1.0, 1), (2.0, 1), (4.0, 1)]);
        from_round(&mut b, 2, &[(4.0, 1), (5.0, 1)]);
        let before = a.pixel(1);
        let error = a.merge(&b).expect_err("a round in common");
        assert!(error.to_string().contains("both films hold the rounds 2,"), "{error}");
        assert_eq!((a.pixel(1), a.rounds()), (before, 3));
    }

    /// Two sites that are bright together, or one at a time.
    #[test]
    fn the_error_of_the_whole_has_what_sites_have_in_common() {
        let film = |values: [[f64; 2]; 4]| {
            let mut film = Film::<2>::new(2, 1.0);
            for (round, [a, b]) in (0..).zip(values) {
                let mut deposits = film.deposits();
                deposits.deposit(Splat { site: 0, value: [a, 2.0 * a] }, 1.0);
                deposits.deposit(Splat { site: 1, value: [b, 0.0] }, 1.0);
                film.add(&[deposits]);
                film.close_round(round, 1);
            }
            film
        };
        let together = film([[1.0, 1.0], [3.0, 3.0], [1.0, 1.0], [3.0, 3.0]]);
        let Pixel { mean, stderr } = together.whole([1.0, 0.5]);
        // Rounds of (1 + 1 + 1)/2 and of three times that.
        assert!((mean - 3.0).abs() < 1e-12 && (stderr - 1.5 / 3f64.sqrt()).abs() < 1e-12, "{mean} ± {stderr}");
        let in_turn = film([[1.0, 3.0], [3.0, 1.0], [1.0, 3.0], [3.0, 1.0]]);
        let Pixel { mean, stderr } = in_turn.whole([1.0, 0.0]);
        assert!(mean == 2.0 && stderr < 1e-8, "{mean} ± {stderr}");
        // The negative control: squares of the sites' own errors know no difference.
        let own = |film: &Film<2>| (0..2).map(|i| film.pixel(i)[0].stderr.powi(2)).sum::<f64>();
        assert!((own(&together) - own(&in_turn)).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_left_out() {
        let mut film = Film::<1>::new(2, 1.0);
        rounds(&mut film, &[(f64::NAN, 1), (1.0, 1)]);
        assert_eq!(film.lost(), &Lost { count: 2, sites: vec![1] });
        assert_eq!(film.pixel(1)[0].mean, 0.5);
    }

    #[test]
    fn squares_out_of_range_make_the_error_unknown_and_not_zero() {
        let mut film = Film::<1>::new(2, 1.0);
        rounds(&mut film, &[(1e11, 1), (3e11, 1)]);
        let [pixel] = film.pixel(1);
        assert!((pixel.mean / 2e11 - 1.0).abs() < 1e-6);
        assert_eq!(pixel.stderr, f64::INFINITY);
    }

    #[test]
    fn squares_below_the_quantum_leave_an_error() {
        let mut film = Film::<1>::new(2, 1.0);
        rounds(&mut film, &[(1e-11, 1), (3e-11, 1)]);
        let [pixel] = film.pixel(1);
        assert!((pixel.mean / 2e-11 - 1.0).abs() < 1e-6);
        assert!(pixel.stderr > 1e-11 && pixel.stderr < 1e-9, "{pixel:?}");
        assert_eq!(film.pixel(0)[0].stderr, 0.0);
    }

    #[test]
    fn a_value_far_above_the_unit_does_not_overflow() {
        let mut film = Film::<1>::new(2, 1e-6);
        rounds(&mut film, &[(1e3, 1), (1e3, 1)]);
        let [pixel] = film.pixel(1);
        assert!((pixel.mean / 1e3 - 1.0).abs() < 1e-12 && pixel.stderr < 1e-3);
    }
}
