//! The film: exact sums over rounds, whatever their order.

use super::band::Band;
use super::bytes::{put, put_list};
use super::count::add_count;
use super::fixed::{Products, Sums};
use super::{Blocks, DecodeError, Deposit, Deposits, Lost, MergeError, Reader, Rounds};
use rayon::prelude::*;

/// Most sites of a band, log₂: 2^13 sites of three f64 channels, as a task's deposits are summed in, are 192 KiB.
const MOST_SITES: u32 = 13;
/// Least sites of a band, log₂: a list for each band and task has to be worth its while.
const LEAST_SITES: u32 = 9;
/// Bands of a small film, log₂: as many threads can merge into it at once.
const BANDS: u32 = 6;

/// Sums of rounds in fixed point, and the round that is being made.
///
/// Within a round each task's deposits at a site are added in f64, and then to those of the tasks before it in f32, which the noise of a round
/// hides. Over rounds each site keeps Σ w X and Σ w X² as integers, so that any grouping of the same rounds, over threads, processes or
/// machines, gives the same bits. The same is kept of X̄, the mean over all sites, and of each round what it gave to [`Blocks`] of the film.
///
/// An image of three channels takes 12 bytes a pixel for the current round, and mostly 45 for its sums: 7 for each Σ w X, 8 for each Σ w X².
#[derive(Clone, Debug)]
pub struct Film<const C: usize> {
    size: [u32; 2],
    /// Empty without any deposit.
    round: Vec<[f32; C]>,
    sums: Vec<Band<C>>,
    pub(super) whole: Products<C>,
    blocks: Blocks<C>,
    pub(super) unit: f64,
    weight: u64,
    rounds: Rounds,
    lost: Lost,
    /// log₂ of the number of sites in a band, which one thread merges.
    shift: u32,
}

impl<const C: usize> Film<C> {
    /// A black film of sites in one row. `unit` is a value of a site, right to within a factor of 10⁴ or so: it sets the quanta of
    /// the sums, 2⁻³⁶ units and 2⁻³⁶ units², and their ranges, 2⁹¹ units and units².
    pub fn new(sites: u32, unit: f64) -> Self {
        Self::of_image([sites, 1], unit)
    }

