//! Options of `mlt bench`.

use std::{fmt, num::NonZeroUsize, path::PathBuf, time::Duration};

use clap::{ArgGroup, Args};

use super::{
    contestant::Contestant,
    scene::SceneOptions,
    values::{Size, duration, exposure, positive, threads},
};

/// Options of `mlt bench`.
#[derive(Args, Clone, Debug)]
#[command(group = ArgGroup::new("what").args(["scenes", "paper"]).required(true))]
#[command(group = ArgGroup::new("budget").args(["times", "mutations", "rays", "paper"]).required(true))]
#[command(group = ArgGroup::new("truth").args(["references", "reference_time", "reference_samples"]))]
#[command(after_help = "\
FOLDER gets report.html (one file, for a browser), results.csv and results.json (a row a run), charts/ (SVG), images/ and runs.jsonl.

The last is written after each run: the same command goes on where an earlier one stopped. Delete the folder after a change to a scene \
or to the program.

With budgets in mutations or rays, the same command makes the same report.html on one machine, bit for bit. With budgets in seconds it \
charts speed.")]
pub struct BenchOptions {
    /// glTF or OBJ files, or names of built-in scenes
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// The folder for the results
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// The table of the paper: its three scenes, stratified and not, a tenth of the reference's samples, 10 renders each
    #[arg(long, conflicts_with_all = ["methods", "references", "reference_time"])]
    pub paper: bool,

    /// Methods to compare: METHOD, METHOD:STRATA or METHOD:STRATA:OPTION=VALUE, each as in 'mlt render', with + for commas inside it
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', default_value = "auto,mlt:none,mlt:4x4,bdpt,pt")]
    pub methods: Vec<Contestant>,
    /// Independent renders of each method and budget, with the seeds 1, 2, …
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub seeds: u64,
    /// Budgets in time on the clock, such as 1s,3s,10s
    #[arg(long, value_name = "TIME,…", value_delimiter = ',', value_parser = time_budget)]
    pub times: Vec<Budget>,
    /// Budgets in mutations per pixel, for independent methods samples per pixel, such as 8,32,128
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = count_budget)]
    pub mutations: Vec<Budget>,
    /// Budgets in rays per pixel, such as 100,400
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = ray_budget)]
    pub rays: Vec<Budget>,

    /// The image that is taken for true, OpenEXR or PNG; once for each scene, in their order
    #[arg(long = "reference", value_name = "FILE")]
    pub references: Vec<PathBuf>,
    /// Render the reference for this time; without any of these options, for ten times the largest budget
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub reference_time: Option<Duration>,
    /// Render the reference with this many samples per pixel
    #[arg(long, value_name = "N", value_parser = positive)]
    pub reference_samples: Option<f64>,
    /// Method that renders the reference
    #[arg(long, value_name = "METHOD", default_value = "bdpt")]
    pub reference_method: Contestant,

    /// How the scenes are read.
    #[command(flatten)]
    pub reading: SceneOptions,
    /// Size of the images in pixels; that of the reference file, or 256x256
    #[arg(short, long, visible_alias = "resolution", value_name = "WxH")]
    pub size: Option<Size>,
    /// Threads; all processors if not given
    #[arg(short, long, short_alias = 'j', value_name = "N", value_parser = threads)]
    pub threads: Option<NonZeroUsize>,
    /// Longest path, in edges from light to lens; no limit if not given
    #[arg(long, value_name = "EDGES", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_length: Option<u32>,
    /// The relMSE whose time (or rays) is compared; the geometric mean of what the methods reach if not given
    #[arg(long, value_name = "ERROR", value_parser = positive)]
    pub target: Option<f64>,
    /// Exposure of the images in the report, in stops
    #[arg(long, value_name = "EV", value_parser = exposure, default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f64,
    /// No progress; errors and warnings only
    #[arg(short, long)]
    pub quiet: bool,
}

fn time_budget(text: &str) -> Result<Budget, String> {
    duration(text).map(Budget::Time)
}

fn count_budget(text: &str) -> Result<Budget, String> {
    positive(text).map(Budget::PerPixel)
}

fn ray_budget(text: &str) -> Result<Budget, String> {
    positive(text).map(Budget::Rays)
}

/// Condition that ends a run of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Time on the clock.
    Time(Duration),
    /// Mutations per pixel, for independent methods samples per pixel.
    PerPixel(f64),
    /// Rays per pixel; met as well as the rays of a first small render predict.
    Rays(f64),
}

impl Budget {
    /// Size, in the budget's own unit.
    pub fn amount(&self) -> f64 {
        match self {
            Self::Time(time) => time.as_secs_f64(),
            Self::PerPixel(n) | Self::Rays(n) => *n,
        }
    }

    /// Whether runs of this budget end at the same place on every machine and every time.
    pub fn repeats(&self) -> bool {
        !matches!(self, Self::Time(_))
    }
}

/// How far a run may end from its budget to stand for it, as a share.
const NEAR: f64 = 0.05;

impl Budget {
    /// How much more, as a share, a run spent than it was given; `None` if that is near enough, and where work is counted, which each
    /// method does in its own way.
    ///
    /// `seconds`, `rays`: what it spent, of rays per pixel.
    pub fn missed_by(&self, seconds: f64, rays: f64) -> Option<f64> {
        let spent = match self {
            Self::Time(_) => seconds,
            Self::Rays(_) => rays,
            Self::PerPixel(_) => return None,
        };
        let beyond = spent / self.amount() - 1.0;
        (beyond.abs() > NEAR).then_some(beyond)
    }
}

/// Names the budget in files, so it is exact.
impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(time) => write!(f, "{} s", time.as_secs_f64()),
            Self::PerPixel(n) => write!(f, "{n} per pixel"),
            Self::Rays(n) => write!(f, "{n} rays per pixel"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_off_their_budget_are_told() {
        let time = Budget::Time(Duration::from_secs(2));
        assert_eq!([1.91, 2.0, 2.09].map(|seconds| time.missed_by(seconds, 7.0)), [None; 3]);
        assert_eq!(time.missed_by(3.0, 2.0), Some(0.5));
        assert_eq!(time.missed_by(1.0, 2.0), Some(-0.5));
        assert_eq!(Budget::Rays(2.0).missed_by(9.0, 3.0), Some(0.5));
        assert_eq!(Budget::PerPixel(2.0).missed_by(9.0, 3.0), None);
    }
}
