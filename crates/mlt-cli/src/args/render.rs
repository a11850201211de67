//! Options of `mlt render`.

use std::{num::NonZeroUsize, path::PathBuf, time::Duration};

use clap::{ArgGroup, Args, ValueEnum};

use super::values::{Size, Strata, angle, duration, exposure, point, positive, relative_error};
use crate::{Failure, output};

/// How light transport is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Stratified Metropolis light transport
    #[default]
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
    #[default]
    Power,
    /// By the noise and cost that pilot rounds measure
    Adaptive,
}

/// What strata restrict.
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

/// Options of `mlt render`.
#[derive(Args, Clone, Debug, PartialEq)]
#[command(allow_negative_numbers = true)]
#[command(group = ArgGroup::new("budget").args(["mutations_per_pixel", "samples_per_pixel", "time", "error"]))]
pub struct RenderOptions {
    /// A glTF or OBJ file, or the name of a built-in scene
    #[arg(default_value = "cornell")]
    pub scene: PathBuf,
    /// Write to FILE, .exr (linear, float) or .png (sRGB); may be given several times
    #[arg(short, long = "output", value_name = "FILE")]
    pub outputs: Vec<output::OutputFile>,

    /// How light transport is computed
    #[arg(long, value_enum, default_value_t)]
    pub method: Method,
    /// Cut lights into strata: 'none', 'auto' (found by a pilot), a number of strata, or columns and rows of cells per
    /// light; add ',length' and ',tiles:NxM' to cut by path length and over the image as well
    #[arg(long, value_name = "none|auto|COUNT|NxM", default_value_t)]
    pub strata: Strata,
    /// How mutations are shared among strata
    #[arg(long, value_enum, default_value_t)]
    pub weights: Weights,
    /// Rounds of each measurement of the pilot, for adaptive weights and automatic strata
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(2..=64))]
    pub rounds_pilot: u64,
    /// What strata restrict
    #[arg(long, value_enum, default_value_t)]
    pub variant: Variant,
    /// What chains sample in proportion to
    #[arg(long, value_enum, default_value_t)]
    pub importance: Importance,
    /// Longest path, in edges from light to lens; no limit if not given
    #[arg(long, value_name = "EDGES", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_length: Option<u32>,

    /// Stop after this many mutations per pixel
    #[arg(long, value_name = "N", value_parser = positive)]
    pub mutations_per_pixel: Option<f64>,
    /// Stop after this many independent samples per pixel
    #[arg(long, value_name = "N", value_parser = positive)]
    pub samples_per_pixel: Option<f64>,
    /// Stop after this time, such as 30s, 5m or 1h
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    /// Stop at this relative error, such as 2% or 0.02
    #[arg(long, value_name = "ERROR", value_parser = relative_error)]
    pub error: Option<f64>,

    /// Rounds, which are independent renders of the whole image, averaged
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub rounds: Option<u64>,
    /// Number of the first round, to split a render over machines
    #[arg(long, value_name = "N", default_value_t = 0, requires = "rounds")]
    pub first_round: u64,
    /// Seed of the random numbers: same seed, same image
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Threads; all processors if not given. The image does not depend on it
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,

    /// Size of the image in pixels
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// The scene's camera of this name; its first one if not given
    #[arg(long, value_name = "NAME", conflicts_with_all = ["camera_from", "camera_to", "fov"])]
    pub camera: Option<String>,
    /// Where the camera stands
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_to")]
    pub camera_from: Option<[f64; 3]>,
    /// The point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_from")]
    pub camera_to: Option<[f64; 3]>,
    /// The camera's full vertical opening angle
    #[arg(long, value_name = "DEGREES", value_parser = angle)]
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
        if self.camera_from.is_some() && self.camera_from == self.camera_to {
            return usage("--camera-from and --camera-to are the same point; the camera has no direction".into());
        }
        for (index, output) in self.outputs.iter().enumerate() {
            if self.outputs[..index].contains(output) {
                return usage(format!("{} is given twice", output.path.display()));
            }
            output::check_target(&output.path).map_err(Failure::Usage)?;
        }
        Ok(())
    }
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
        assert_eq!((options.method, options.strata, options.seed), (Method::Mlt, Strata::default(), 0));
        assert_eq!((options.budget(), options.rounds, options.first_round), (None, None, 0));
        assert!(options.check().is_ok());
    }

    #[test]
    fn a_full_line_is_understood() {
        let options = parse(
            "a.gltf -o a.exr -o b.png --method bdpt --strata 4x3 --importance luminance --max-length 8 \
             --samples-per-pixel 0.5 --rounds 4 --first-round 2 --seed 7 --threads 3 --size 64x48 \
             --camera-from -1,2,3 --camera-to 0,0,-1 --fov 40 --exposure -1.5 --json --quiet",
        )
        .expect("valid");
        assert_eq!(options.outputs.len(), 2);
        assert_eq!((options.method, options.strata), (Method::Bdpt, "4x3".parse().expect("strata")));
        assert_eq!(options.budget(), Some(Budget::SamplesPerPixel(0.5)));
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
            ("--method photon", "[possible values: mlt, bdpt, pt, pssmlt, mmlt]"),
            ("--size 0x4", "between 1 and 65536"),
            ("--strata 3x", "as in 4x4"),
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
    }
}
