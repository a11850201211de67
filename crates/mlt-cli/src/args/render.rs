//! Options of `mlt render`.

use std::{ffi::OsStr, num::NonZeroUsize, path::PathBuf, time::Duration};

use clap::{ArgGroup, Args, ValueEnum};

use super::perturbations::PerturbationList;
use super::values::{Size, Strata, angle, duration, exposure, per_pixel, point, relative_error, threads};
use crate::{
    Failure,
    output::{self, Format, OutputFile},
};

/// How light transport is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Independent samples where they are better, Metropolis where it pays; a pilot decides
    Auto,
    /// Stratified Metropolis light transport
    Mlt,
    /// Bidirectional path tracing
    Bdpt,
    /// Path tracing
    Pt,
    /// Stratified Metropolis over the random numbers of bidirectional samples
    Pssmlt,
    /// Stratified Metropolis over the random numbers of single paths, with their length and technique
    Mmlt,
}

impl Method {
    /// Whether it samples by chains of mutations; else by independent samples.
    pub fn mutates(self) -> bool {
        matches!(self, Self::Mlt | Self::Pssmlt | Self::Mmlt)
    }

    /// The unit of its work: `mutations` or `samples`.
    pub fn unit(self) -> &'static str {
        if self.mutates() { "mutations" } else { "samples" }
    }
}

/// The scalar that chains sample in proportion to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Importance {
    /// Luminance of a path's contribution
    #[default]
    Luminance,
    /// The same over the image's luminance there, from a quick image: evens the relative error
    Relative,
}

/// How mutations are shared among strata.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Weights {
    /// In proportion to the power of the strata's lights
    Power,
    /// By the noise and cost that pilot rounds measure
    #[default]
    Adaptive,
}

/// The chains or mutations that strata restrict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Variant {
    /// Chains stay in their strata
    #[default]
    Stratified,
    /// Only the bidirectional mutation stays in the stratum that it finds the path in
    MutationOnly,
}

/// When a render is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Mutations (of all strata together) divided by the number of pixels.
    MutationsPerPixel(f64),
    /// Independent samples divided by the number of pixels.
    SamplesPerPixel(f64),
    /// Seconds on the clock.
    Time(Duration),
    /// Relative error of the image as estimated from its rounds, a fraction.
    Error(f64),
}

/// Most rounds, and highest number of the first one.
const MAX_ROUNDS: u64 = 1_000_000_000;

const EXAMPLES: &str = "\
Examples:
  mlt render                                       the built-in Cornell box, as cornell.exr and cornell.png
  mlt render room.glb --error 2% -o room.png       until the estimated error is 2 %
  mlt render room.obj --camera-from 4,3,6 --camera-to 0,1,0 --fov 40
  mlt render ring --strata 4x4 --time 1m           each light cut into 4x4 strata, for a minute

Ctrl-C ends a render early and writes what it has; a second one ends it at once and writes nothing.
Exit codes: 0 done, 1 failed, 2 wrong usage or a scene that cannot be read, 130 interrupted.";

/// Options of `mlt render`.
#[derive(Args, Clone, Debug, PartialEq)]
#[command(allow_negative_numbers = true, after_help = EXAMPLES)]
#[command(group = ArgGroup::new("budget").args(["mutations_per_pixel", "samples_per_pixel", "time", "error"]))]
pub struct RenderOptions {
    /// A glTF or OBJ file, or the name of a built-in scene: cornell, ring or suzanne
    #[arg(default_value = "cornell")]
    pub scene: PathBuf,
    /// Write to FILE, .exr (linear, float) or .png (sRGB); may be given several times. SCENE.exr and SCENE.png in the
    /// current folder if not given
    #[arg(short, long = "output", value_name = "FILE")]
    pub outputs: Vec<OutputFile>,

