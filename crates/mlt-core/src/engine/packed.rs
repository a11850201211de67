//! Integers that take as many bytes as the largest of them needs.

use super::bytes::put;
use super::fixed::sum;
use super::{DecodeError, Reader};

/// Bytes of the widest integer.
const MOST: usize = size_of::<i128>();

/// A list of integers of 128 bits, in the fewest bytes that hold the largest of them so far, the same number for each.
#[derive(Clone, Debug)]
pub(super) struct Packed {
    /// Bytes of an integer.
    width: usize,
    /// The integers, lowest byte first, and what the last one is read with.
    bytes: Vec<u8>,
}

impl Packed {
    /// So many zeros.
    pub(super) fn zeros(count: usize) -> Self {
        Self::of_width(1, count)
    }

    fn of_width(width: usize, count: usize) -> Self {
        Self { width, bytes: vec![0; width * count + MOST - width] }
    }

    fn count(&self) -> usize {
        (self.bytes.len() - (MOST - self.width)) / self.width
    }

    #[inline]
    pub(super) fn get(&self, index: usize) -> i128 {
        let at = index * self.width;
        let mut bytes = [0; MOST];
        bytes.copy_from_slice(&self.bytes[at..at + MOST]);
        let above = unused_bits(self.width);
        i128::from_le_bytes(bytes) << above >> above
    }

    /// Adds to an integer; what does not fit 128 bits stays at the largest or smallest of them.
    #[inline]
    pub(super) fn add(&mut self, index: usize, number: i128) {
        if number != 0 && self.add_in_place(index, number).is_none() {
            self.add_wide(index, number);
        }
    }

    /// The same where number and sum have no more than 64 bits, and the sum no more bytes than there are.
    #[inline]
    fn add_in_place(&mut self, index: usize, number: i128) -> Option<()> {
        let unused = u64::BITS.checked_sub(8 * self.width as u32)?;
        let place = self.bytes[index * self.width..].first_chunk_mut()?;
        let held = u64::from_le_bytes(*place);
        let sum = (held.cast_signed() << unused >> unused).checked_add(i64::try_from(number).ok()?)?;
        if sum << unused >> unused != sum {
            return None;
        }
        // The bytes above are those of the integers that follow.
        let own = u64::MAX >> unused;
        *place = (held & !own | sum.cast_unsigned() & own).to_le_bytes();
        Some(())
    }

    fn add_wide(&mut self, index: usize, number: i128) {
        let sum = sum(self.get(index), number);
        let width = width_of(sum);
        if width > self.width {
            self.widen(width);
        }
        let at = index * self.width;
        self.bytes[at..at + self.width].copy_from_slice(&sum.to_le_bytes()[..self.width]);
    }

    #[cold]
    fn widen(&mut self, width: usize) {
        *self = self.of_other_width(width);
    }

    fn of_other_width(&self, width: usize) -> Self {
        let mut other = Self::of_width(width, self.count());
        for (index, to) in other.bytes.chunks_exact_mut(width).take(self.count()).enumerate() {
            to.copy_from_slice(&self.get(index).to_le_bytes()[..width]);
        }
        other
    }

    /// Adds a list of as many integers.
    pub(super) fn merge(&mut self, other: &Self) {
        (0..other.count()).for_each(|index| self.add(index, other.get(index)));
    }

    /// Appends them to bytes: the same bytes for the same integers, at least one for each.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        let width = (0..self.count()).map(|index| width_of(self.get(index))).max().unwrap_or(1);
        put(to, width as u64);
        let fewest = self.of_other_width(width);
        to.extend(&fewest.bytes[..width * fewest.count()]);
    }

    /// Reads `count` integers that [`write`](Self::write) has written.
    pub(super) fn read(count: usize, from: &mut Reader) -> Result<Self, DecodeError> {
        let width = usize::try_from(from.number()?).ok().filter(|width| (1..=MOST).contains(width));
        let width = width.ok_or(DecodeError::Damaged)?;
        let taken = from.take(count.checked_mul(width).ok_or(DecodeError::Damaged)?)?;
        let mut list = Self::of_width(width, count);
        list.bytes[..taken.len()].copy_from_slice(taken);
        Ok(list)
    }
}

/// Bits of the widest integer that one of so many bytes does not have.
#[inline]
fn unused_bits(width: usize) -> u32 {
    8 * (MOST - width) as u32
}

/// The fewest bytes that hold an integer with its sign.
#[inline]
fn width_of(number: i128) -> usize {
    let magnitude = if number < 0 { !number } else { number };
    (i128::BITS - magnitude.leading_zeros()) as usize / 8 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOME: [i128; 12] = [0, 1, -1, 127, 128, -128, -129, 1 << 62, -(1 << 63), 1 << 64, i128::MAX, i128::MIN];

    #[test]
    fn what_was_added_is_read_back_in_as_few_bytes_as_hold_it() {
        for number in SOME {
            let mut list = Packed::zeros(3);
            list.add(1, number);
            assert_eq!([0, 1, 2].map(|index| list.get(index)), [0, number, 0]);
            let shorter = unused_bits(list.width) + 8;
            assert!(list.width == 1 || number << shorter >> shorter != number, "{number} in {}", list.width);
        }
    }

    #[test]
    fn they_grow_together_and_saturate() {
        let mut list = Packed::zeros(SOME.len());
        for _ in 0..2 {
            SOME.iter().enumerate().for_each(|(index, &number)| list.add(index, number));
        }
        let mut doubled = Packed::zeros(SOME.len());
        let one = |list: &mut Packed| SOME.iter().enumerate().for_each(|(index, &number)| list.add(index, number));
        one(&mut doubled);
        doubled.merge(&doubled.clone());
        for (index, number) in SOME.into_iter().enumerate() {
            assert_eq!(list.get(index), number.saturating_mul(2));
            assert_eq!(doubled.get(index), number.saturating_mul(2));
        }
    }

    #[test]
    fn the_same_integers_have_the_same_bytes() {
        let written = |numbers: &[i128]| {
            let (mut list, mut bytes) = (Packed::zeros(2), Vec::new());
            numbers.iter().for_each(|&number| list.add(1, number));
            list.write(&mut bytes);
            bytes
        };
        assert_eq!(written(&[1 << 40, 5, -(1 << 40)]), written(&[2, 3]));
        let bytes = written(&[-300]);
        let read = Packed::read(2, &mut Reader::new(&bytes)).expect("sound");
        assert_eq!([read.get(0), read.get(1)], [0, -300]);
        for (count, bytes) in [(3, &bytes[..]), (2, &bytes[..10]), (2, &[0; 12]), (2, &[17; 48])] {
            assert!(Packed::read(count, &mut Reader::new(bytes)).is_err());
        }
    }
}