    /// A black film of an image with this width and height, whose sites are its pixels row by row.
    pub fn of_image(size: [u32; 2], unit: f64) -> Self {
        let unit = if unit.is_normal() && unit > 0.0 { libm::exp2(libm::floor(libm::log2(unit))) } else { 1.0 };
        let sites = size[0] * size[1];
        let shift = (sites.checked_ilog2().unwrap_or(0)).saturating_sub(BANDS).clamp(LEAST_SITES, MOST_SITES);
        let (round, sums) = (Vec::new(), bands(sites, shift).map(Band::new).collect());
        let (whole, blocks, rounds, lost) = (Products::ZERO, Blocks::new(size), Rounds::default(), Lost::default());
        Self { size, round, sums, whole, blocks, unit, weight: 0, rounds, lost, shift }
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of sites.
    pub fn sites(&self) -> u32 {
        self.size[0] * self.size[1]
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

    /// Contribution of each of them to the blocks of the film.
    pub fn blocks(&self) -> &Blocks<C> {
        &self.blocks
    }

    /// Deposits left out because they were not finite or lay outside.
    pub fn lost(&self) -> &Lost {
        &self.lost
    }

    /// An empty list for one task's deposits.
    pub fn deposits(&self) -> Deposits<C> {
        Deposits::new(self.sites(), self.shift)
    }

    /// Sums of a site's channels.
    #[inline]
    pub(super) fn sums(&self, site: usize) -> [Sums; C] {
        self.sums[site >> self.shift].get(site & ((1 << self.shift) - 1))
    }

    /// The current round so far, site by site.
    pub(super) fn round(&self) -> &[[f32; C]] {
        &self.round
    }

    /// Adds tasks' deposits to the current round, in their order.
    pub fn add(&mut self, tasks: &mut [Deposits<C>]) {
        tasks.par_iter_mut().for_each_init(Vec::new, |scratch, task| task.sort(scratch));
        tasks.iter().for_each(|task| self.lost.merge(task.lost()));
        self.begin();
        let shift = self.shift;
        let add = |of_task: &mut Vec<[f64; C]>, (band, sites): (usize, &mut [[f32; C]])| {
            let first = band << shift;
            for deposits in tasks.iter().map(|task| task.band(band)) {
                for Deposit { site, value } in deposits {
                    of_task[*site as usize - first].iter_mut().zip(value).for_each(|(sum, v)| *sum += f64::from(*v));
                }
                for site in deposits.iter().map(|deposit| deposit.site as usize - first) {
                    let sum = std::mem::replace(&mut of_task[site], [0.0; C]);
                    sites[site].iter_mut().zip(sum).for_each(|(round, sum)| *round += sum as f32);
                }
            }
        };
        let none = || vec![[0.0; C]; 1 << shift];
        self.round.par_chunks_mut(1 << shift).enumerate().for_each_init(none, add);
    }

    /// Makes room for a round.
    fn begin(&mut self) {
        self.round.resize(self.sites() as usize, [0.0; C]);
    }

    /// Ends the current round, which has this number and is an estimate X of the film, and adds it to the sums with weight
    /// `weight`.
    ///
    /// Var(X) ∝ 1/weight is assumed: a round's weight is its number of samples.
    pub fn close_round(&mut self, number: u64, weight: u64) {
        self.begin();
        self.blocks.add(number, &self.round);
        let scale = 1.0 / self.unit;
        let close = |(round, sums): (&mut [[f32; C]], &mut Band<C>)| {
            let mut total = [0.0; C];
            for (site, x) in round.iter_mut().enumerate() {
                let value = std::mem::replace(x, [0.0; C]).map(|x| f64::from(x) * scale);
                for c in (0..C).filter(|&c| value[c] != 0.0) {
                    sums.add(site, c, Sums::of(value[c], i128::from(weight)));
                    total[c] += value[c];
                }
            }
            total
        };
        let bands = self.round.par_chunks_mut(1 << self.shift).zip(&mut self.sums);
        let totals: Vec<_> = bands.map(close).collect();
        let mean = std::array::from_fn(|c| totals.iter().map(|t| t[c]).sum::<f64>() / f64::from(self.sites()));
        self.whole.add(mean, i128::from(weight));
        add_count(&mut self.weight, weight);
        self.rounds.insert(number..number + 1);
    }

    /// Drops the current round.
    pub fn drop_round(&mut self) {
        self.round.par_iter_mut().for_each(|x| *x = [0.0; C]);
    }

    /// Makes the film black again.
    pub fn clear(&mut self) {
        self.drop_round();
        self.sums = bands(self.sites(), self.shift).map(Band::new).collect();
        self.blocks.clear();
        (self.whole, self.weight, self.rounds, self.lost) = (Products::ZERO, 0, Rounds::default(), Lost::default());
    }

    /// Drops the current round and frees its memory.
    pub fn finish(&mut self) {
        self.round = Vec::new();
    }

    /// Adds the sums of another film.
    ///
    /// # Errors
    ///
    /// Changes nothing if the films differ in size or unit, or have a round in common.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        if self.size != other.size {
            return Err(MergeError::Sizes([self.size, other.size]));
        }
        if self.unit != other.unit {
            return Err(MergeError::Unit);
        }
        let common = self.rounds.common(&other.rounds);
        if common.count() > 0 {
            return Err(MergeError::Rounds(common));
        }
        self.sums.par_iter_mut().zip(&other.sums).for_each(|(a, b)| a.merge(b));
        self.whole.merge(&other.whole);
        self.blocks.merge(&other.blocks);
        add_count(&mut self.weight, other.weight);
        other.rounds.ranges().iter().for_each(|range| self.rounds.insert(range.clone()));
        self.lost.merge(&other.lost);
        Ok(())
    }