    /// How light transport is computed; if not given, mlt if an option asks for mutations, strata, weights, a variant,
    /// perturbations or an importance, else auto
    #[arg(long, value_enum, help_heading = "Method")]
    pub method: Option<Method>,
    /// Cut lights into strata: 'none', 'auto' (found by a pilot), a number of strata, or columns and rows of cells per
    /// light; add ',length' and ',tiles:NxM' to cut by path length and over the image as well
    #[arg(long, value_name = "none|auto|COUNT|NxM", default_value_t, help_heading = "Method")]
    pub strata: Strata,
    /// How mutations are shared among strata; adaptive if not given
    #[arg(long, value_enum, help_heading = "Method")]
    pub weights: Option<Weights>,
    /// Rounds of each measurement of the pilot, for adaptive weights and automatic strata
    #[arg(long, value_name = "N", default_value_t = 4, help_heading = "Method")]
    #[arg(value_parser = clap::value_parser!(u64).range(2..=64))]
    pub rounds_pilot: u64,
    /// Chains or mutations that strata restrict
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub variant: Variant,
    /// Perturbations beside the bidirectional mutation in mlt: 'all' that the scene has use for, 'none', or some of lens, multi-chain and
    /// caustic, with commas between them
    #[arg(long, value_name = "all|none|LIST", default_value_t, help_heading = "Method")]
    pub perturbations: PerturbationList,
    /// Importance that chains sample in proportion to
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    pub importance: Importance,
    /// Longest path, in edges from light to lens; no limit if not given
    #[arg(long, value_name = "EDGES", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Method")]
    pub max_length: Option<u32>,

    /// Stop after this many mutations per pixel (mlt, pssmlt, mmlt)
    #[arg(long, value_name = "N", value_parser = per_pixel, help_heading = "Budget")]
    pub mutations_per_pixel: Option<f64>,
    /// Stop after this many independent samples per pixel (bdpt, pt), or work worth as many of pt (auto); other methods make
    /// as many mutations
    #[arg(long, value_name = "N", value_parser = per_pixel, help_heading = "Budget")]
    pub samples_per_pixel: Option<f64>,
    /// Stop after this time, such as 30s, 5m or 1h
    #[arg(long, value_name = "TIME", value_parser = duration, help_heading = "Budget")]
    pub time: Option<Duration>,
    /// Stop when the estimated relative error is this, such as 2% or 0.02
    #[arg(long, value_name = "ERROR", value_parser = relative_error, help_heading = "Budget")]
    pub error: Option<f64>,

    /// Share the budget out to this many rounds: independent renders of the whole image, averaged. 16 or more if not given; a
    /// round of auto, bdpt or pt takes one sample of every pixel at least
    #[arg(long, value_name = "N", help_heading = "Budget")]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=MAX_ROUNDS))]
    pub rounds: Option<u64>,
    /// Number of the first round, to split a render over machines
    #[arg(long, value_name = "N", default_value_t = 0, requires = "rounds", help_heading = "Budget")]
    #[arg(value_parser = clap::value_parser!(u64).range(..=MAX_ROUNDS))]
    pub first_round: u64,
    /// Seed of the random numbers: same seed, same image
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Threads; all processors if not given. The image does not depend on it
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<NonZeroUsize>,

    /// Size of the image in pixels; if not given, 512 along the longer side, of the camera's aspect ratio
    #[arg(long, value_name = "WxH", help_heading = "Camera")]
    pub size: Option<Size>,
    /// The scene's camera of this name. Its first one if not given; a scene without any is framed whole
    #[arg(long, value_name = "NAME", help_heading = "Camera", conflicts_with_all = ["camera_from", "camera_to", "fov"])]
    pub camera: Option<String>,
    /// Where the camera stands
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_to")]
    #[arg(help_heading = "Camera")]
    pub camera_from: Option<[f64; 3]>,
    /// The point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_from")]
    #[arg(help_heading = "Camera")]
    pub camera_to: Option<[f64; 3]>,
    /// The camera's full vertical opening angle
    #[arg(long, value_name = "DEGREES", value_parser = angle, help_heading = "Camera")]
    pub fov: Option<f64>,
    /// Exposure of PNG files in stops: pixels times 2^EV
    #[arg(long, value_name = "EV", value_parser = exposure, default_value_t = 0.0)]
    pub exposure: f64,

    /// Print the report as one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress, no report; errors and warnings only
    #[arg(short, long)]
    pub quiet: bool,
}

