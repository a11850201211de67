//! `mlt merge`: one render from its parts.

use anyhow::{Context, anyhow};
use clap::Parser;

use crate::{
    Failure,
    args::{Cli, Command, merge::MergeOptions, render::RenderOptions},
    kept::{Kept, read, words},
    output::{self, OutputFile},
    render::{self, Features, Finished, Made},
};

/// Adds the parts up, one at a time in memory beside the sum, and writes the files.
pub fn run(options: &MergeOptions) -> Result<(), Failure> {
    output::check_targets(&options.outputs, options.json).map_err(Failure::Usage)?;
    if !options.force {
        output::check_existing(options.outputs.iter().cloned()).map_err(Failure::Usage)?;
    }
    let mut parts = options.parts.iter().map(|path| read(path));
    let mut sum = parts.next().unwrap_or_else(|| Err(Failure::Usage(anyhow!("no part is given"))))?;
    for part in parts {
        sum.add(&part?).map_err(Failure::Usage)?;
    }
    if !options.outputs.iter().all(OutputFile::holds_sums) {
        sum.check_complete().map_err(Failure::Usage)?;
    }
    let options =
        sum.render_options(options).with_context(|| sum.path.display().to_string()).map_err(Failure::Usage)?;
    let finished = sum.finished(&options)?;
    let report = render::write(&options, finished.made, &finished.sums)?;
    render::show(&options, &report)
}

impl Kept {
    /// Adds another part of the same render.
    fn add(&mut self, part: &Self) -> anyhow::Result<()> {
        let [sum, other] = [&self.path, &part.path].map(|path| path.display());
        self.sums.merge(&part.sums).with_context(|| format!("{other} does not go with {sum}"))?;
        if self.pilot != part.pilot {
            return Err(anyhow!("{other} does not go with {sum}: their pilots found different things"));
        }
        if self.about.whole != part.about.whole {
            let [a, b] = [self, part].map(|part| part.about.whole.as_ref().map_or("no number of rounds".into(), words));
            return Err(anyhow!("{other} does not go with {sum}: the whole render is {b} in one and {a} in the other"));
        }
        self.about.spent = self.about.spent.and(part.about.spent);
        Ok(())
    }

    /// Refuses sums that lack a round.
    fn check_complete(&self) -> anyhow::Result<()> {
        let held = self.sums.rounds();
        let first = held.ranges().first().map_or(0, |range| range.start);
        let last = held.ranges().last().map_or(0, |range| range.end);
        let whole = self.about.whole.clone().unwrap_or(first..last);
        let missing: Vec<_> = held.missing(whole.clone()).iter().map(words).collect();
        match missing.is_empty() {
            true => Ok(()),
            false => {
                Err(anyhow!("the rounds {} of {} are in no part; add their parts", missing.join(", "), words(&whole)))
            }
        }
    }

    /// The options of the whole render, for these files.
    fn render_options(&self, merge: &MergeOptions) -> anyhow::Result<RenderOptions> {
        let words = ["mlt", "render"].into_iter().chain(self.about.arguments.iter().map(String::as_str));
        let Ok(Command::Render(of_render)) = Cli::try_parse_from(words).map(|cli| cli.command) else {
            return Err(anyhow!("the options in it are not understood"));
        };
        let exposure = merge.exposure.unwrap_or(of_render.exposure);
        let (outputs, json, quiet) = (merge.outputs.clone(), merge.json, merge.quiet);
        Ok(RenderOptions { outputs, exposure, json, quiet, ..*of_render })
    }

    /// The render as if it had just ended.
    fn finished(self, options: &RenderOptions) -> anyhow::Result<Finished> {
        let mut report = render::report(options, &self.about.provenance, &self.sums)?;
        report.set_time(self.about.spent);
        let (per_pixel, features) = (self.per_pixel()?, Features::default());
        let made = Made { per_pixel, pilot: self.pilot, about: self.about, report, features };
        Ok(Finished { sums: self.sums, made })
    }
}
