//! `mlt bench`: error charted against time, rays and mutations.

mod axis;
mod chart;
mod folder;
mod journal;
mod paint;
mod paper;
mod report;
mod row;
mod runs;
pub(crate) mod statistics;
mod study;
mod subject;
mod summary;

use anyhow::Context;

use crate::{Failure, args::bench::BenchOptions, interrupt::Interrupt, print};
use folder::{Folder, WithErrors};
use journal::Journal;
use runs::{Ready, say};
use study::{Study, Truth};
use subject::{Reference, Subject};

/// Makes the runs that are missing, and the report.
pub fn run(options: &BenchOptions) -> Result<(), Failure> {
    let study = Study::new(options)?;
    let threads = options.threads.map_or(0, std::num::NonZeroUsize::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start the threads")?;
    let interrupt = Interrupt::install()?;
    pool.install(|| run_here(options, &study, &interrupt))
}

fn run_here(options: &BenchOptions, study: &Study, interrupt: &Interrupt) -> Result<(), Failure> {
    // Everything that can be wrong with the input is found before anything is rendered.
    let files = study.truths.iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
    let loaded = study.scenes.iter().zip(&files).map(|(scene, file)| {
        let image = file.as_ref().map(|(image, _)| image);
        Subject::load(scene, options, image)
    });
    let subjects = loaded.collect::<Result<Vec<_>, _>>()?;
    let folder = Folder::create(&options.output)?;
    let mut journal = Journal::open(&folder.file("runs.jsonl"))?;

    let mut ready = Ready {
        study,
        subjects: Vec::new(),
        max_length: options.max_length,
        folder: &folder,
        interrupt,
        quiet: options.quiet,
    };
    for ((subject, truth), file) in subjects.into_iter().zip(&study.truths).zip(files) {
        say(options.quiet, &format!("{}: finding the reference", subject.name));
        let Some(reference) = subject.reference(truth, file, &options.reference_method, &folder, interrupt)? else {
            return interrupted("interrupted before the reference was finished; nothing is written");
        };
        ready.subjects.push((subject, reference));
    }
    let complete = ready.make_runs(&mut journal)?;
    let rows = ready.rows(&journal);
    if rows.is_empty() {
        return interrupted("interrupted before the first run was finished; there is no report");
    }
    write(options, &ready, &rows)?;
    match complete {
        true => Ok(()),
        false => interrupted("interrupted; the report has what was finished, and the same command goes on from there"),
    }
}

fn read(truth: &Truth) -> anyhow::Result<Option<WithErrors>> {
    match truth {
        Truth::File(path) => Reference::read(path).map(Some),
        Truth::Render(_) => Ok(None),
    }
}

fn write(options: &BenchOptions, ready: &Ready, rows: &[row::Row]) -> Result<(), Failure> {
    let paper = if options.paper { paper::table(rows) } else { Vec::new() };
    let json = serde_json::to_string_pretty(&serde_json::json!({ "rows": rows, "paper": paper }));
    ready.folder.write("results.json", (json.context("cannot encode the results")? + "\n").as_bytes())?;
    ready.folder.write("results.csv", row::csv(rows).as_bytes())?;
    let html = report::html(ready, rows, &paper, options)?;
    ready.folder.write("report.html", html.as_bytes())?;
    report::charts(ready, rows).iter().try_for_each(|(name, svg)| ready.folder.chart(name, svg))?;
    if !options.quiet {
        print(&paper::text(&paper))?;
        print(&format!("written  {}\n", ready.folder.file("report.html").display()))?;
    }
    Ok(())
}

fn interrupted(message: &str) -> Result<(), Failure> {
    Err(Failure::InterruptedEarly(anyhow::anyhow!(message.to_owned())))
}
