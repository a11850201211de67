//! The format of kept sums.
//!
//! Sealed bytes ([`sealed`]) of: header (JSON), what the pilot found (empty without one), length of the sums, and the sums in blocks of 4 MiB,
//! each packed by LZ4; each behind its length, numbers little-endian.

use std::{fs, path::Path};

use anyhow::{Context, anyhow, bail};
use lz4_flex::block;
use mlt_core::{
    engine::{DecodeError, Reader, put, put_chunk, sealed, unsealed},
    transport::render::Sums,
};
use rayon::prelude::*;

use super::{About, Kept};
use crate::{Failure, require_memory};

/// The first bytes of every file.
pub const MAGIC: [u8; 8] = *b"mlt-kept";
/// Version of the format.
const VERSION: u32 = 2;
/// Bytes of the sums that are packed together.
const BLOCK: usize = 4 << 20;
/// LZ4 packs no better than this.
const MOST_PACKED: u64 = 256;

/// A file's bytes, made on the current rayon pool: the same for the same rounds, but for the time that they took.
pub fn encode(about: &About, pilot: Option<&[u8]>, sums: &Sums) -> anyhow::Result<Vec<u8>> {
    let header = serde_json::to_vec(about).context("cannot encode what the rounds are of")?;
    let sums = sums.to_bytes();
    let blocks: Vec<_> = sums.par_chunks(BLOCK).map(block::compress).collect();
    Ok(sealed(MAGIC, VERSION, |to| {
        put_chunk(to, &header);
        put_chunk(to, pilot.unwrap_or_default());
        put(to, sums.len() as u64);
        blocks.iter().for_each(|block| put_chunk(to, block));
    }))
}

/// Reads a file; what is wrong with it is one sentence that names it.
pub fn read(path: &Path) -> Result<Kept, Failure> {
    let kept = bytes_of(path).and_then(|bytes| decode(path, &bytes));
    kept.with_context(|| path.display().to_string()).map_err(Failure::Usage)
}

/// The bytes of a regular file that fits into memory.
pub(super) fn bytes_of(path: &Path) -> anyhow::Result<Vec<u8>> {
    let file = fs::metadata(path)?;
    if !file.is_file() {
        bail!("not a regular file");
    }
    require_memory(file.len(), "what it holds")?;
    Ok(fs::read(path)?)
}

fn decode(path: &Path, bytes: &[u8]) -> anyhow::Result<Kept> {
    let content = |from: &mut Reader| {
        let (header, pilot, length) = (from.chunk()?, from.chunk()?, from.number()?);
        let blocks = (0..length.div_ceil(BLOCK as u64)).map(|_| from.chunk()).collect::<Result<Vec<_>, _>>()?;
        let pilot = (!pilot.is_empty()).then(|| pilot.to_vec());
        Ok((header.to_vec(), pilot, unpack(length, &blocks)))
    };
    let (header, pilot, sums) = unsealed(bytes, MAGIC, VERSION, content).map_err(foreign)?;
    let about = serde_json::from_slice(&header).map_err(|error| anyhow!("its header is not understood: {error}"))?;
    Ok(Kept { path: path.to_owned(), about, pilot, sums: Sums::from_bytes(&sums?)? })
}

/// The error for a file that is no such file, or as it is.
fn foreign(error: DecodeError) -> anyhow::Error {
    match error {
        DecodeError::Foreign => anyhow!("not a file of 'mlt render --checkpoint' or '--shard'"),
        error => error.into(),
    }
}

/// Unpacks blocks that together are so long.
fn unpack(length: u64, blocks: &[&[u8]]) -> anyhow::Result<Vec<u8>> {
    let packed: u64 = blocks.iter().map(|block| block.len() as u64).sum();
    if length > packed.saturating_mul(MOST_PACKED) {
        bail!(DecodeError::Damaged);
    }
    require_memory(length.saturating_mul(2), "what it holds")?;
    let mut bytes = vec![0; length as usize];
    let unpacked = bytes
        .par_chunks_mut(BLOCK)
        .zip(blocks)
        .all(|(to, block)| block::decompress_into(block, to).is_ok_and(|written| written == to.len()));
    if unpacked { Ok(bytes) } else { bail!(DecodeError::Damaged) }
}
