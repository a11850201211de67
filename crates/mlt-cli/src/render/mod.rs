//! `mlt render`.

mod blocks;
mod checkpoint;
mod exposure;
mod features;
mod files;
mod frames;
mod key;
mod losses;
mod made;
mod pilot;
mod plan;
mod pose;
mod preview;
mod session;
mod setup;
mod speed;
mod stop;
mod summary;
mod tev;
mod trust;

use std::time::Duration;

use anyhow::Context;
use mlt_core::transport::{
    render::{Sums, film_of},
    scene::View,
};
use mlt_scene::printable;

use crate::{
    Failure,
    args::render::RenderOptions,
    atomic,
    denoise::Denoiser,
    image::Image,
    interrupt::Interrupt,
    kept::{self, Kept},
    output::{OutputFile, errors},
    print,
    report::Report,
    tell, warn, warn_all,
};

pub(crate) use blocks::Blocks;
pub(crate) use features::Features;
pub(crate) use files::write;
pub(crate) use made::{Finished, Made};
pub(crate) use plan::Plan;
pub(crate) use setup::{Setup, bytes_of_image};
pub(crate) use summary::report;

/// Renders, writes the files, and reports.
pub fn run(options: &RenderOptions) -> Result<(), Failure> {
    options.check()?;
    if options.show.denoise {
        Denoiser::load().map_err(Failure::Usage)?;
    }
    match &options.frames.frames {
        Some(frames) => frames::run(options, frames),
        None => go_on(options, options.keeping.resume.as_deref().map(kept::read).transpose()?),
    }
}

/// One image, from rounds that there are already.
pub(crate) fn go_on(options: &RenderOptions, kept: Option<Kept>) -> Result<(), Failure> {
    let setup = Setup::new(options)?;
    let report = rendered(options, &setup, &Workshop::open(options)?, kept)?;
    show(options, &report)?;
    if report.interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Threads and signals, which the renders of a process share.
struct Workshop {
    pool: rayon::ThreadPool,
    interrupt: Interrupt,
}

impl Workshop {
    /// The threads that the options have, and handlers of signals: once in a process.
    fn open(options: &RenderOptions) -> anyhow::Result<Self> {
        let threads = options.threads.map_or(0, std::num::NonZeroUsize::get);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start the threads")?;
        Ok(Self { pool, interrupt: Interrupt::install()?.heeding_requests()? })
    }
}

/// Renders on from `kept` rounds, if there are some, and writes the files.
fn rendered(
    options: &RenderOptions,
    setup: &Setup,
    Workshop { pool, interrupt }: &Workshop,
    kept: Option<Kept>,
) -> Result<Report, Failure> {
    let options = &options.of_size(setup.size);
    let held = kept.as_ref().map(Kept::per_pixel).transpose()?;
    let plan = Plan::new(options, held);
    plan.check()?;
    if !options.quiet && !options.have_budget() {
        announce(&plan);
    }
    let finished = pool.install(|| session::run(options, setup, plan, interrupt, kept))?;
    pool.install(|| write(options, finished.made, &finished.sums))
}

/// Whether rounds are all that a render makes. Those of another render are refused.
pub(crate) fn is_done(options: &RenderOptions, kept: &Kept) -> Result<bool, Failure> {
    let (setup, per_pixel) = (Setup::new(options)?, kept.per_pixel()?);
    let options = &options.of_size(setup.size);
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

/// Renders on the current rayon pool and writes nothing but the options' checkpoint, from which it goes on if that is there.
pub(crate) fn in_memory(options: &RenderOptions, setup: &Setup, interrupt: &Interrupt) -> Result<Rendered, Failure> {
    let (options, checkpoint) = (&options.of_size(setup.size), options.keeping.checkpoint.as_deref());
    let kept = checkpoint.and_then(kept::if_whole);
    let plan = Plan::new(options, kept.as_ref().map(Kept::per_pixel).transpose()?);
    let Finished { sums, made } = session::run(options, setup, plan, interrupt, kept)?;
    if let Some(path) = checkpoint {
        atomic::write(path, &kept::encode(&made.about, made.pilot.as_deref(), &sums)?)?;
    }
    let film = sums.film();
    let (image, stderr) = (files::developed(film)?, (film.rounds() > 1).then(|| errors::of_all(film)));
    Ok(Rendered { image, stderr, report: made.report, blocks: film.blocks().into() })
}

fn announce(plan: &Plan) {
    tell(&format!("no budget given; {plan}\n"));
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
        if options.targets().iter().any(OutputFile::is_stdout) { tell(&lines) } else { print(&lines)? }
    }
    Ok(())
}
