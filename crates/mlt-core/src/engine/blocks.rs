//! Blocks of a film, and what each round gave to them.

use super::bytes::{put, put_list};
use super::{DecodeError, Reader};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Blocks along each side of a film, where it has as many sites.
const SIDE: usize = 8;
/// Rounds that are kept, those of the least numbers: as many as tell how rounds agree.
const MOST_ROUNDS: usize = 4096;

/// Blocks of an image whose sites stand row by row: nearly equal rectangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    size: [usize; 2],
    /// Columns and rows.
    pub cut: [usize; 2],
}

impl Grid {
    /// Up to `side` columns and rows of blocks for an image of this width and height.
    pub fn new(size: [usize; 2], side: usize) -> Self {
        Self { size, cut: size.map(|n| n.min(side)) }
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.cut[0] * self.cut[1]
    }

    /// The block of a site, row by row.
    pub fn block(&self, site: usize) -> usize {
        let (x, y) = (site % self.size[0], site / self.size[0]);
        self.row(y) * self.cut[0] + x * self.cut[0] / self.size[0]
    }

    /// The row of blocks that a row of sites lies in.
    fn row(&self, y: usize) -> usize {
        y * self.cut[1] / self.size[1]
    }

    /// Σ over the sites of each block of their values, over the number of the image's sites. Rows are summed on all threads, and
    /// then in their order.
    pub fn shares<const N: usize>(&self, value: impl Fn(usize) -> [f64; N] + Sync) -> Vec<[f64; N]> {
        let ([width, height], columns) = (self.size, self.cut[0]);
        let add = |sum: &mut [f64; N], x: [f64; N]| sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
        let row = |y: usize| {
            let mut sums = vec![[0.0; N]; columns];
            (0..width).for_each(|x| add(&mut sums[x * columns / width], value(y * width + x)));
            sums
        };
        let sums_of_rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
        let mut sums = vec![[0.0; N]; self.count()];
        for (y, row) in sums_of_rows.into_iter().enumerate() {
            let blocks = &mut sums[self.row(y) * columns..];
            blocks.iter_mut().zip(row).for_each(|(sum, x)| add(sum, x));
        }
        let n = (width * height) as f64;
        sums.into_iter().map(|sum| sum.map(|x| x / n)).collect()
    }
}

/// Contribution of each round to each block: the part of the film's mean that comes from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks<const C: usize> {
    grid: Grid,
    /// Of each round by its number, up to 4096 of them.
    rounds: BTreeMap<u64, Vec<[f64; C]>>,
}

impl<const C: usize> Blocks<C> {
    /// No rounds, for films of this size.
    pub(super) fn new(size: [u32; 2]) -> Self {
        Self { grid: Grid::new(size.map(|n| n as usize), SIDE), rounds: BTreeMap::new() }
    }

    /// The blocks.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Σ_c weights_c × channel c of each block, round by round in the order of their numbers.
    pub fn rounds(&self, weights: [f64; C]) -> Vec<Vec<f64>> {
        let weighted = |channels: &[f64; C]| channels.iter().zip(weights).map(|(x, w)| w * x).sum();
        self.rounds.values().map(|blocks| blocks.iter().map(weighted).collect()).collect()
    }

    /// Takes in a round.
    pub(super) fn add(&mut self, number: u64, round: &[[f32; C]]) {
        let is_late = |last: &u64| self.rounds.len() == MOST_ROUNDS && *last < number;
        if !self.rounds.last_key_value().is_some_and(|(last, _)| is_late(last)) {
            self.keep(number, self.grid.shares(|site| round[site].map(f64::from)));
        }
    }

    fn keep(&mut self, number: u64, blocks: Vec<[f64; C]>) {
        self.rounds.insert(number, blocks);
        if self.rounds.len() > MOST_ROUNDS {
            self.rounds.pop_last();
        }
    }

    /// Adds others; the outcome does not depend on the order.
    pub(super) fn merge(&mut self, other: &Self) {
        other.rounds.iter().for_each(|(&number, blocks)| self.keep(number, blocks.clone()));
    }

    /// Forgets all rounds.
    pub(super) fn clear(&mut self) {
        self.rounds.clear();
    }

    pub(super) fn write(&self, to: &mut Vec<u8>) {
        let rounds: Vec<_> = self.rounds.iter().collect();
        put_list(to, &rounds, |to, (number, blocks)| {
            put(to, **number);
            blocks.iter().flatten().for_each(|x| put(to, x.to_bits()));
        });
    }

    /// Reads what [`write`](Self::write) has written.
    pub(super) fn read(size: [u32; 2], from: &mut Reader) -> Result<Self, DecodeError> {
        let mut blocks = Self::new(size);
        let count = blocks.grid.count();
        let rounds = from.list(|from| {
            let (number, mut round) = (from.number()?, vec![[0.0; C]; count]);
            for x in round.iter_mut().flatten() {
                *x = f64::from_bits(from.number()?);
            }
            Ok((number, round))
        })?;
        rounds.into_iter().for_each(|(number, round)| blocks.keep(number, round));
        Ok(blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_covers_the_image() {
        let grid = Grid::new([5, 3], 4);
        let blocks: Vec<usize> = (0..15).map(|site| grid.block(site)).collect();
        assert_eq!((grid.count(), blocks[0], blocks[14]), (12, 0, 11));
        let shares = grid.shares(|site| [1.0, site as f64]);
        let [ones, sites] = [0, 1].map(|n| shares.iter().map(|share| share[n]).sum::<f64>());
        assert!((ones - 1.0).abs() < 1e-12 && (sites - 7.0).abs() < 1e-12, "{shares:?}");
    }

    /// Whatever the order in which they come, the same rounds are kept.
    #[test]
    fn the_first_rounds_are_kept() {
        let all = MOST_ROUNDS as u64 + 50;
        let with = |numbers: &mut dyn Iterator<Item = u64>| {
            let mut blocks = Blocks::<1>::new([1, 1]);
            numbers.for_each(|number| blocks.add(number, &[[number as f32]]));
            blocks
        };
        let (up, down) = (with(&mut (0..all)), with(&mut (0..all).rev()));
        let mut merged = with(&mut (0..all).filter(|number| number % 3 == 1));
        merged.merge(&with(&mut (0..all).filter(|number| number % 3 != 1)));
        assert!(up == down && up == merged);
        assert_eq!(up.rounds([2.0]).last(), Some(&vec![2.0 * (MOST_ROUNDS as f64 - 1.0)]));
    }
}