impl RenderOptions {
    /// The method that was asked for, or the one that suits the other options.
    pub fn method(&self) -> Method {
        let mutations = self.mutations_per_pixel.is_some() || self.variant != Variant::default();
        let strata = self.strata != Strata::default() || self.weights.is_some();
        let perturbations = self.perturbations != PerturbationList::default();
        let importance = self.importance != Importance::default();
        self.method.unwrap_or(if mutations || strata || perturbations || importance {
            Method::Mlt
        } else {
            Method::Auto
        })
    }

    /// How mutations are shared among strata.
    pub fn weights(&self) -> Weights {
        self.weights.unwrap_or_default()
    }

    /// The budget that was asked for; at most one can be.
    pub fn budget(&self) -> Option<Budget> {
        let mutations = self.mutations_per_pixel.map(Budget::MutationsPerPixel);
        let samples = self.samples_per_pixel.map(Budget::SamplesPerPixel);
        let time = self.time.map(Budget::Time);
        mutations.or(samples).or(time).or(self.error.map(Budget::Error))
    }

    /// Finds what is wrong with the options together, and with the files to write, before anything is rendered.
    pub fn check(&self) -> Result<(), Failure> {
        let usage = |message: String| Err(Failure::Usage(anyhow::anyhow!(message)));
        if self.mutations_per_pixel.is_some() && !self.method().mutates() {
            let method = value_name(self.method());
            return usage(format!(
                "--mutations-per-pixel: {method} is not told how many to make; use --samples-per-pixel"
            ));
        }
        if let (false, Some(samples), rounds) =
            (self.method().mutates(), self.samples_per_pixel, self.rounds.unwrap_or(1))
            && rounds as f64 > samples
        {
            return usage(format!(
                "--samples-per-pixel {samples}: a round of {} takes one sample of every pixel at least, and {rounds} are to be made; \
                 give more samples or fewer rounds",
                value_name(self.method())
            ));
        }
        if self.camera_from.is_some() && self.camera_from == self.camera_to {
            return usage("--camera-from and --camera-to are the same point; the camera has no direction".into());
        }
        let targets = self.targets();
        let check = |output: &OutputFile| output::check_target(&output.path).map_err(Failure::Usage);
        targets.iter().try_for_each(check)?;
        output::check_apart(&targets).map_err(Failure::Usage)
    }

    /// The files asked for, or SCENE.exr and SCENE.png in the current folder.
    pub fn targets(&self) -> Vec<OutputFile> {
        if !self.outputs.is_empty() {
            return self.outputs.clone();
        }
        let stem = self.scene.file_stem().map_or_else(|| "render".into(), OsStr::to_os_string);
        let file = |extension: &str, format| {
            let mut name = stem.clone();
            name.push(extension);
            OutputFile { path: name.into(), format }
        };
        vec![file(".exr", Format::Exr), file(".png", Format::Png)]
    }
}

