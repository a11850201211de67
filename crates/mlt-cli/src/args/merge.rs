//! Options of `mlt merge` and `mlt info`.

use std::path::PathBuf;

use clap::Args;

use super::values::exposure;
use crate::output::OutputFile;

/// Options of `mlt merge`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub struct MergeOptions {
    /// Parts of one render, from 'mlt render --shard' or '--checkpoint', in any order
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// Write to FILE: .exr, .hdr, .png or .jpg if the parts are complete, .mltp for a larger part; may be given several times
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    pub outputs: Vec<OutputFile>,
    /// Overwrite files that mlt has not made, too
    #[arg(long)]
    pub force: bool,
    /// Exposure of PNG and JPEG files in stops; the render's if not given
    #[arg(long, value_name = "EV", value_parser = exposure)]
    pub exposure: Option<f64>,
    /// Print the report as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No report; errors and warnings only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Options of `mlt info`.
#[derive(Args, Debug)]
pub struct InfoOptions {
    /// A checkpoint, a part, or an image of 'mlt render'
    pub file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}
