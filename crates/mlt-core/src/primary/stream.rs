//! Random numbers that are recorded, repeated and changed while a tracer draws them.

use rand_pcg::rand_core::{Infallible, TryRng, utils};

/// The streams of one evaluation, in the tracer's order.
pub type Streams<const STREAMS: usize> = [Stream; STREAMS];

/// How a number follows from the one at its place in the current state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Change {
    /// A fresh number.
    #[default]
    Fresh,
    /// The same number.
    #[cfg(test)]
    Same,
    /// A number nearby.
    Near(Perturbation),
}

impl Change {
    /// The number that takes the place of `number`.
    #[inline]
    fn apply(self, number: u32, random: u32) -> u32 {
        match self {
            Self::Fresh => random,
            #[cfg(test)]
            Self::Same => number,
            Self::Near(perturbation) => perturbation.apply(number, random),
        }
    }
}

/// Offsets d = ±s₂ (s₁/s₂)^ξ, ξ uniform in [0, 1): log-uniform between s₁ and s₂.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Perturbation {
    /// s₂ · 2³².
    largest: f32,
    /// log₂(s₂/s₁).
    octaves: f32,
}

impl Perturbation {
    pub(super) fn new(smallest: f64, largest: f64) -> Self {
        let largest = largest.clamp(f64::from(2f32.powi(-24)), 0.5);
        let smallest = smallest.clamp(f64::from(2f32.powi(-30)), largest);
        Self { largest: (largest * 4_294_967_296.0) as f32, octaves: libm::log2(largest / smallest) as f32 }
    }

    /// Moves a number on the circle of 2³² numbers. As often one way as the other, whatever the number: symmetric.
    #[inline]
    pub(super) fn apply(self, number: u32, random: u32) -> u32 {
        let x = self.octaves * ((random >> 8) as f32 * (1.0 / (1u32 << 24) as f32));
        let whole = x as u32;
        let f = x - whole as f32;
        // 2^−f on [0, 1), to 0.3 %: any law that does not depend on the number will do.
        let offset = (self.largest * (1.0 - f * (0.6716 - 0.1716 * f))) as u32 >> whole;
        if random & 1 == 0 { number.wrapping_add(offset) } else { number.wrapping_sub(offset) }
    }
}

/// One sequence of numbers, each 32 bits, the number u·2³².
///
/// A number is made when it is drawn: from the one that the current state has at that place, or afresh beyond its end.
/// `next_u32` and `next_u64` each draw one; the latter's low half repeats it.
#[derive(Debug, Default)]
pub struct Stream {
    /// Those drawn so far; after them, until the stream ends, those of the current state.
    numbers: Vec<u32>,
    drawn: usize,
    change: Change,
    /// State of a SplitMix64: its steps are short, and a draw costs less than one of the chain's generator.
    random: u64,
}

impl Clone for Stream {
    fn clone(&self) -> Self {
        Self { numbers: self.numbers.clone(), ..*self }
    }

    /// Copies without giving up the memory of `self`.
    fn clone_from(&mut self, source: &Self) {
        self.numbers.clone_from(&source.numbers);
        (self.drawn, self.change, self.random) = (source.drawn, source.change, source.random);
    }
}

impl Stream {
    /// Starts anew, with the numbers of `current` ahead.
    #[inline(always)]
    pub(super) fn begin(&mut self, current: Option<&Self>, change: Change, seed: u64) {
        self.numbers.clear();
        if let Some(current) = current {
            self.numbers.extend_from_slice(&current.numbers);
        }
        (self.drawn, self.change, self.random) = (0, change, seed);
    }

    /// Forgets the numbers that were not drawn.
    #[inline(always)]
    pub(super) fn end(&mut self) {
        self.numbers.truncate(self.drawn);
    }

    /// The numbers.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// Source: Steele, Lea & Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
    #[inline]
    fn random(&mut self) -> u32 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.random;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 32) as u32
    }

    #[inline]
    fn draw(&mut self) -> u32 {
        let random = self.random();
        let change = self.change;
        let number = match self.numbers.get_mut(self.drawn) {
            Some(number) => {
                *number = change.apply(*number, random);
                *number
            }
            None => {
                self.numbers.push(random);
                random
            }
        };
        self.drawn += 1;
        number
    }
}

impl TryRng for Stream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.draw())
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let number = u64::from(self.draw());
        Ok(number << 32 | number)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        utils::fill_bytes_via_next_word(bytes, || self.try_next_u32())
    }
}
