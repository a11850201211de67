//! The command line.

use std::path::PathBuf;

use anstream::ColorChoice;
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

pub mod aperture;
pub mod bench;
pub mod contestant;
pub mod crop;
pub mod environment;
pub mod farm;
pub mod frames;
pub mod heading;
pub mod inspect;
pub mod kept;
pub mod line;
pub mod merge;
pub mod perturbations;
pub mod render;
pub mod scene;
mod settings;
pub mod show;
pub mod tools;
pub mod transport;
pub(crate) mod usage;
pub mod values;
pub mod verify;
pub mod view;
pub mod written;

const EXAMPLES: &str = "\
Examples:
  mlt render room.glb          an image of it, as room.exr and room.png
  mlt inspect room.glb         what is in it: cameras, lights, what is left out
  mlt render --help            every option of a render

'mlt room.glb' is the same as 'mlt render room.glb'.";

/// Renders glTF and OBJ scenes: unbiased, with an error bar on every pixel.
#[derive(Debug, Parser)]
#[command(name = "mlt", version, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// Options of messages on standard error.
    #[command(flatten)]
    pub general: GeneralOptions,
}

/// Options of every command.
#[derive(Args, Clone, Copy, Debug)]
pub struct GeneralOptions {
    /// Say on standard error what is decided, and when; -vv for each round
    #[arg(short, long, action = ArgAction::Count, global = true)]
    pub verbose: u8,
    /// Colours in messages and help
    ///
    /// By itself where a terminal shows them and NO_COLOR is not set.
    #[arg(long, value_enum, value_name = "WHEN", default_value_t, global = true)]
    #[arg(hide_short_help = true)]
    pub color: Colour,
}

/// When there are colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    /// Where a terminal shows them, unless NO_COLOR is set
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

impl From<Colour> for ColorChoice {
    fn from(colour: Colour) -> Self {
        match colour {
            Colour::Auto => Self::Auto,
            Colour::Always => Self::Always,
            Colour::Never => Self::Never,
        }
    }
}

/// The program's commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene
    Render(Box<render::RenderOptions>),
    /// Tell what a scene holds, and what a render makes of it
    Inspect(Box<inspect::InspectOptions>),
    /// List the built-in scenes
    Scenes(tools::ScenesOptions),
    /// Add up parts of a render
    Merge(merge::MergeOptions),
    /// Render on a farm: jobs for Slurm and Open Job Description, and their tasks
    Farm(farm::FarmOptions),
    /// Tell what a file of a render holds
    Info(merge::InfoOptions),
    /// Measure how far images are from a reference
    Diff(DiffOptions),
    /// Tell whether images of a scene can be trusted
    Verify(Box<verify::VerifyOptions>),
    /// Chart the error of methods against time, rays and mutations
    Bench(Box<bench::BenchOptions>),
    /// Write completions for a shell
    Completions(tools::CompletionsOptions),
    /// Write manual pages
    Man(tools::ManOptions),
}

/// Options of `mlt diff`.
#[derive(Args, Debug)]
#[command(after_help = "\
a: luminance of the reference, b: luminance of the image, means over the pixels.
  relativeDiff  mean (a-b)^2 / max(a, 0.001)
  relMSE        mean (a-b)^2 / (a^2 + 0.01)
  MAPE          mean |a-b| / max(a, 0.001), as a fraction
  mean ratio    mean b / mean a
  FLIP          mean HDR-FLIP, with the reference's exposures; of PNG and JPEG mean LDR-FLIP")]
pub struct DiffOptions {
    /// The image that is taken for true: OpenEXR, Radiance HDR, PNG or JPEG
    pub reference: PathBuf,
    /// Images to measure, of the reference's size
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Print a list of objects instead of a table
    #[arg(long)]
    pub json: bool,
}
