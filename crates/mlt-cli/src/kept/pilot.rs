//! The file that parts of a render share the outcome of their pilot by.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use mlt_core::engine::{Key, MergeError, key_difference, put_chunk, put_key, read_key, sealed, unsealed};

use super::file::bytes_of;
use crate::{Failure, atomic};

/// The first bytes of every such file.
pub const MAGIC: [u8; 8] = *b"mlt-pilo";
/// Version of the format.
pub const VERSION: u32 = 1;

/// A pilot's findings.
#[derive(Debug)]
pub struct Pilot {
    /// Its file.
    pub path: PathBuf,
    /// Scene and settings.
    pub key: Key,
    /// For [`Renderer::following`](mlt_core::transport::render::Renderer::following).
    pub found: Vec<u8>,
}

impl Pilot {
    /// Reads a file; what is wrong with it is one sentence that names it.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let read = || {
            let content =
                unsealed(&bytes_of(path)?, MAGIC, VERSION, |from| Ok((read_key(from)?, from.chunk()?.to_vec())));
            content.map_err(|error| anyhow!("cannot be read as what 'mlt render --pilot' has written: {error}"))
        };
        let (key, found) = read().with_context(|| path.display().to_string())?;
        Ok(Self { path: path.to_owned(), key, found })
    }

    /// The outcome that the file holds for a render with this key; nothing if there is no such file.
    pub fn of(path: &Path, key: &Key) -> Result<Option<Self>, Failure> {
        if !path.exists() {
            return Ok(None);
        }
        let pilot = Self::read(path).map_err(Failure::Usage)?;
        match key_difference(&pilot.key, key) {
            Some(MergeError::Key { name, values: [there, here] }) => Err(Failure::Usage(anyhow!(
                "{}: {name} is {there} in it and {here} here; use another --pilot file, or the same scene and options",
                path.display()
            ))),
            _ => Ok(Some(pilot)),
        }
    }

    /// Writes the file, whole or not at all.
    pub fn write(&self) -> anyhow::Result<()> {
        let bytes = sealed(MAGIC, VERSION, |to| {
            put_key(to, &self.key);
            put_chunk(to, &self.found);
        });
        atomic::write(&self.path, &bytes)
    }
}