/// The value as it is written on the command line.
pub fn value_name(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: RenderOptions,
    }

    fn parse(line: &str) -> Result<RenderOptions, String> {
        let words = std::iter::once("mlt").chain(line.split_whitespace());
        Line::try_parse_from(words).map(|line| line.options).map_err(|error| error.to_string())
    }

    #[test]
    fn the_defaults_render_the_cornell_box() {
        let options = parse("").expect("valid");
        assert_eq!(options.scene, PathBuf::from("cornell"));
        assert_eq!((options.method(), options.strata, options.seed), (Method::Auto, Strata::default(), 0));
        assert_eq!((options.budget(), options.rounds, options.first_round), (None, None, 0));
        assert!(options.check().is_ok());
    }

    #[test]
    fn options_of_chains_choose_metropolis() {
        let chosen = |line: &str| parse(line).expect("valid").method();
        for line in [
            "--strata 4x4",
            "--mutations-per-pixel 8",
            "--weights adaptive",
            "--weights power",
            "--perturbations none",
            "--importance relative",
        ] {
            assert_eq!(chosen(line), Method::Mlt, "{line}");
            assert_eq!(chosen(&format!("{line} --method mmlt")), Method::Mmlt);
        }
        assert_eq!(chosen("--samples-per-pixel 8"), Method::Auto);
    }

    #[test]
    fn a_full_line_is_understood() {
        let options = parse(
            "a.gltf -o a.exr -o b.png --method bdpt --strata 4x3 --importance luminance --max-length 8 \
             --samples-per-pixel 4.5 --rounds 4 --first-round 2 --seed 7 --threads 3 --size 64x48 \
             --camera-from -1,2,3 --camera-to 0,0,-1 --fov 40 --exposure -1.5 --json --quiet",
        )
        .expect("valid");
        assert_eq!(options.outputs.len(), 2);
        assert_eq!((options.method(), options.strata), (Method::Bdpt, "4x3".parse().expect("strata")));
        assert_eq!(options.budget(), Some(Budget::SamplesPerPixel(4.5)));
        assert_eq!((options.rounds, options.first_round, options.max_length), (Some(4), 2, Some(8)));
        assert_eq!((options.camera_from, options.camera_to), (Some([-1.0, 2.0, 3.0]), Some([0.0, 0.0, -1.0])));
        assert_eq!((options.fov, options.exposure), (Some(40.0), -1.5));
        assert!(options.json && options.quiet);
    }

    #[test]
    fn each_budget_is_understood() {
        assert_eq!(parse("--time 5m").map(|o| o.budget()), Ok(Some(Budget::Time(Duration::from_secs(300)))));
        assert_eq!(parse("--error 2%").map(|o| o.budget()), Ok(Some(Budget::Error(0.02))));
        assert_eq!(parse("--mutations-per-pixel 64").map(|o| o.budget()), Ok(Some(Budget::MutationsPerPixel(64.0))));
    }

    #[test]
    fn options_that_contradict_each_other_are_refused() {
        for bad in [
            "--time 3s --error 2%",
            "--mutations-per-pixel 1 --samples-per-pixel 1",
            "--first-round 3",
            "--camera-from 1,2,3",
            "--camera-to 1,2,3",
            "--camera a --fov 30",
            "--camera a --camera-from 1,2,3 --camera-to 0,0,0",
            "--time 3s --time 4s",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn bad_values_are_refused_and_named() {
        for (line, part) in [
            ("--method photon", "[possible values: auto, mlt, bdpt, pt, pssmlt, mmlt]"),
            ("--size 0x4", "between 1 and 65536"),
            ("--strata 3x", "as in 4x4"),
            ("--perturbations big", "some of lens"),
            ("--weights equal", "[possible values: power, adaptive]"),
            ("--rounds-pilot 1", "2..=64"),
            ("--time 30", "as in 30s"),
            ("--error -1", "more than 0"),
            ("--fov -30", "less than 180 degrees"),
            ("--threads 0", "--threads"),
            ("--rounds 0", "--rounds"),
            ("--seed -1", "--seed"),
            ("--max-length 0", "--max-length"),
            ("-o a.jpg", "has to end in .exr or .png"),
            ("--exposure -1000", "between -100 and 100"),
        ] {
            let message = parse(line).expect_err(line);
            assert!(message.contains(part), "{line}: {message}");
        }
    }

    #[test]
    fn what_the_parser_cannot_see_is_checked() {
        let message = |line: &str| match parse(line).expect("parsed").check() {
            Err(Failure::Usage(error)) => format!("{error:#}"),
            other => panic!("{line}: {other:?}"),
        };
        assert!(message("--camera-from 1,2,3 --camera-to 1,2,3").contains("no direction"));
        assert!(message("-o none/a.exr").contains("the folder none does not exist"));
        assert!(message("-o a.exr -o a.exr").contains("given twice"));
        assert!(message("--method pt --mutations-per-pixel 8").ends_with("use --samples-per-pixel"));
    }

    #[test]
    fn files_that_are_not_named_are_named_after_the_scene() {
        let targets = |line: &str| -> Vec<PathBuf> {
            parse(line).expect("valid").targets().into_iter().map(|output| output.path).collect()
        };
        assert_eq!(targets(""), ["cornell.exr", "cornell.png"].map(PathBuf::from));
        assert_eq!(targets("some/room.v2.glb"), ["room.v2.exr", "room.v2.png"].map(PathBuf::from));
        assert_eq!(targets("ring -o a.png"), ["a.png"].map(PathBuf::from));
    }
}
