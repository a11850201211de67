//! Numbers as bytes, and back without trust.

use super::count::add_count;
use super::{ExactSum, Rounds};
use std::error::Error;
use std::fmt;

/// Why bytes are not what they ought to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DecodeError {
    /// They are of something else.
    Foreign,
    /// They are of another version of the format.
    Version(u32),
    /// They were changed or cut off.
    Damaged,
    /// The film in them has another number of channels.
    Channels(u32),
}

impl Error for DecodeError {}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign => f.write_str("these bytes hold something else"),
            Self::Version(version) => {
                write!(f, "version {version} of the format is not known; use the program that wrote it")
            }
            Self::Damaged => f.write_str("the bytes are damaged or cut off; make these rounds again"),
            Self::Channels(channels) => {
                write!(f, "the film has {channels} channels, which is another number than expected")
            }
        }
    }
}

/// Bytes that are still to be read.
#[derive(Debug)]
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// For these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    ///
    /// If there are not as many.
    pub fn bytes<const N: usize>(&mut self) -> Result<[u8; N], DecodeError> {
        let (first, rest) = self.0.split_first_chunk().ok_or(DecodeError::Damaged)?;
        self.0 = rest;
        Ok(*first)
    }

    /// The next number.
    ///
    /// # Errors
    ///
    /// If the bytes end before it.
    pub fn number(&mut self) -> Result<u64, DecodeError> {
        self.bytes().map(u64::from_le_bytes)
    }

    /// A list of items of at least one byte each.
    ///
    /// # Errors
    ///
    /// If the list is longer than the bytes that are left, or an item cannot be read.
    pub fn list<T>(
        &mut self,
        mut item: impl FnMut(&mut Self) -> Result<T, DecodeError>,
    ) -> Result<Vec<T>, DecodeError> {
        let count = self.number()?;
        if count > self.0.len() as u64 {
            return Err(DecodeError::Damaged);
        }
        (0..count).map(|_| item(self)).collect()
    }

    /// A text.
    ///
    /// # Errors
    ///
    /// If it is none.
    pub fn text(&mut self) -> Result<String, DecodeError> {
        String::from_utf8(self.chunk()?.to_vec()).map_err(|_| DecodeError::Damaged)
    }

    /// Bytes behind their number.
    ///
    /// # Errors
    ///
    /// If there are not as many.
    pub fn chunk(&mut self) -> Result<&'a [u8], DecodeError> {
        let length = usize::try_from(self.number()?).map_err(|_| DecodeError::Damaged)?;
        self.take(length)
    }

    /// The next so many bytes.
    pub(super) fn take(&mut self, length: usize) -> Result<&'a [u8], DecodeError> {
        let (taken, rest) = self.0.split_at_checked(length).ok_or(DecodeError::Damaged)?;
        self.0 = rest;
        Ok(taken)
    }

    /// Refuses to go on where so many bytes are not left: memory is taken only for what is there.
    pub(super) fn expect(&self, bytes: u64) -> Result<(), DecodeError> {
        if bytes <= self.0.len() as u64 { Ok(()) } else { Err(DecodeError::Damaged) }
    }

    /// Whether all have been read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Counts that add up in any order, and can be written to bytes and read back.
pub trait Counted: Default {
    /// Adds others; the outcome does not depend on the order.
    fn merge(&mut self, other: &Self);
    /// Appends it to bytes: the same bytes for the same counts.
    fn write(&self, to: &mut Vec<u8>);
    /// Reads what [`write`](Self::write) has written.
    ///
    /// # Errors
    ///
    /// If the bytes were not written by it.
    fn read(from: &mut Reader) -> Result<Self, DecodeError>;
}

/// Nothing is counted.
impl Counted for () {
    fn merge(&mut self, (): &Self) {}

    fn write(&self, _: &mut Vec<u8>) {}

    fn read(_: &mut Reader) -> Result<Self, DecodeError> {
        Ok(())
    }
}

/// A plain count.
impl Counted for u64 {
    fn merge(&mut self, other: &Self) {
        add_count(self, *other);
    }

    fn write(&self, to: &mut Vec<u8>) {
        put(to, *self);
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        from.number()
    }
}

/// Appends a number.
pub fn put(to: &mut Vec<u8>, number: u64) {
    to.extend(number.to_le_bytes());
}

/// Appends a list.
pub fn put_list<T>(to: &mut Vec<u8>, items: &[T], mut item: impl FnMut(&mut Vec<u8>, &T)) {
    put(to, items.len() as u64);
    items.iter().for_each(|x| item(to, x));
}

/// Appends a text.
pub fn put_text(to: &mut Vec<u8>, text: &str) {
    put_chunk(to, text.as_bytes());
}

/// Appends bytes behind their number.
pub fn put_chunk(to: &mut Vec<u8>, bytes: &[u8]) {
    put(to, bytes.len() as u64);
    to.extend(bytes);
}

impl Rounds {
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        put_list(to, self.ranges(), |to, range| [range.start, range.end].into_iter().for_each(|x| put(to, x)));
    }

    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let mut rounds = Self::default();
        for range in from.list(|from| Ok(from.number()?..from.number()?))? {
            if range.is_empty() {
                return Err(DecodeError::Damaged);
            }
            rounds.insert(range);
        }
        Ok(rounds)
    }
}

impl ExactSum {
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        put_list(to, &self.canonical(), |to, part| put(to, part.to_bits()));
    }

    pub(super) fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        Ok(from.list(Reader::number)?.into_iter().map(f64::from_bits).collect())
    }
}
