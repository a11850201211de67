//! Options of `mlt render`.

use std::{ffi::OsStr, num::NonZeroUsize, path::PathBuf, time::Duration};

use clap::{ArgGroup, Args, ValueHint};
use mlt_core::transport::render::Settings;

use super::frames::{FrameOptions, FrameSeeds};
use super::heading;
use super::kept::KeptOptions;
use super::scene::SceneOptions;
use super::show::ShowOptions;
use super::transport::{Method, TransportOptions};
use super::values::{Size, duration, exposure, per_pixel, relative_error, threads};
use super::view::ViewOptions;
use crate::{
    Failure,
    output::{self, Format, OutputFile},
};

/// Most rounds, and highest number of the first one.
const MAX_ROUNDS: u64 = 1_000_000_000;

const SHORT_EXAMPLES: &str = "\
Examples:
  mlt render room.glb --error 2% -o room.png
  mlt render room.obj --camera-from 4,3,6 --camera-to 0,1,0 --fov 40";

const EXAMPLES: &str = "\
Examples:
  mlt render                                       the Cornell box, as cornell.exr and cornell.png
  mlt render room.glb --error 2% -o room.png       until the estimated error is 2 %
  mlt render room.obj --camera-from 4,3,6 --camera-to 0,1,0 --fov 40
  mlt render ring --strata 4x4 --time 1m           each light cut into 4x4 strata, for a minute

  mlt render room.glb --time 8h --checkpoint room.mltp
  mlt render room.glb --time 1h --resume room.mltp another hour for it, or what a crash has cut off
  mlt render room.glb --shard 2/3 -o part2.mltp    one of three machines
  mlt merge part?.mltp -o room.exr                 the image of all three parts

Ctrl-C or SIGTERM ends a render early and writes what it has; a second one ends it at once and writes nothing.

Exit codes: 0 done, 1 failed, 2 wrong usage or a scene that cannot be read, 130 interrupted, 143 by SIGTERM.";

/// Options of `mlt render`.
#[derive(Args, Clone, Debug, PartialEq)]
#[command(allow_negative_numbers = true, after_help = SHORT_EXAMPLES, after_long_help = EXAMPLES)]
#[command(group = ArgGroup::new("budget").args(["mutations_per_pixel", "samples_per_pixel", "time", "error"]))]
pub struct RenderOptions {
    /// A glTF or OBJ file, or a built-in scene: cornell, ring or suzanne
    #[arg(default_value = "cornell", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,

    /// Where the scene is seen from.
    #[command(flatten)]
    pub view: ViewOptions,
    /// Exposure of PNG and JPEG in stops: 1 is twice as bright
    #[arg(long, value_name = "EV", value_parser = exposure, default_value_t = 0.0, help_heading = heading::IMAGE)]
    pub exposure: f64,

    /// Stop after this many samples per pixel
    ///
    /// Of bdpt and pt they are independent samples; auto does as much work as pt does for so many; other methods make as many mutations.
    #[arg(long, visible_alias = "spp", alias = "samples", value_name = "N", value_parser = per_pixel)]
    #[arg(help_heading = heading::BUDGET)]
    pub samples_per_pixel: Option<f64>,
    /// Stop after this time, such as 30s, 5m or 1h
    #[arg(long, value_name = "TIME", value_parser = duration, help_heading = heading::BUDGET)]
    pub time: Option<Duration>,
    /// Stop when the estimated relative error is this, such as 2% or 0.02
    #[arg(long, value_name = "ERROR", value_parser = relative_error, help_heading = heading::BUDGET)]
    pub error: Option<f64>,

    /// How light is computed; auto suits itself to the scene
    ///
    /// If not given, mlt if an option asks for mutations, strata, weights, a variant, perturbations or an importance, else auto.
    #[arg(long, visible_alias = "integrator", value_enum, help_heading = heading::METHOD)]
    pub method: Option<Method>,
    /// Threads; all processors if not given. The image does not depend on it
    #[arg(short, long, short_alias = 'j', alias = "nthreads", value_name = "N", value_parser = threads)]
    #[arg(help_heading = heading::METHOD)]
    pub threads: Option<NonZeroUsize>,

