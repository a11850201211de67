//! Options of `mlt farm`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand};

use super::kept::Shard;

/// Most parts of a job.
const MOST_PARTS: u64 = 1_000_000;

const EXAMPLES: &str = "\
Examples:
  mlt farm slurm --shards 100 -- room.glb --samples-per-pixel 1024 -o room.exr > room.sh
  sh room.sh
  mlt farm openjd --shards 100 -- room.glb --samples-per-pixel 1024 -o room.exr > room.json
  mlt farm slurm -- walk.glb --frames 1-240 --samples-per-pixel 256 -o walk.####.exr > walk.sh

Paths are as seen from the current folder, which all machines have to share, with 'mlt' on their PATH.";

/// Options of `mlt farm`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct FarmOptions {
    /// The files to write, or the task to do.
    #[command(subcommand)]
    pub command: FarmCommand,
}

/// Options of all farms.
#[derive(Debug, Subcommand)]
pub enum FarmCommand {
    /// Write a shell script that submits a render to Slurm: a job array of parts and a job that merges them, or an array of frames
    Slurm(JobOptions),
    /// Write the same as an Open Job Description template, in JSON
    Openjd(JobOptions),
    /// Make one part or frame, as these jobs do: from where it was
    Task(TaskOptions),
}

/// A render in parts, or in frames.
#[derive(Args, Debug)]
pub struct JobOptions {
    /// Number of parts; frames of 'mlt render --frames' need none
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_PARTS))]
    pub shards: Option<u64>,
    /// The render, and where its parts go.
    #[command(flatten)]
    pub render: PartedOptions,
}

/// A part of a render, or a frame.
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("number").args(["shard", "frame"]).required(true))]
pub struct TaskOptions {
    /// Which of how many parts, as in 3/100
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Which of the --frames
    #[arg(long, value_name = "N")]
    pub frame: Option<u32>,
    /// The render, and where its parts go.
    #[command(flatten)]
    pub render: PartedOptions,
}

/// A render, and where its parts go.
#[derive(Args, Clone, Debug)]
pub struct PartedOptions {
    /// Folder for the parts, or for the sums of the frames; SCENE.parts in the current folder if not given
    #[arg(long, value_name = "DIR")]
    pub parts: Option<PathBuf>,
    /// The scene and the options of 'mlt render', after '--'
    #[arg(last = true, value_name = "RENDER OPTIONS")]
    pub words: Vec<String>,
}