    /// Appends the sums to bytes: the same bytes for the same rounds. The current round is left out.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        let [width, height] = self.size.map(u64::from);
        [width, height, self.unit.to_bits(), self.weight, self.lost.count].into_iter().for_each(|x| put(to, x));
        put_list(to, &self.lost.sites, |to, site| put(to, u64::from(*site)));
        self.rounds.write(to);
        self.sums.iter().for_each(|sums| sums.write(to));
        self.whole.write(to);
        self.blocks.write(to);
    }

    /// Reads what [`write`](Self::write) has written.
    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let number = |from: &mut Reader| u32::try_from(from.number()?).map_err(|_| DecodeError::Damaged);
        let size = [number(from)?, number(from)?];
        let sites = size[0].checked_mul(size[1]).ok_or(DecodeError::Damaged)?;
        let [unit, weight, lost] = [from.number()?, from.number()?, from.number()?];
        from.expect(u64::from(sites) * C as u64 * 2)?;
        let mut film = Self::of_image(size, f64::from_bits(unit));
        if film.unit.to_bits() != unit {
            return Err(DecodeError::Damaged);
        }
        film.lost = Lost { count: lost, sites: from.list(number)? };
        (film.weight, film.rounds) = (weight, Rounds::read(from)?);
        film.sums = bands(sites, film.shift).map(|sites| Band::read(sites, from)).collect::<Result<_, _>>()?;
        (film.whole, film.blocks) = (Products::read(from)?, Blocks::read(size, from)?);
        Ok(film)
    }
}

/// Numbers of sites of a film's bands.
fn bands(sites: u32, shift: u32) -> impl Iterator<Item = usize> {
    let sites = sites as usize;
    (0..sites).step_by(1 << shift).map(move |first| (sites - first).min(1 << shift))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Pixel, Sink, Splat};

    fn rounds(film: &mut Film<1>, values: &[(f64, u64)]) {
        from_round(film, 0, values);
    }

    fn from_round(film: &mut Film<1>, first: u64, values: &[(f64, u64)]) {
        for (number, &(value, weight)) in (first..).zip(values) {
            let mut deposits = film.deposits();
            deposits.deposit(Splat { site: 1, value: [value] }, 0.5);
            deposits.deposit(Splat { site: 1, value: [value] }, 0.5);
            film.add(&mut [deposits]);
            film.close_round(number, weight);
        }
    }

    #[test]
    fn mean_and_standard_error_match_the_textbook() {
        let mut film = Film::<1>::new(2, 1.0);
        rounds(&mut film, &[(1.0, 1), (2.0, 1), (4.0, 1), (5.0, 1)]);
        let [pixel] = film.pixel(1);
        assert_eq!(pixel.mean, 3.0);
        // What rounding may hide of squares is added: 2⁻³⁷.
        assert!((pixel.stderr - (10.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-11);
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
        assert_eq!(whole.blocks(), b.blocks());
        assert_eq!(b.merge(&Film::new(3, 0.3)), Err(MergeError::Sizes([[2, 1], [3, 1]])));
        assert_eq!(b.merge(&Film::new(2, 8.0)), Err(MergeError::Unit));
    }

    #[test]
    fn a_cleared_film_is_a_new_one() {
        let (mut used, mut new) = (Film::new(2, 1.0), Film::new(2, 1.0));
        rounds(&mut used, &[(1.0, 1), (f64::NAN, 2)]);
        let mut deposits = used.deposits();
        deposits.deposit(Splat { site: 0, value: [1.0] }, 1.0);
        used.add(&mut [deposits]);
        used.clear();
        [&mut used, &mut new].into_iter().for_each(|film| rounds(film, &[(2.0, 3), (4.0, 3)]));
        let bytes = |film: &Film<1>| {
            let mut bytes = Vec::new();
            film.write(&mut bytes);
            bytes
        };
        assert_eq!(bytes(&used), bytes(&new));
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
                film.add(&mut [deposits]);
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
        rounds(&mut film, &[(1e14, 1), (3e14, 1)]);
        let [pixel] = film.pixel(1);
        assert!((pixel.mean / 2e14 - 1.0).abs() < 1e-6);
        assert_eq!(pixel.stderr, f64::INFINITY);
    }

    #[test]
    fn squares_below_the_quantum_leave_an_error() {
        let mut film = Film::<1>::new(2, 1.0);
        rounds(&mut film, &[(1e-7, 1), (3e-7, 1)]);
        let [pixel] = film.pixel(1);
        assert!((pixel.mean / 2e-7 - 1.0).abs() < 1e-4);
        assert!(pixel.stderr > 1e-7 && pixel.stderr < 1e-5, "{pixel:?}");
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
