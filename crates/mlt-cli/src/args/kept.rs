//! Options for renders that outlive their process.

use std::{
    fmt,
    ops::Range,
    path::{Path, PathBuf},
    str::FromStr,
    time::Duration,
};

use clap::Args;

use super::{heading, values::duration};

/// Most parts of a render.
const MOST_SHARDS: u64 = 1_000_000_000;

/// Files that keep the rounds of a render.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct KeptOptions {
    /// Keep what is done in FILE, from which --resume goes on
    ///
    /// The rounds that are done are written to it now and then, and at the end.
    #[arg(long, value_name = "FILE", help_heading = heading::PARTS)]
    #[arg(hide_short_help = true)]
    pub checkpoint: Option<PathBuf>,
    /// Time between two such writes
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = "30s", help_heading = heading::PARTS)]
    #[arg(hide_short_help = true)]
    pub checkpoint_every: Duration,
    /// Go on from FILE, to the same or a larger budget
    ///
    /// Scene and options have to be the same. FILE is kept up to date, unless --checkpoint names another.
    #[arg(long, value_name = "FILE", help_heading = heading::PARTS)]
    #[arg(hide_short_help = true)]
    pub resume: Option<PathBuf>,
    /// Share what the pilot finds by FILE, with other parts
    ///
    /// It is taken from FILE, or written there if there is no such file yet. The image does not depend on it. Methods without a pilot
    /// need none.
    #[arg(long, value_name = "FILE", help_heading = heading::PARTS)]
    #[arg(hide_short_help = true)]
    pub pilot: Option<PathBuf>,
    /// Make only part I of N, 1/N to N/N, for 'mlt merge'
    ///
    /// All parts together make the bits of the whole render. It needs -o FILE.mltp.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["time", "error"], help_heading = heading::PARTS)]
    #[arg(hide_short_help = true)]
    pub shard: Option<Shard>,
}

impl KeptOptions {
    /// The file that is kept up to date.
    pub fn file(&self) -> Option<&Path> {
        self.checkpoint.as_deref().or(self.resume.as_deref())
    }
}

/// One of several parts of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 1 on.
    number: u64,
    /// How many there are.
    count: u64,
}

impl Shard {
    /// The part of this number, from 1 to `count`.
    pub fn new(number: u64, count: u64) -> Self {
        Self { number, count }
    }

    /// Its number.
    pub fn number(self) -> u64 {
        self.number
    }

    /// How many parts there are.
    pub fn count(self) -> u64 {
        self.count
    }

    /// Its share of consecutive rounds; all shares differ by one round at most.
    pub fn of(self, whole: Range<u64>) -> Range<u64> {
        let rounds = u128::from(whole.end - whole.start);
        let end = |number: u64| whole.start + (rounds * u128::from(number) / u128::from(self.count)) as u64;
        end(self.number - 1)..end(self.number)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(number, count)| Some((number.parse().ok()?, count.parse().ok()?)));
        match numbers {
            Some((number, count)) if (1..=count).contains(&number) && count <= MOST_SHARDS => {
                Ok(Self { number, count })
            }
            _ => Err("give the number of the part and how many there are, as in 1/4 to 4/4".into()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_rounds_out() {
        let shard = |text: &str| text.parse::<Shard>();
        for count in 1..=7 {
            let shares: Vec<_> =
                (1..=count).map(|i| shard(&format!("{i}/{count}")).expect("a part").of(5..28)).collect();
            assert_eq!(shares.iter().cloned().flatten().collect::<Vec<_>>(), (5..28).collect::<Vec<_>>());
        }
        assert_eq!(shard("2/3").map(|shard| shard.to_string()), Ok("2/3".into()));
        for bad in ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1/1000000001"] {
            assert!(shard(bad).is_err(), "{bad}");
        }
    }
}
