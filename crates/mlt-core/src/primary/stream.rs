//! Random numbers that are recorded, repeated and changed while a tracer draws them.

use crate::instructions::{InstructionSet, Work};
use rand_pcg::rand_core::{Infallible, TryRng, utils};

/// The streams of one evaluation, in the tracer's order.
pub type Streams<const STREAMS: usize> = [Stream; STREAMS];

/// Numbers that are made at once.
const BLOCK: usize = 8;
type Block = [u32; BLOCK];

/// Offsets d = ±s₂ (s₁/s₂)^ξ, ξ uniform in [0, 1): log-uniform between s₁ and s₂, and uniform within an octave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSize {
    /// log₂(s₂·2³²), times 2²⁷: 31 at most.
    largest: u32,
    /// log₂(s₂/s₁), times 2¹¹.
    octaves: u32,
}

/// Binary places of an offset's logarithm, and of ξ.
const PLACES: [u32; 2] = [27, 16];

impl StepSize {
    /// Offsets between s₁ = `smallest` and s₂ = `largest`, both in (0, 1/2].
    pub fn new(smallest: f64, largest: f64) -> Self {
        let largest = largest.clamp(2f64.powi(-24), 0.5);
        let smallest = smallest.clamp(2f64.powi(-30), largest);
        let fixed = |x: f64, places: u32| (libm::log2(x) * f64::from(1u32 << places)) as u32;
        let [log, xi] = PLACES;
        Self { largest: fixed(largest * 2f64.powi(32), log), octaves: fixed(largest / smallest, log - xi) }
    }

    /// Moves a number on the circle of 2³² numbers. As often one way as the other, whatever the number: symmetric.
    ///
    /// 2^x is 2^⌊x⌋ (1 + x − ⌊x⌋) here, exact at whole x: any law that does not depend on the number will do.
    #[inline(always)]
    pub(super) fn apply(&self, number: u32, random: u32) -> u32 {
        let [log_places, xi_places] = PLACES;
        let log = self.largest - (random >> (32 - xi_places)) * self.octaves;
        let one_and_fraction = 1 << 31 | log << (32 - log_places) >> 1;
        let offset = one_and_fraction >> (31 - (log >> log_places));
        let sign = (random & 1).wrapping_neg();
        number.wrapping_add((offset ^ sign).wrapping_sub(sign))
    }
}

/// One sequence of numbers, each 32 bits, the number u·2³².
///
/// Numbers are made in blocks: near those of the current state when the stream begins, afresh when they are drawn beyond their
/// end. A state keeps whole blocks, so it has a few numbers that were not drawn: they are uniform, whatever the others are.
/// `next_u32` and `next_u64` each draw one; the latter's low half repeats it.
#[derive(Debug)]
pub struct Stream {
    blocks: Vec<Block>,
    drawn: usize,
    /// Of the random numbers behind the blocks.
    key: u64,
    instructions: InstructionSet,
}

impl Default for Stream {
    fn default() -> Self {
        Self { blocks: Vec::new(), drawn: 0, key: 0, instructions: InstructionSet::detect() }
    }
}

impl Clone for Stream {
    fn clone(&self) -> Self {
        Self { blocks: self.blocks.clone(), ..*self }
    }

    /// Copies without giving up the memory of `self`.
    fn clone_from(&mut self, source: &Self) {
        self.blocks.clone_from(&source.blocks);
        (self.drawn, self.key, self.instructions) = (source.drawn, source.key, source.instructions);
    }
}

impl Stream {
    /// Starts anew, with numbers near those of a state's stream ahead.
    #[inline(always)]
    pub(super) fn begin(&mut self, near: Option<(&Self, &StepSize)>, key: u64) {
        self.blocks.clear();
        (self.drawn, self.key) = (0, key);
        if let Some((Self { blocks: from, .. }, size)) = near {
            self.instructions.perform(Moved { from, to: &mut self.blocks, size, key });
        }
    }

    /// Forgets the blocks of which nothing was drawn.
    #[inline(always)]
    pub(super) fn end(&mut self) {
        self.blocks.truncate(self.drawn.div_ceil(BLOCK));
    }

    /// The numbers drawn.
    pub fn numbers(&self) -> &[u32] {
        &self.blocks.as_flattened()[..self.drawn]
    }

    /// How many of them.
    pub(crate) fn drawn(&self) -> usize {
        self.drawn
    }

    /// The same numbers once more.
    pub(crate) fn again(&self) -> Self {
        Self { drawn: 0, ..self.clone() }
    }

    #[inline]
    fn draw(&mut self) -> u32 {
        let number = match self.blocks.as_flattened().get(self.drawn) {
            Some(&number) => number,
            None => self.make_more(),
        };
        self.drawn += 1;
        number
    }

    /// Makes a fresh block, and returns the first of it.
    #[inline(never)]
    fn make_more(&mut self) -> u32 {
        let number = self.blocks.len();
        self.instructions.perform(Fresh(self));
        self.blocks[number][0]
    }
}

/// One more block of fresh numbers.
struct Fresh<'a>(&'a mut Stream);

impl Work for Fresh<'_> {
    type Outcome = ();

    #[inline(always)]
    fn perform(self) {
        let Stream { blocks, key, .. } = self.0;
        blocks.push(random(*key, blocks.len()));
    }
}

/// The numbers of all blocks of a state, each moved a little.
///
/// The law is a reference: passed by value, it would be written to memory and read back as one vector, which has to wait.
struct Moved<'a> {
    from: &'a [Block],
    to: &'a mut Vec<Block>,
    size: &'a StepSize,
    key: u64,
}

impl Work for Moved<'_> {
    type Outcome = ();

    #[inline(always)]
    fn perform(self) {
        let Self { from, to, size, key } = self;
        // A plain loop: what an iterator's adapter does is not compiled for the instructions.
        to.reserve(from.len());
        for (number, block) in from.iter().enumerate() {
            let mut moved = random(key, number);
            for lane in 0..BLOCK {
                moved[lane] = size.apply(block[lane], moved[lane]);
            }
            to.push(moved);
        }
    }
}

/// Uniform numbers for block `number` of a stream: a hash of each one's place, the key's halves entering one after the other.
///
/// Source: Wellons, "Prospecting for Hash Functions", 2018 (lowbias32).
#[inline(always)]
fn random(key: u64, number: usize) -> Block {
    let first = (key as u32).wrapping_add(number as u32);
    let mut block = [0; BLOCK];
    for (i, x) in block.iter_mut().enumerate() {
        // Odd multiples of 2³² over the golden ratio, which differ in many bits: neighbouring blocks hash other places.
        *x = first ^ (2 * i as u32 + 1).wrapping_mul(0x9e37_79b9);
        *x = (*x ^ *x >> 16).wrapping_mul(0x7feb_352d);
        *x = (*x ^ *x >> 15).wrapping_add((key >> 32) as u32).wrapping_mul(0x846c_a68b);
        *x ^= *x >> 16;
    }
    block
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
