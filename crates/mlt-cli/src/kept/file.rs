//! The format of kept sums.
//!
//! magic (8 bytes), version (4), length of the header (8), header (JSON), length of the sums (8), length of the packed
//! sums (8), packed sums (an LZ4 frame), BLAKE3 of all before
//! (32); numbers are little-endian. The checksum tells damage; it is no protection against intent.

use std::{
    fs,
    io::{Read, Write},
    path::Path,
};

use anyhow::{Context, anyhow, bail};
use lz4_flex::frame::{FrameDecoder, FrameEncoder};
use mlt_core::transport::render::Sums;

use super::{About, Kept};
use crate::{Failure, require_memory};

/// The first bytes of every file.
pub const MAGIC: [u8; 8] = *b"mlt-kept";
/// Version of the format.
const VERSION: u32 = 1;
/// The file was changed or cut off.
const DAMAGED: &str = "damaged or cut off; make its rounds again";

/// A file's bytes: the same for the same rounds, but for the time that they took.
pub fn encode(about: &About, sums: &Sums) -> anyhow::Result<Vec<u8>> {
    let header = serde_json::to_vec(about).context("cannot encode what the rounds are of")?;
    let sums = sums.to_bytes();
    let packed = pack(&sums)?;
    let lengths = [length(&sums), length(&packed)].concat();
    let mut bytes = [&MAGIC[..], &VERSION.to_le_bytes(), &length(&header), &header, &lengths, &packed].concat();
    let sum = blake3::hash(&bytes);
    bytes.extend(sum.as_bytes());
    Ok(bytes)
}

fn pack(bytes: &[u8]) -> anyhow::Result<Vec<u8>> {
    let mut encoder = FrameEncoder::new(Vec::new());
    encoder.write_all(bytes).and_then(|()| Ok(encoder.finish()?)).context("cannot pack the sums")
}

/// Unpacks bytes; `None` unless they have this length.
fn unpack(bytes: &[u8], length: u64) -> anyhow::Result<Vec<u8>> {
    require_memory(length.saturating_mul(2), "what it holds")?;
    let mut unpacked = Vec::new();
    FrameDecoder::new(bytes).take(length.saturating_add(1)).read_to_end(&mut unpacked).context(DAMAGED)?;
    if unpacked.len() as u64 == length { Ok(unpacked) } else { bail!(DAMAGED) }
}

fn length(bytes: &[u8]) -> [u8; 8] {
    (bytes.len() as u64).to_le_bytes()
}

/// Reads a file; what is wrong with it is one sentence that names it.
pub fn read(path: &Path) -> Result<Kept, Failure> {
    let (about, sums) = decode_file(path).with_context(|| path.display().to_string()).map_err(Failure::Usage)?;
    Ok(Kept { path: path.to_owned(), about, sums })
}

fn decode_file(path: &Path) -> anyhow::Result<(About, Sums)> {
    let file = fs::metadata(path)?;
    if !file.is_file() {
        bail!("not a regular file");
    }
    require_memory(file.len(), "what it holds")?;
    decode(&fs::read(path)?)
}

fn decode(bytes: &[u8]) -> anyhow::Result<(About, Sums)> {
    let Some(rest) = bytes.strip_prefix(&MAGIC) else { bail!("not a file of 'mlt render --checkpoint' or '--shard'") };
    let (version, rest) = rest.split_first_chunk().context(DAMAGED)?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        bail!("version {version} of its format is not known; use the program that wrote it");
    }
    let (content, sum) = bytes.split_last_chunk::<{ blake3::OUT_LEN }>().context(DAMAGED)?;
    let rest = rest.get(..rest.len().saturating_sub(blake3::OUT_LEN)).context(DAMAGED)?;
    if blake3::hash(content) != *sum {
        bail!(DAMAGED);
    }
    let (header, rest) = chunk(rest).context(DAMAGED)?;
    let (length, rest) = rest.split_first_chunk().context(DAMAGED)?;
    let (packed, rest) = chunk(rest).context(DAMAGED)?;
    if !rest.is_empty() {
        bail!(DAMAGED);
    }
    let about = serde_json::from_slice(header).map_err(|error| anyhow!("its header is not understood: {error}"))?;
    Ok((about, Sums::from_bytes(&unpack(packed, u64::from_le_bytes(*length))?)?))
}

/// The next bytes, behind their number, and the rest.
fn chunk(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
}
