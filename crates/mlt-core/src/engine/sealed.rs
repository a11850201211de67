//! Bytes that say what they are, and tell whether they are whole.
//!
//! magic (8 bytes), version (4), content, BLAKE3 of all before (32). The checksum tells damage; it is no protection against intent: whoever
//! changes bytes can make another.

use super::{Accumulated, Counted, DecodeError, Reader};

/// First bytes of sums.
const SUMS: [u8; 8] = *b"mlt-sums";
/// Version of their format.
const VERSION: u32 = 2;

/// Seals a content.
pub fn sealed(magic: [u8; 8], version: u32, content: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = magic.to_vec();
    bytes.extend(version.to_le_bytes());
    content(&mut bytes);
    let sum = checksum(&bytes);
    bytes.extend(sum);
    bytes
}

/// Reads the content of bytes from wherever they come, all of it.
///
/// # Errors
///
/// If they are of something else, of another version, or damaged, or if `content` cannot be read.
pub fn unsealed<T>(
    bytes: &[u8],
    magic: [u8; 8],
    version: u32,
    content: impl FnOnce(&mut Reader) -> Result<T, DecodeError>,
) -> Result<T, DecodeError> {
    let rest = bytes.strip_prefix(&magic).ok_or(DecodeError::Foreign)?;
    let (found, rest) = rest.split_first_chunk().ok_or(DecodeError::Damaged)?;
    let found = u32::from_le_bytes(*found);
    if found != version {
        return Err(DecodeError::Version(found));
    }
    let (inside, sum) = rest.split_last_chunk().ok_or(DecodeError::Damaged)?;
    if checksum(&bytes[..bytes.len() - sum.len()]) != *sum {
        return Err(DecodeError::Damaged);
    }
    let mut from = Reader::new(inside);
    let content = content(&mut from)?;
    if from.is_empty() { Ok(content) } else { Err(DecodeError::Damaged) }
}

impl<const C: usize, T: Counted> Accumulated<C, T> {
    /// [`write`](Self::write)s it, sealed.
    pub fn to_bytes(&self) -> Vec<u8> {
        sealed(SUMS, VERSION, |to| self.write(to))
    }

    /// Reads what [`to_bytes`](Self::to_bytes) has made.
    ///
    /// # Errors
    ///
    /// If the bytes are of something else, of another version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DecodeError> {
        unsealed(bytes, SUMS, VERSION, Self::read)
    }
}

/// Tells bytes that were changed; on the current rayon pool.
pub(super) fn checksum(bytes: &[u8]) -> [u8; blake3::OUT_LEN] {
    *blake3::Hasher::new().update_rayon(bytes).finalize().as_bytes()
}
