//! Renders that outlive their process: exact sums of rounds in files.
//!
//! A checkpoint and a part of a render that is shared by several machines are the same thing: the sums of some of a render's rounds.
//! Such sums go on where they were, and add up to the bits of one render, whatever the order.

mod file;
pub mod pilot;

use std::{
    ops::Range,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, anyhow};
use mlt_core::{engine::MergeError, transport::render::Sums};
use serde::{Deserialize, Serialize};

pub use file::{MAGIC, VERSION, encode, read};

use crate::{Failure, provenance::Provenance, warn};

/// The sums of some rounds of a render, and all that its files and its report need besides.
#[derive(Debug)]
pub struct Kept {
    /// Their file.
    pub path: PathBuf,
    /// Which render they are of.
    pub about: About,
    /// Its pilot's findings; `None` if its method has no pilot.
    pub pilot: Option<Vec<u8>>,
    /// Its rounds.
    pub sums: Sums,
}

/// Which render some rounds are of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The options of `mlt render` that decide the image and how it is shown; the scene comes last.
    pub arguments: Vec<String>,
    /// Where the image comes from.
    pub provenance: Provenance,
    /// Numbers of all rounds of the render; `None`: as many as its time or error allowed.
    pub whole: Option<Range<u64>>,
    /// Time that the rounds have taken.
    pub spent: Spent,
}

/// Time that rounds have taken, over all processes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// On the clock.
    pub clock: Duration,
    /// Of processors; `None` where the system does not say.
    pub processors: Option<Duration>,
}

impl Spent {
    /// No time at all.
    pub const NONE: Self = Self { clock: Duration::ZERO, processors: Some(Duration::ZERO) };

    /// Both together; what is unknown stays so.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let processors = self.processors.zip(other.processors).map(|(a, b)| a.saturating_add(b));
        Self { clock: self.clock.saturating_add(other.clock), processors }
    }
}

impl Kept {
    /// Mutations or samples a pixel of each of its rounds.
    pub fn per_pixel(&self) -> anyhow::Result<f64> {
        let entry = self.sums.key().iter().find(|(name, _)| name == "per_pixel_per_round");
        let size = entry.and_then(|(_, value)| value.parse().ok()).filter(|size: &f64| size.is_finite() && *size > 0.0);
        size.context("it does not say how large its rounds are")
    }

    /// Puts its rounds into the empty sums of a render that makes rounds `own`, and gives the time that they took.
    pub fn resume(&self, sums: &mut Sums, own: Range<u64>) -> Result<Spent, Failure> {
        let refused = |reason: String| Failure::Usage(anyhow!("{}: {reason}", self.path.display()));
        let held = self.sums.rounds();
        sums.merge(&self.sums).map_err(|error| match error {
            MergeError::Key { name, values: [here, there] } => {
                refused(format!("{name} is {there} in it and {here} here; resume with the same scene and options"))
            }
            other => refused(other.to_string()),
        })?;
        match held.ranges().iter().all(|range| own.start <= range.start && range.end <= own.end) {
            true => Ok(self.about.spent),
            false => {
                Err(refused(format!("it holds the rounds {held}, but this render makes {}; {REMEDY}", words(&own))))
            }
        }
    }
}

/// The rounds that a file keeps, if there is one; a fault of it is told.
pub(crate) fn if_whole(path: &Path) -> Option<Kept> {
    match path.exists().then(|| read(path))? {
        Ok(kept) => Some(kept),
        Err(Failure::Usage(error) | Failure::Run(error)) => {
            warn(&format!("{error:#}; it is made again"));
            None
        }
        Err(_) => None,
    }
}

/// A remedy for rounds that are not of a render.
const REMEDY: &str = "resume with the same --shard and --first-round, and no smaller budget";

/// Numbers of rounds for reading.
pub fn words(rounds: &Range<u64>) -> String {
    match rounds.end {
        u64::MAX => format!("all from {} on", rounds.start),
        end => format!("{} to {}", rounds.start, end.saturating_sub(1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the header of a forged file may have them.
    #[test]
    fn times_stay_at_the_longest() {
        let longest = Spent { clock: Duration::MAX, processors: Some(Duration::MAX) };
        assert_eq!(longest.and(longest), longest);
    }
}
