//! Options of `mlt verify`.

use std::{num::NonZeroUsize, path::PathBuf};

use clap::Args;

use super::{
    contestant::Contestant,
    scene::SceneOptions,
    values::{Size, per_pixel, relative_error, threads},
};

/// Options of `mlt verify`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Each method renders the scene many times with different seeds, as 'mlt render SCENE' does it unless options say otherwise, and so does a \
method that shares little code with it. Reported are:

  - whether the two have the same mean image, and how small an error would have been noticed
  - whether rounds and chains agree
  - whether 95 % error bars hold the truth in 95 % of the pixels
  - how far the worst seed is from the median
  - how much the image flickers

With --choice instead: whether auto keeps to its budget and its plan, and is never much worse than the best of pt, bdpt and mlt with as \
many rays.

Exit codes: 0 every method can be trusted here, 1 one cannot or cannot be judged, 2 wrong usage, 130 interrupted.

With --gallery FOLDER gets stability.md, stability-figures.md, verdicts/ and scenes/, with --choice checkpoints of all renders: the same \
command goes on where an earlier one stopped.")]
pub struct VerifyOptions {
    /// glTF or OBJ files, or names of built-in scenes; with --gallery names of its scenes, all of them if none is given; with
    /// --choice also names of gallery scenes, seven of easy and hard light if none is given
    #[arg(value_name = "SCENE", required_unless_present_any = ["gallery", "choice"])]
    pub scenes: Vec<PathBuf>,
    /// Judge the scenes of the gallery: those where methods are known to fail
    #[arg(long, requires = "output", group = "study")]
    pub gallery: bool,
    /// The folder for the gallery's verdicts and table, or for the renders of --choice; what is in it is not made again
    #[arg(short, long, value_name = "FOLDER", requires = "study")]
    pub output: Option<PathBuf>,
    /// Judge the choice that auto makes between its methods
    #[arg(long, group = "study", conflicts_with_all = ["gallery", "methods", "per_pixel", "rounds"])]
    pub choice: bool,
    /// Budgets of --choice, samples per pixel
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = per_pixel, default_values_t = [4.0, 64.0])]
    #[arg(requires = "choice")]
    pub budgets: Vec<f64>,
    /// Methods to judge: METHOD, METHOD:STRATA or METHOD:STRATA:OPTION=VALUE, each as in 'mlt render'; what that does by itself
    /// if not given, with --gallery every method
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    pub methods: Vec<Contestant>,
    /// Method to judge by; bdpt is judged by pt instead
    #[arg(long, value_name = "METHOD", default_value = "bdpt")]
    pub against: Contestant,
    /// Independent renders of each method
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(4..=10_000))]
    pub replicas: u64,
    /// Mutations per pixel of each render; bdpt and pssmlt take an eighth of it, pt, auto and mmlt half, which costs about
    /// the same. What 'mlt render' takes by itself if not given
    #[arg(long, value_name = "N", value_parser = per_pixel)]
    pub per_pixel: Option<f64>,
    /// Rounds of each render; as many as 'mlt render' makes by itself if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(4..=4096))]
    pub rounds: Option<u64>,
    /// An error of the image that has to be found if it is there
    #[arg(long, value_name = "ERROR", value_parser = relative_error, default_value = "1%")]
    pub detect: f64,
    /// How the scenes are read.
    #[command(flatten)]
    pub reading: SceneOptions,
    /// Size of the images in pixels
    #[arg(short, long, visible_alias = "resolution", value_name = "WxH", default_value = "64x64")]
    pub size: Size,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1 << 31))]
    pub seed: u64,
    /// Threads; all processors if not given
    #[arg(short, long, short_alias = 'j', value_name = "N", value_parser = threads)]
    pub threads: Option<NonZeroUsize>,
    /// Print the verdicts as a list of objects on standard output
    #[arg(long)]
    pub json: bool,
    /// No text; errors only
    #[arg(short, long)]
    pub quiet: bool,
}
