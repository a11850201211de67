//! Options of `mlt verify`.

use std::{num::NonZeroUsize, path::PathBuf};

use anyhow::Context;
use clap::{Args, Command, FromArgMatches};

use super::{
    contestant::Contestant,
    scene::SceneOptions,
    values::{Size, per_pixel, relative_error, threads},
    written::{shell_word, written},
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

Exit codes: 0 every method can be trusted here, 1 one fails or is inconclusive, 2 wrong usage, 130 interrupted.

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

impl VerifyOptions {
    /// The command that judges the gallery with these options, without those that are as they are by themselves.
    pub fn command_of_gallery(&self) -> anyhow::Result<String> {
        let usual = ["verify", "--gallery", "--output=FOLDER"];
        let usual = Self::augment_args(Command::new("verify")).try_get_matches_from(usual);
        let usual =
            usual.and_then(|matches| Self::from_arg_matches(&matches)).context("cannot write the options out")?;
        let usual = usual.deciding()?;
        let scenes = self.scenes.iter().map(|scene| scene.to_string_lossy().into_owned());
        let given = self.deciding()?.into_iter().filter(|option| !usual.contains(option));
        let words = scenes.chain(given.flat_map(|(name, value)| [format!("--{name}"), value]));
        let words = ["mlt", "verify", "--gallery", "-o", "FOLDER"].map(str::to_owned).into_iter().chain(words);
        Ok(words.map(|word| shell_word(&word)).collect::<Vec<_>>().join(" "))
    }

    /// Names and values of the options that decide verdicts on a scene.
    fn deciding(&self) -> anyhow::Result<Vec<(String, String)>> {
        let Self { methods, against, replicas, per_pixel, rounds, detect, reading, size, seed, .. } = self;
        let methods = methods.iter().map(Contestant::to_string).collect::<Vec<_>>().join(",");
        let options = [
            ("methods", Some(methods).filter(|methods| !methods.is_empty())),
            ("against", Some(against.to_string())),
            ("replicas", Some(replicas.to_string())),
            ("size", Some(size.to_string())),
            ("per-pixel", per_pixel.map(|n| n.to_string())),
            ("rounds", rounds.map(|n| n.to_string())),
            ("detect", Some(detect.to_string())),
            ("seed", Some(seed.to_string())),
        ];
        let options = options.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?)));
        let reading = written(reading)?.into_iter().map(|(name, value)| (name.replace('_', "-"), value));
        Ok(options.chain(reading).collect())
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: VerifyOptions,
    }

    #[test]
    fn the_command_of_the_gallery_has_the_options_that_were_given() {
        let written = |line: &str| {
            Line::parse_from(line.split_whitespace().skip(1)).options.command_of_gallery().expect("written")
        };
        for line in [
            "mlt verify --gallery -o FOLDER",
            "mlt verify --gallery -o FOLDER --replicas 24 --size 24x24 --per-pixel 256 --rounds 8",
            "mlt verify --gallery -o FOLDER islands caustic --methods mlt:4x4,pt --against pt --detect 0.02 --seed 5 --glass solid",
        ] {
            assert_eq!(written(line), line);
        }
        assert_eq!(
            written("mlt verify --gallery -o study --threads 1 --quiet --seed 1"),
            "mlt verify --gallery -o FOLDER"
        );
    }
}
