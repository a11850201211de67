//! A render in parts, as the words of a shell.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Parser;

use crate::{
    Failure,
    args::{
        Cli, Command,
        farm::{JobOptions, PartedOptions},
        kept::Shard,
        render::RenderOptions,
        written::shell_word,
    },
    output::{self, OutputFile},
    render::Plan,
    usage,
};

/// The parts that the jobs of all schedulers have in common. Words are quoted for a POSIX shell.
pub(super) struct Job {
    /// Number of tasks, one a part.
    pub(super) tasks: u64,
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
        let render = options_of(Shard::new(1, options.shards), &options.render)?;
        check(&render)?;
        let folder = std::env::current_dir().context("cannot find the current folder")?;
        let outputs = render.images();
        let outputs = outputs.iter().map(|output| Ok(format!("-o {}", word(&output.path)?)));
        let words = options.render.words.iter().map(|text| word(Path::new(text)));
        Ok(Self {
            tasks: options.shards,
            threads: render.threads.map(std::num::NonZeroUsize::get),
            folder: word(&folder)?,
            parts: word(&parts_folder(&options.render, &render))?,
            render: words.collect::<Result<Vec<_>, Failure>>()?.join(" "),
            outputs: outputs.collect::<Result<Vec<_>, Failure>>()?.join(" "),
        })
    }

    /// The same with all words changed.
    pub(super) fn with_words(&self, change: impl Fn(&str) -> String) -> Self {
        let [folder, parts, render, outputs] =
            [&self.folder, &self.parts, &self.render, &self.outputs].map(|words| change(words));
        Self { tasks: self.tasks, threads: self.threads, folder, parts, render, outputs }
    }

    /// The command of a task; `number` is what the scheduler puts its number in by.
    pub(super) fn task(&self, number: &str) -> String {
        format!("mlt farm task --parts {} --shard {number}/{} -- {}", self.parts, self.tasks, self.render)
    }

    /// The command that makes the images from the parts.
    pub(super) fn merge(&self) -> String {
        format!("mlt merge {}/part-*.mltp {}", self.parts, self.outputs)
    }
}

/// The options of a part of a render.
pub(super) fn options_of(part: Shard, options: &PartedOptions) -> Result<RenderOptions, Failure> {
    let shard = format!("--shard={part}");
    let words = ["mlt", "render", &shard].into_iter().chain(options.words.iter().map(String::as_str));
    let refused = |message: &str| Err(Failure::Usage(anyhow!("{message}")));
    match Cli::try_parse_from(words).map(|cli| cli.command) {
        Ok(Command::Render(options)) => Ok(*options),
        Ok(_) => refused("the options of 'mlt render' are not understood"),
        Err(error) if error.use_stderr() => refused(&usage::sentence(&error)),
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
    if render.show.features() || render.show.denoise {
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
