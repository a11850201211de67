//! Frames of an animation.

use std::{fmt, ops::RangeInclusive, str::FromStr};

use clap::{Args, ValueEnum};

use super::{heading, values::positive};

/// Most frames of a run.
const MOST_FRAMES: u32 = 100_000;

/// Options for animations.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct FrameOptions {
    /// Render frames A to B of an animation, to -o frame.####.exr
    ///
    /// Frame N is at N/FPS seconds, as Blender's exporter counts. The budget is that of each frame.
    #[arg(long, value_name = "A-B", hide_short_help = true, help_heading = heading::ANIMATION)]
    #[arg(conflicts_with_all = ["time_in_animation", "checkpoint", "resume", "pilot"])]
    pub frames: Option<Frames>,
    /// Frames per second
    #[arg(hide_short_help = true)]
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = positive, requires = "frames", help_heading = heading::ANIMATION)]
    pub fps: f64,
    /// Random numbers of the frames: the same in all, or each its own
    ///
    /// The same: what does not move does not flicker. Its own: frame N has the seed --seed + N.
    #[arg(hide_short_help = true)]
    #[arg(long, value_enum, default_value_t = FrameSeeds::Same, requires = "frames", help_heading = heading::ANIMATION)]
    pub frame_seeds: FrameSeeds,
}

impl FrameOptions {
    /// Seconds from the animation's beginning at a frame.
    pub fn seconds(&self, number: u32) -> f64 {
        f64::from(number) / self.fps
    }
}

/// Random numbers of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FrameSeeds {
    /// The same in all frames
    Same,
    /// Other ones in each frame
    Own,
}

/// As on the command line.
impl fmt::Display for FrameSeeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Same => "same",
            Self::Own => "own",
        })
    }
}

/// Numbers of frames, from the first to the last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames(pub RangeInclusive<u32>);

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        match (first.trim().parse(), last.trim().parse()) {
            (Ok(first), Ok(last)) if first <= last && last - first < MOST_FRAMES => Ok(Self(first..=last)),
            (Ok(first), Ok(last)) if first <= last => Err(format!("at most {MOST_FRAMES} frames are rendered at once")),
            _ => Err("give the first and the last frame, as in 1-240".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_a_range() {
        let frames = |text: &str| text.parse::<Frames>().map(|frames| frames.0);
        assert_eq!([frames("1-240"), frames("7"), frames("0-0")], [Ok(1..=240), Ok(7..=7), Ok(0..=0)]);
        for bad in ["", "-3", "3-", "5-2", "a-b", "1-2-3", "0-100000"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
    }
}
