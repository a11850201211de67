//! `mlt render`.

mod blocks;
mod checkpoint;
mod files;
mod key;
mod losses;
mod pilot;
mod plan;
mod pose;
mod session;
mod setup;
mod speed;
mod summary;
mod trust;

use std::{io::Write, time::Duration};

use anyhow::Context;
use mlt_core::transport::{
    render::{Sums, film_of},
    scene::View,
};
use mlt_scene::printable;

use crate::{
    Failure,
    args::render::RenderOptions,
    image::Image,
    interrupt::Interrupt,
    kept::{self, Kept},
    print,
    report::Report,
    warn, warn_all,
};

pub(crate) use blocks::Blocks;
pub(crate) use files::write;
pub(crate) use plan::Plan;
pub(crate) use session::Finished;
pub(crate) use setup::Setup;
pub(crate) use summary::report;

/// Renders, writes the files, and reports.
pub fn run(options: &RenderOptions) -> Result<(), Failure> {
    options.check()?;
    go_on(options, options.keeping.resume.as_deref().map(kept::read).transpose()?)
}

/// The same from rounds that there are already.
pub(crate) fn go_on(options: &RenderOptions, kept: Option<Kept>) -> Result<(), Failure> {
    let setup = Setup::new(options)?;
    let held = kept.as_ref().map(Kept::per_pixel).transpose()?;
    let plan = Plan::new(options, held);
    plan.check()?;
    if !options.quiet && !options.have_budget() {
        announce(&plan);
    }
    let threads = options.threads.map_or(0, std::num::NonZeroUsize::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start the threads")?;
    let interrupt = Interrupt::install()?;
    let finished = pool.install(|| session::run(options, &setup, plan, &interrupt, kept))?;
    let interrupted = finished.report.interrupted;
    let report = pool.install(|| write(options, finished))?;
    show(options, &report)?;
    if interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Whether rounds are all that a render makes. Those of another render are refused.
pub(crate) fn is_done(options: &RenderOptions, kept: &Kept) -> Result<bool, Failure> {
    let (setup, per_pixel) = (Setup::new(options)?, kept.per_pixel()?);
    let view = View { scene: &setup.scene, camera: &setup.camera };
    let (own, mut sums) = (Plan::new(options, Some(per_pixel)).own(), Sums::new(film_of(view)));
    sums = sums.with_key(key::key(options, &setup, per_pixel)?);
    kept.resume(&mut sums, own.clone())?;
    Ok(sums.rounds().missing(own).is_empty())
}

/// An image in memory, and how it came about.
pub(crate) struct Rendered {
    /// The pixels.
    pub image: Image,
    /// Their standard errors; `None` where one round tells nothing of them.
    pub stderr: Option<Vec<[f32; 3]>>,
    /// The report.
    pub report: Report,
    /// Contribution of each round to each block of the image.
    pub blocks: Blocks,
}

/// Renders on the current rayon pool and writes nothing.
pub(crate) fn in_memory(options: &RenderOptions, setup: &Setup, interrupt: &Interrupt) -> Result<Rendered, Failure> {
    let finished = session::run(options, setup, Plan::new(options, None), interrupt, None)?;
    let Finished { sums, report, .. } = finished;
    let film = sums.into_parts().0;
    let blocks = film.blocks().into();
    let (image, stderr) = files::develop(film, true)?;
    Ok(Rendered { image, stderr, report, blocks })
}

fn announce(plan: &Plan) {
    // Nobody is left to tell when standard error is gone.
    let _ = writeln!(std::io::stderr(), "no budget given; {plan}");
}

/// Warns, and prints the report as the options have it.
pub(crate) fn show(options: &RenderOptions, report: &Report) -> Result<(), Failure> {
    warn_all(&report.warnings);
    if report.interrupted {
        let seconds = Duration::from_secs_f64(report.seconds).as_secs();
        warn(&format!("interrupted after {seconds} s; the files hold the {} finished rounds", report.rounds));
    }
    if options.json {
        let json = serde_json::to_string_pretty(report).context("cannot encode the report")?;
        print(&(json + "\n"))?;
    } else if !options.quiet {
        let lines: String = report.to_string().lines().map(|line| printable(line, usize::MAX) + "\n").collect();
        print(&lines)?;
    }
    Ok(())
}
