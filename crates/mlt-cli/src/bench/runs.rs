//! Makes the runs that are missing.

use std::{io::Write, time::Instant};

use anyhow::Context;

use super::{
    folder::Folder,
    journal::Journal,
    row::{Key, Row},
    study::{Run, Study},
    subject::{Reference, Subject},
};
use crate::{Failure, interrupt::Interrupt, render::Rendered, report::finite};

/// A study that is ready to run.
pub(super) struct Ready<'a> {
    /// The grid.
    pub study: &'a Study,
    /// Its scenes, with their references.
    pub subjects: Vec<(Subject, Reference)>,
    /// Longest path in edges.
    pub max_length: Option<u32>,
    /// Where images are kept.
    pub folder: &'a Folder,
    /// Tells when to stop.
    pub interrupt: &'a Interrupt,
    /// No progress.
    pub quiet: bool,
}

impl Ready<'_> {
    /// Makes every run that the journal does not have, on the current rayon pool. False when a signal stopped it.
    pub(super) fn make_runs(&self, journal: &mut Journal) -> Result<bool, Failure> {
        let missing: Vec<Run> = self.study.runs().filter(|run| !self.is_made(run, journal)).collect();
        let total = self.study.runs().count();
        let start = Instant::now();
        for (index, run) in missing.iter().enumerate() {
            if self.interrupt.requested() || !self.make(run, journal).map_err(|failure| self.named(run, failure))? {
                return Ok(false);
            }
            let made = index + 1;
            let left = start.elapsed().as_secs_f64() / made as f64 * (missing.len() - made) as f64;
            let row = journal.find(&self.key(run)).context("the run is not in the journal")?;
            let (method, budget) = (&row.key.method, &row.key.budget);
            let missed = row.missed(&self.study.budgets[run.budget]);
            let missed = missed.map_or_else(String::new, |beyond| format!(" ({:+.0} %)", 100.0 * beyond));
            self.say(&format!(
                "[{}/{total}] {}: {method}, {budget}, seed {}: relMSE {:.3e} in {:.1} s{missed}; {:.0} s left",
                total - missing.len() + made,
                row.key.scene,
                run.seed,
                row.errors.rel_mse,
                row.seconds,
                left
            ));
        }
        Ok(true)
    }

    /// The rows that there are, in the order of the grid.
    pub(super) fn rows(&self, journal: &Journal) -> Vec<Row> {
        self.study.runs().filter_map(|run| journal.find(&self.key(&run)).cloned()).collect()
    }

    /// The image that stands for a method in the report: largest budget, first seed.
    pub(super) fn image(&self, scene: usize, method: usize) -> Option<crate::image::Image> {
        let run = Run { scene, method, budget: self.study.budgets.len() - 1, seed: 1 };
        Some(self.folder.kept(&self.image_name(&run), &self.identity(&run))?.0)
    }

    fn is_made(&self, run: &Run, journal: &Journal) -> bool {
        let shown = self.is_shown(run);
        journal.find(&self.key(run)).is_some() && (!shown || self.image(run.scene, run.method).is_some())
    }

    fn is_shown(&self, run: &Run) -> bool {
        run.seed == 1 && run.budget + 1 == self.study.budgets.len()
    }

    fn make(&self, run: &Run, journal: &mut Journal) -> Result<bool, Failure> {
        let (subject, reference) = &self.subjects[run.scene];
        let (method, budget) = (&self.study.methods[run.method], self.study.budgets[run.budget]);
        let Some(rendered) = subject.render(method, budget, run.seed, self.interrupt)? else { return Ok(false) };
        if self.is_shown(run) {
            self.folder.keep(&self.image_name(run), &self.identity(run), &rendered.image, None)?;
        }
        journal.add(row(self.key(run), rendered, reference)?)?;
        Ok(true)
    }

    fn key(&self, run: &Run) -> Key {
        let (subject, reference) = &self.subjects[run.scene];
        let budget = self.study.budgets[run.budget];
        Key {
            scene: subject.name.clone(),
            method: self.study.methods[run.method].to_string(),
            budget: budget.to_string(),
            seed: run.seed,
            width: reference.image.width,
            height: reference.image.height,
            max_length: self.max_length,
            threads: (!budget.repeats()).then(rayon::current_num_threads),
            reference: reference.fingerprint.clone(),
        }
    }

    fn image_name(&self, run: &Run) -> String {
        let Key { scene, method, budget, .. } = self.key(run);
        format!("{scene}-{method}-{budget}")
    }

    fn identity(&self, run: &Run) -> String {
        format!("{:?}", self.key(run))
    }

    fn named(&self, run: &Run, failure: Failure) -> Failure {
        let Key { scene, method, budget, seed, .. } = self.key(run);
        let place = format!("{scene}: {method}, {budget}, seed {seed}");
        match failure {
            Failure::Run(error) => Failure::Run(error.context(place)),
            Failure::Usage(error) => Failure::Usage(error.context(place)),
            other => other,
        }
    }

    /// Progress, a line an event.
    pub(super) fn say(&self, text: &str) {
        say(self.quiet, text);
    }
}

/// One line on standard error; nobody is left to tell when that fails.
pub(super) fn say(quiet: bool, text: &str) {
    if !quiet {
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

fn row(key: Key, rendered: Rendered, reference: &Reference) -> anyhow::Result<Row> {
    let Rendered { image, report, .. } = rendered;
    Ok(Row {
        key,
        errors: reference.errors(&image)?,
        strata: report.transport.strata.to_string(),
        seconds: report.seconds,
        cpu_seconds: report.cpu_seconds,
        rounds: report.rounds,
        rays: report.rays,
        mutations: report.mutations,
        samples: report.samples,
        acceptance: report.acceptance.total,
        b: report.b,
        b_stderr: finite(report.b_stderr),
        mutation_acceptance: report.acceptance.mutations,
        strata_list: report.strata.into_iter().map(Into::into).collect(),
    })
}