    /// Write to FILE, .exr, .hdr, .png, .jpg or .mltp; may be repeated
    ///
    /// .exr is linear, with error bars; .hdr is linear; .png and .jpg are for looking at; .mltp holds exact sums, for 'mlt merge'. - is
    /// standard output, as OpenEXR or as in png:-. SCENE.exr and SCENE.png in the current folder if not given.
    #[arg(short, long = "output", alias = "outfile", value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[arg(help_heading = heading::OUTPUT)]
    pub outputs: Vec<OutputFile>,
    /// Overwrite files that mlt has not made, too
    ///
    /// Images and checkpoints that mlt has made are overwritten without it.
    #[arg(long, help_heading = heading::OUTPUT, hide_short_help = true)]
    pub force: bool,
    /// Options of what is seen beside the image.
    #[command(flatten)]
    pub show: ShowOptions,
    /// Print the report as one JSON object on standard output
    #[arg(long, help_heading = heading::OUTPUT)]
    #[arg(hide_short_help = true)]
    pub json: bool,
    /// No progress, no report; errors and warnings only
    #[arg(short, long, help_heading = heading::OUTPUT)]
    pub quiet: bool,

    /// Take options from FILE, in TOML: the names of the long options, as in time = "30s"
    ///
    /// The command line wins. 'file' names the scene; a list stands for several values, true and false for flags.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = heading::OPTIONS)]
    #[arg(hide_short_help = true)]
    pub config: Option<PathBuf>,
    /// Take the options that FILE, an image of 'mlt render', was made with
    ///
    /// Scene, view, method, seed and budget, that is. What the command line says wins; its budget replaces that of the file.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = heading::OPTIONS)]
    #[arg(hide_short_help = true)]
    pub like: Option<PathBuf>,

    /// How the scene is read.
    #[command(flatten)]
    pub reading: SceneOptions,
    /// Frames of an animation.
    #[command(flatten)]
    pub frames: FrameOptions,
    /// Files that outlive the process.
    #[command(flatten)]
    pub keeping: KeptOptions,

    /// The other options of the computation.
    #[command(flatten)]
    pub transport: TransportOptions,
    /// Stop after this many mutations per pixel (mlt, pssmlt, mmlt)
    #[arg(long, value_name = "N", value_parser = per_pixel, help_heading = heading::RESEARCH, hide_short_help = true)]
    pub mutations_per_pixel: Option<f64>,
    /// Share the budget out to this many rounds: independent renders of the whole image, averaged. If not given, 16 or more, or
    /// 8 or more of pt and bdpt; a round of auto, bdpt or pt takes one sample of every pixel at least
    #[arg(long, value_name = "N", help_heading = heading::RESEARCH, hide_short_help = true)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=MAX_ROUNDS))]
    pub rounds: Option<u64>,
    /// Number of the first round, to split a render over machines
    #[arg(long, value_name = "N", default_value_t = 0, requires = "rounds", help_heading = heading::RESEARCH)]
    #[arg(value_parser = clap::value_parser!(u64).range(..=MAX_ROUNDS), hide_short_help = true)]
    pub first_round: u64,
}

impl RenderOptions {
    /// The method that was asked for, or the one that suits the other options.
    pub fn method(&self) -> Method {
        let chains = self.transport.ask_for_chains() || self.mutations_per_pixel.is_some();
        self.method.unwrap_or(if chains { Method::Mlt } else { Method::Auto })
    }

    /// Settings of the library, in rounds of so many mutations or samples a pixel.
    pub fn settings(&self, per_pixel: f64) -> Settings {
        self.transport.settings(self.method(), per_pixel)
    }

