//! A render in parts or frames, as the words of a shell.

use std::{
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use anyhow::{Context, anyhow};
use clap::Parser;

use crate::{
    Failure,
    args::{
        Cli, Command,
        farm::{JobOptions, PartedOptions},
        kept::Shard,
        render::RenderOptions,
        usage::sentence,
        written::shell_word,
    },
    output::{self, OutputFile},
    render::Plan,
};

/// The tasks of a job, each by itself.
#[derive(Clone)]
pub(super) enum Tasks {
    /// So many parts of one image, from 1 on.
    Parts(u64),
    /// Frames of an animation.
    Frames(RangeInclusive<u32>),
}

/// Words and numbers that the jobs of all schedulers have in common. Words are quoted for a POSIX shell.
pub(super) struct Job {
    /// Its tasks.
    tasks: Tasks,
    /// Threads of each, if they were asked for.
    pub(super) threads: Option<usize>,
    /// The folder that paths are seen from.
    pub(super) folder: String,
    /// The folder of the parts.
    pub(super) parts: String,
    /// The scene and options of `mlt render`.
    render: String,
    /// The images, as options of `mlt merge`.
    outputs: String,
}

impl Job {
    /// Finds what is wrong with a job before anything is submitted.
    pub(super) fn new(options: &JobOptions) -> Result<Self, Failure> {
        let mut of_render = options.render.clone();
        let mut render = options_of(options.shards.map(|count| Shard::new(1, count)), &of_render)?;
        if let Some(count) = options.shards.filter(|count| needs_more_rounds(&render, *count)) {
            of_render.words.push(format!("--rounds={count}"));
            render = options_of(Some(Shard::new(1, count)), &of_render)?;
        }
        check(&render)?;
        let tasks = Tasks::of(options.shards, &render)?;
        let folder = std::env::current_dir().context("cannot find the current folder")?;
        let outputs = render.images();
        let outputs = outputs.iter().map(|output| Ok(format!("-o {}", word(&output.path)?)));
        let words = of_render.words.iter().map(|text| word(Path::new(text)));
        Ok(Self {
            tasks,
            threads: render.threads.map(std::num::NonZeroUsize::get),
            folder: word(&folder)?,
            parts: word(&parts_folder(&of_render, &render))?,
            render: words.collect::<Result<Vec<_>, Failure>>()?.join(" "),
            outputs: outputs.collect::<Result<Vec<_>, Failure>>()?.join(" "),
        })
    }

    /// The same with all words changed.
    pub(super) fn with_words(&self, change: impl Fn(&str) -> String) -> Self {
        let [folder, parts, render, outputs] =
            [&self.folder, &self.parts, &self.render, &self.outputs].map(|words| change(words));
        Self { tasks: self.tasks.clone(), threads: self.threads, folder, parts, render, outputs }
    }

    /// The name of all its tasks.
    pub(super) fn name(&self) -> &'static str {
        match self.tasks {
            Tasks::Parts(_) => "parts",
            Tasks::Frames(_) => "frames",
        }
    }

    /// The first and the last number of a task, as in 1-4.
    pub(super) fn numbers(&self) -> String {
        match &self.tasks {
            Tasks::Parts(count) => format!("1-{count}"),
            Tasks::Frames(frames) => format!("{}-{}", frames.start(), frames.end()),
        }
    }

    /// The command of a task; `number` is what the scheduler puts its number in by.
    pub(super) fn task(&self, number: &str) -> String {
        let one = match &self.tasks {
            Tasks::Parts(count) => format!("--shard {number}/{count}"),
            Tasks::Frames(_) => format!("--frame {number}"),
        };
        format!("mlt farm task --parts {} {one} -- {}", self.parts, self.render)
    }

    /// The command that makes the images from the parts; frames are images already.
    pub(super) fn merge(&self) -> Option<String> {
        matches!(self.tasks, Tasks::Parts(_)).then(|| format!("mlt merge {}/part-*.mltp {}", self.parts, self.outputs))
    }
}

impl Tasks {
    /// So many parts, or the frames of a render.
    fn of(shards: Option<u64>, render: &RenderOptions) -> Result<Self, Failure> {
        match (shards, &render.frames.frames) {
            (Some(count), _) => Ok(Self::Parts(count)),
            (None, Some(frames)) => Ok(Self::Frames(frames.0.clone())),
            (None, None) => Err(Failure::Usage(anyhow!(
                "nothing says what the tasks are: give --shards N before '--' for parts of one image, or --frames A-B behind it"
            ))),
        }
    }
}

/// Whether a render by itself has fewer rounds than there are parts, and nobody says how many.
fn needs_more_rounds(render: &RenderOptions, parts: u64) -> bool {
    render.rounds.is_none() && Plan::new(render, None).rounds.is_some_and(|rounds| rounds < parts)
}

/// The options of a render, or of a part of it.
pub(super) fn options_of(part: Option<Shard>, options: &PartedOptions) -> Result<RenderOptions, Failure> {
    let shard = part.map(|part| format!("--shard={part}"));
    let words = ["mlt", "render"].into_iter().chain(shard.as_deref()).chain(options.words.iter().map(String::as_str));
    let refused = |message: &str| Err(Failure::Usage(anyhow!("{message}")));
    match Cli::try_parse_from(words).map(|cli| cli.command) {
        Ok(Command::Render(options)) => Ok(*options),
        Ok(_) => refused("the options of 'mlt render' are not understood"),
        Err(error) if error.use_stderr() => refused(&sentence(&error)),
        Err(_) => refused("help and version are not options of a farm's render"),
    }
}

/// The folder of the parts of a render.
pub(super) fn parts_folder(options: &PartedOptions, render: &RenderOptions) -> PathBuf {
    options.parts.clone().unwrap_or_else(|| render.named_after_scene(".parts"))
}

fn check(render: &RenderOptions) -> Result<(), Failure> {
    check_words(render)?;
    render.check_together()?;
    Plan::new(render, None).check()?;
    output::check_targets(&render.images(), false).map_err(Failure::Usage)
}

/// Refuses options that a farm's tasks set themselves.
pub(super) fn check_words(render: &RenderOptions) -> Result<(), Failure> {
    let kept = &render.keeping;
    let set = [&kept.checkpoint, &kept.resume, &kept.pilot].into_iter().any(Option::is_some);
    if set || render.outputs.iter().any(OutputFile::holds_sums) {
        return Err(Failure::Usage(anyhow!(
            "the tasks of a farm name their .mltp files themselves; leave out --checkpoint, --resume, --pilot and -o FILE.mltp"
        )));
    }
    let has_frames = render.frames.frames.is_some();
    if has_frames && (render.time.is_some() || render.error.is_some()) {
        return Err(Failure::Usage(anyhow!(
            "--time and --error: a frame that is begun again has to have the same bits; give a number, as by --samples-per-pixel"
        )));
    }
    if !has_frames && (render.show.features() || render.show.denoise) {
        return Err(Failure::Usage(anyhow!("--aov and --denoise: parts hold sums of the image alone; leave them out")));
    }
    if render.outputs.iter().any(OutputFile::is_stdout) {
        return Err(Failure::Usage(anyhow!("-o -: a job has no standard output; give the image a file")));
    }
    Ok(())
}

/// A path or an option as one word for a POSIX shell.
fn word(path: &Path) -> Result<String, Failure> {
    let text = path.to_str().filter(|text| !text.contains(char::is_control));
    let refused = || Failure::Usage(anyhow!("{}: a job cannot hold this name; use one of plain text", path.display()));
    Ok(shell_word(text.ok_or_else(refused)?))
}
