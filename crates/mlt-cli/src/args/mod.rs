//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

pub mod aperture;
pub mod bench;
pub mod contestant;
pub mod environment;
pub mod kept;
pub mod merge;
pub mod perturbations;
pub mod render;
pub mod scene;
pub mod transport;
pub mod values;
pub mod verify;
pub mod view;
pub mod written;

/// Stratified Metropolis light transport.
#[derive(Debug, Parser)]
#[command(name = "mlt", version, arg_required_else_help = true)]
pub struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
}

/// The program's commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene
    Render(Box<render::RenderOptions>),
    /// Add up parts of a render
    Merge(merge::MergeOptions),
    /// Tell what a file of a render holds
    Info(merge::InfoOptions),
    /// Measure how far images are from a reference
    Diff(DiffOptions),
    /// Chart the error of methods against time, rays and mutations
    Bench(Box<bench::BenchOptions>),
    /// Tell whether images of a scene can be trusted
    Verify(Box<verify::VerifyOptions>),
}

/// Options of `mlt diff`.
#[derive(Args, Debug)]
#[command(after_help = "\
a: luminance of the reference, b: luminance of the image, means over the pixels.
  relativeDiff  mean (a-b)^2 / max(a, 0.001)
  relMSE        mean (a-b)^2 / (a^2 + 0.01)
  MAPE          mean |a-b| / max(a, 0.001), as a fraction
  mean ratio    mean b / mean a
  FLIP          mean HDR-FLIP of linear images, the reference choosing the exposures; LDR-FLIP if both are PNG")]
pub struct DiffOptions {
    /// The image that is taken for true, OpenEXR or PNG
    pub reference: PathBuf,
    /// Images to measure, OpenEXR or PNG, of the reference's size
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Print a list of objects instead of a table
    #[arg(long)]
    pub json: bool,
}