    /// Mutations or samples a pixel that were asked for.
    pub fn per_pixel(&self) -> Option<f64> {
        self.mutations_per_pixel.or(self.samples_per_pixel)
    }

    /// Whether anything says when the render is done.
    pub fn have_budget(&self) -> bool {
        self.per_pixel().or(self.error).is_some() || self.time.is_some()
    }

    /// Finds what is wrong with the options together, and with the files to write, before anything is rendered.
    pub fn check(&self) -> Result<(), Failure> {
        self.check_together()?;
        let usage = |message: String| Err(Failure::Usage(anyhow::anyhow!(message)));
        let targets = self.targets();
        if self.keeping.shard.is_some() && !self.keeps_sums() {
            return usage(
                "--shard: images of parts cannot be added up; add -o FILE.mltp, which 'mlt merge' takes".into(),
            );
        }
        if self.show.features() && !targets.iter().any(|target| target.format == Format::Exr) {
            return usage("--aov: only OpenEXR files hold further channels; add -o FILE.exr".into());
        }
        if self.show.denoise && targets.iter().all(|target| target.denoised().is_none()) {
            return usage(
                "--denoise: a denoised image is written beside an image file; add -o FILE.exr or another".into(),
            );
        }
        if let Some(pilot) = self.keeping.pilot.as_ref().filter(|pilot| !pilot.exists()) {
            output::check_target(pilot).map_err(Failure::Usage)?;
        }
        // A preview may be shown where the image comes in the end.
        let previews = self.show.files().filter(|file| targets.iter().all(|target| target.path != file.path));
        let denoised: Vec<_> = targets.iter().filter(|_| self.show.denoise).filter_map(OutputFile::denoised).collect();
        let files: Vec<_> = targets.iter().chain(previews).chain(&denoised).cloned().collect();
        output::check_targets(&files, self.json).map_err(Failure::Usage)?;
        // What is wrong with a file that is resumed is told by whoever reads it.
        let others = files.into_iter().filter(|file| !self.force && self.keeping.resume.as_ref() != Some(&file.path));
        output::check_existing(others).map_err(Failure::Usage)
    }

    /// Finds what is wrong with the options together.
    pub fn check_together(&self) -> Result<(), Failure> {
        let usage = |message: String| Err(Failure::Usage(anyhow::anyhow!(message)));
        let unnumbered = |target: &OutputFile| self.frames.frames.is_some() && !target.is_numbered();
        if let Some(target) = self.targets().into_iter().find(unnumbered) {
            return usage(format!(
                "-o {}: each of the --frames needs a file of its own; write #### where the frame's number goes, as in frame.####.exr",
                target.path.display()
            ));
        }
        if self.frames.frames.is_some() && self.keeping.shard.is_some() {
            return usage(
                "--frames: a frame is not cut into shards; 'mlt farm slurm -- SCENE --frames A-B' makes a task of each frame".into(),
            );
        }
        if self.mutations_per_pixel.is_some() && !self.method().mutates() {
            return usage(format!(
                "--mutations-per-pixel: {} is not told how many to make; use --samples-per-pixel",
                self.method()
            ));
        }
        if let (false, Some(samples), rounds) =
            (self.method().mutates(), self.samples_per_pixel, self.rounds.unwrap_or(1))
            && rounds as f64 > samples
        {
            return usage(format!(
                "--samples-per-pixel {samples}: a round of {} takes one sample of every pixel at least, and {rounds} are to be made; \
                 give more samples or fewer rounds",
                self.method()
            ));
        }
        if self.view.camera_from.is_some() && self.view.camera_from == self.view.camera_to {
            return usage("--camera-from and --camera-to are the same point; the camera has no direction".into());
        }
        Ok(())
    }

