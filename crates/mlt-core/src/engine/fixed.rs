//! Sums in fixed point, which come out the same in any order.
//!
//! Floating point has the range, but its sums depend on their order. Integers of 128 bits have it, too: pixels from 10⁻⁸ of an image's mean to
//! 10⁵ of it, in up to 10⁶ samples, span 2⁶⁴ with their last digits, and their squares 2¹¹⁰. Most sites need half of that, so a film keeps
//! them [packed](super::packed).

use super::{DecodeError, Reader};

/// Quanta of a unit in the sums of a site.
const QUANTA: f64 = (1u64 << 36) as f64;
/// The same in the sums of the mean over all sites, whose error is smaller.
const QUANTA_OF_WHOLE: f64 = (1u64 << 60) as f64;

/// Σ w X in 2⁻³⁶ units, and Σ w X² in 2⁻³⁶ units².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sums {
    pub(super) first: i128,
    pub(super) second: i128,
}

impl Sums {
    /// Those of one value. Squares that do not fit stay at the largest integer, in any order of the values, since none is negative.
    #[inline]
    pub(super) fn of(value: f64, weight: i128) -> Self {
        let [first, second] = [quantise(value, QUANTA), quantise(value * value, QUANTA)];
        // Most rounds count once, and a product that stays in its range is slow.
        let [first, second] =
            if weight == 1 { [first, second] } else { [first, second].map(|x| x.saturating_mul(weight)) };
        Self { first, second }
    }

    /// Σ w X in units.
    pub(super) fn first(&self) -> f64 {
        self.first as f64 / QUANTA
    }

    /// Σ w X² in units²; `None` if it left its range.
    pub(super) fn second(&self) -> Option<f64> {
        (self.second != i128::MAX).then(|| self.second as f64 / QUANTA)
    }
}

/// Σ w X of some channels, and Σ w X X′ of each two, in 2⁻⁶⁰ units and units².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Products<const C: usize> {
    first: [i128; C],
    second: [[i128; C]; C],
}

impl<const C: usize> Products<C> {
    pub(super) const ZERO: Self = Self { first: [0; C], second: [[0; C]; C] };

    /// Adds a value of each channel.
    pub(super) fn add(&mut self, values: [f64; C], weight: i128) {
        let weighted = |x: f64| quantise(x, QUANTA_OF_WHOLE).saturating_mul(weight);
        self.merge(&Self { first: values.map(weighted), second: values.map(|a| values.map(|b| weighted(a * b))) });
    }

    /// Adds others.
    pub(super) fn merge(&mut self, other: &Self) {
        let sums = self.first.iter_mut().chain(self.second.iter_mut().flatten());
        let others = other.first.iter().chain(other.second.iter().flatten());
        sums.zip(others).for_each(|(a, b)| *a = sum(*a, *b));
    }

    /// Σ w X and Σ w X² of X = Σ_c weights_c X_c, in units and units².
    pub(super) fn of(&self, weights: [f64; C]) -> [f64; 2] {
        let weighted =
            |row: &[i128; C]| row.iter().zip(weights).map(|(&x, w)| w * (x as f64 / QUANTA_OF_WHOLE)).sum::<f64>();
        [weighted(&self.first), self.second.iter().zip(weights).map(|(row, w)| w * weighted(row)).sum()]
    }

    pub(super) fn write(&self, to: &mut Vec<u8>) {
        put(to, &self.first);
        self.second.iter().for_each(|row| put(to, row));
    }

    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let mut products = Self::ZERO;
        for sum in products.first.iter_mut().chain(products.second.iter_mut().flatten()) {
            *sum = get(from)?;
        }
        Ok(products)
    }
}

/// Variance of a site that the rounding of squares may hide, units².
pub(super) const ROUNDING: f64 = 0.5 / QUANTA;
/// The same of the mean over all sites.
pub(super) const ROUNDING_OF_WHOLE: f64 = 0.5 / QUANTA_OF_WHOLE;

/// Nearest number of quanta.
#[inline]
fn quantise(x: f64, quanta: f64) -> i128 {
    let scaled = x * quanta;
    integer(scaled + 0.5f64.copysign(scaled))
}

/// a + b, or the integer nearest to it: as `saturating_add`, which costs ten times as much where the sum is in range.
#[inline]
pub(super) fn sum(a: i128, b: i128) -> i128 {
    a.checked_add(b).unwrap_or_else(|| a.saturating_add(b))
}

/// `x as i128`, without the call that it is.
#[inline]
fn integer(x: f64) -> i128 {
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    let magnitude = x.to_bits() & (u64::MAX >> 1);
    match (magnitude >> MANTISSA) as u32 {
        // Less than 2⁶³, and so on up to 2¹²⁷.
        ..1086 => i128::from(x as i64),
        exponent @ 1086..1150 => {
            let digits = magnitude & ((1 << MANTISSA) - 1) | 1 << MANTISSA;
            let shifted = i128::from(digits) << (exponent - 1023 - MANTISSA);
            if x < 0.0 { -shifted } else { shifted }
        }
        _ => x as i128,
    }
}

fn put(to: &mut Vec<u8>, sums: &[i128]) {
    sums.iter().for_each(|sum| to.extend(sum.to_le_bytes()));
}

fn get(from: &mut Reader) -> Result<i128, DecodeError> {
    from.bytes().map(i128::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_integer_is_what_the_cast_gives() {
        let mut values = vec![0.0, f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE];
        for exponent in -4..140 {
            let power = libm::exp2(f64::from(exponent));
            let below = f64::from_bits(power.to_bits() - 1);
            values.extend([power, below, 1.3 * power, 1.999_999_999_7 * power, f64::from_bits(power.to_bits() + 1)]);
        }
        for value in values.into_iter().flat_map(|value| [value, -value]) {
            assert_eq!(integer(value), value as i128, "{value:e}");
        }
    }
}
