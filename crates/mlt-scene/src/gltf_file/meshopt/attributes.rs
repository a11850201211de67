//! The codec of vertex attributes, versions 0 and 1: each byte, or word, of an element as a difference from that of the element before.

use super::unzigzag;

/// Values of a group, which has as many bits for each.
const GROUP: usize = 16;
/// Bytes of all elements of a block, at most, and elements of a block.
const BLOCK: [usize; 2] = [8192, 256];
/// Fewest bytes behind the last block of version 0 and 1.
const TAIL: [usize; 2] = [32, 24];

/// `count` elements of `stride` bytes, a multiple of 4.
pub(super) fn decode(bytes: &[u8], stride: usize, count: usize) -> Option<Vec<u8>> {
    let (&header, rest) = bytes.split_first()?;
    let version = usize::from(header & 0x0f);
    if header & 0xf0 != 0xa0 || version > 1 {
        return None;
    }
    let channels = if version == 0 { 0 } else { stride / 4 };
    let (data, tail) = rest.split_at_checked(rest.len().checked_sub((stride + channels).max(TAIL[version]))?)?;
    let tail = &tail[tail.len() - stride - channels..];
    let (first, channels) = tail.split_at(stride);
    let mut decoder = Decoder { data, last: first.to_vec(), channels, version };
    let block = (BLOCK[0] / stride / GROUP * GROUP).min(BLOCK[1]);
    let mut elements = Vec::with_capacity(stride * count);
    while elements.len() < stride * count {
        let n = block.min(count - elements.len() / stride);
        decoder.block(n, &mut elements)?;
    }
    decoder.data.is_empty().then_some(elements)
}

struct Decoder<'a> {
    data: &'a [u8],
    /// The element before.
    last: Vec<u8>,
    /// How each four bytes of an element differ from those before; by bytes where there is none.
    channels: &'a [u8],
    version: usize,
}

impl<'a> Decoder<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.data.split_at_checked(n)?;
        self.data = rest;
        Some(taken)
    }

    /// The next `n` elements.
    fn block(&mut self, n: usize, elements: &mut Vec<u8>) -> Option<()> {
        let (stride, start) = (self.last.len(), elements.len());
        elements.resize(start + n * stride, 0);
        let control = if self.version == 0 { &[][..] } else { self.take(stride / 4)? };
        for word in 0..stride / 4 {
            let mut bytes = [[0; BLOCK[1]]; 4];
            for (k, byte) in bytes.iter_mut().enumerate() {
                match control.get(word).map(|control| control >> (2 * k) & 3) {
                    None => self.groups(&mut byte[..n], [0, 2, 4, 8])?,
                    Some(0) => self.groups(&mut byte[..n], [0, 1, 2, 4])?,
                    Some(1) => self.groups(&mut byte[..n], [1, 2, 4, 8])?,
                    Some(2) => {}
                    Some(_) => byte[..n].copy_from_slice(self.take(n)?),
                }
            }
            let channel = self.channels.get(word).copied().unwrap_or(0);
            let mut last = u32::from_le_bytes(std::array::from_fn(|k| self.last[4 * word + k]));
            for i in 0..n {
                last = step(last, u32::from_le_bytes(std::array::from_fn(|k| bytes[k][i])), channel)?;
                elements[start + i * stride + 4 * word..][..4].copy_from_slice(&last.to_le_bytes());
            }
            self.last[4 * word..][..4].copy_from_slice(&last.to_le_bytes());
        }
        Some(())
    }

    /// Values in groups, each with a number of bits from a list.
    fn groups(&mut self, values: &mut [u8], bits: [u32; 4]) -> Option<()> {
        let modes = self.take(values.len().div_ceil(GROUP).div_ceil(4))?;
        for (i, group) in values.chunks_mut(GROUP).enumerate() {
            let bits = bits[usize::from(modes[i / 4] >> (2 * (i % 4)) & 3)];
            // A group has its full length in the data, also where it is the last one.
            let mut full = [0; GROUP];
            self.group(&mut full, bits)?;
            group.copy_from_slice(&full[..group.len()]);
        }
        Some(())
    }

    /// Values of so many bits, the highest first, but for single ones; what has all bits set follows as a byte.
    fn group(&mut self, values: &mut [u8; GROUP], bits: u32) -> Option<()> {
        if bits == 0 {
            return Some(());
        }
        let packed = self.take(GROUP * bits as usize / 8)?;
        if bits == 8 {
            values.copy_from_slice(packed);
            return Some(());
        }
        let (each, all) = (8 / bits as usize, (1u8 << bits) - 1);
        for (i, value) in values.iter_mut().enumerate() {
            let place = if bits == 1 { i % 8 } else { (each - 1 - i % each) * bits as usize };
            let short = packed[i / each] >> place & all;
            *value = if short == all { self.take(1)?[0] } else { short };
        }
        Some(())
    }
}

/// Four bytes of an element from those of the element before: as sums of bytes or of halves, or as a turned difference of bits.
fn step(last: u32, v: u32, channel: u8) -> Option<u32> {
    let sum = |bits: u32| {
        let mask = u32::MAX >> (32 - bits);
        (0..32 / bits).fold(0, |word, k| {
            let part = |w: u32| w >> (k * bits) & mask;
            word | (part(last).wrapping_add(unzigzag(part(v))) & mask) << (k * bits)
        })
    };
    match channel & 3 {
        0 => Some(sum(8)),
        1 => Some(sum(16)),
        2 => Some(last ^ v.rotate_right(u32::from(channel >> 4))),
        _ => None,
    }
}