    /// The options of one frame's image.
    #[must_use]
    pub fn of_frame(&self, number: u32) -> Self {
        let mut options = self.clone();
        options.outputs = self.images().iter().map(|output| output.numbered(number)).collect();
        options.reading.time_in_animation = Some(self.frames.seconds(number));
        if self.frames.frame_seeds == FrameSeeds::Own {
            options.transport.seed = self.transport.seed.wrapping_add(number.into());
        }
        options.frames.frames = None;
        options
    }

    /// The same for an image of which this is the size, a part of it or not.
    #[must_use]
    pub fn of_size(&self, [width, height]: [u32; 2]) -> Self {
        let size = Size { width: width as usize, height: height as usize };
        Self { view: self.view.sized(size), ..self.clone() }
    }

    /// Whether sums are read from a file or written to one.
    pub fn keeps_sums(&self) -> bool {
        self.targets().iter().any(OutputFile::holds_sums)
    }

    /// The files to write in the end. The file that sums are kept in comes first: it is what must not be lost.
    pub fn targets(&self) -> Vec<OutputFile> {
        let mut targets = self.images();
        if let Some(path) = self.keeping.file() {
            targets.retain(|target| !target.holds_sums() || target.path != path);
            targets.insert(0, OutputFile { path: path.into(), format: Format::Sums });
        }
        targets
    }

    /// SCENE with an ending, in the current folder.
    pub fn named_after_scene(&self, ending: &str) -> PathBuf {
        let mut name = self.scene.file_stem().map_or_else(|| "render".into(), OsStr::to_os_string);
        name.push(ending);
        name.into()
    }

    /// The files asked for, or SCENE.exr and SCENE.png in the current folder.
    pub fn images(&self) -> Vec<OutputFile> {
        if !self.outputs.is_empty() {
            return self.outputs.clone();
        }
        let number = if self.frames.frames.is_some() { ".####" } else { "" };
        let file =
            |ending: &str, format| OutputFile { path: self.named_after_scene(&format!("{number}{ending}")), format };
        vec![file(".exr", Format::Exr), file(".png", Format::Png)]
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::values::Strata;

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
        assert_eq!(
            (options.method(), options.transport.strata, options.transport.seed),
            (Method::Auto, Strata::default(), 0)
        );
        assert_eq!((options.have_budget(), options.rounds, options.first_round), (false, None, 0));
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
        assert_eq!((options.method(), options.transport.strata), (Method::Bdpt, "4x3".parse().expect("strata")));
        assert_eq!(options.per_pixel(), Some(4.5));
        assert_eq!((options.rounds, options.first_round, options.transport.max_length), (Some(4), 2, Some(8)));
        assert_eq!(
            (options.view.camera_from, options.view.camera_to),
            (Some([-1.0, 2.0, 3.0]), Some([0.0, 0.0, -1.0]))
        );
        assert_eq!((options.view.fov, options.exposure), (Some(40.0), -1.5));
        assert!(options.json && options.quiet);
    }

    #[test]
    fn names_that_other_renderers_use_are_understood() {
        let ours = "--samples-per-pixel 8 --size 64x48 --threads 2 --method pt";
        for theirs in [
            "--spp 8 --resolution 64x48 -t 2 --integrator path",
            "--samples 8 -s 64x48 -j2 --integrator pt",
            "--spp=8 -s64x48 --nthreads 2 --method path",
        ] {
            assert_eq!(parse(theirs), parse(ours), "{theirs}");
        }
        assert!(parse("-s 64").expect_err("no size").contains("samples per pixel are --spp"));
    }

    #[test]
    fn each_budget_is_understood() {
        assert_eq!(parse("--time 5m").map(|o| o.time), Ok(Some(Duration::from_secs(300))));
        assert_eq!(parse("--error 2%").map(|o| o.error), Ok(Some(0.02)));
        assert_eq!(parse("--mutations-per-pixel 64").map(|o| o.per_pixel()), Ok(Some(64.0)));
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
            "--size 4x4 --height 4",
            "--spp 4 --samples-per-pixel 4",
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
            ("-o a.gif", "has to end in .exr, .hdr, .png or .jpg"),
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
