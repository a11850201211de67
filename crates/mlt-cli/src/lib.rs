//! The `mlt` program: command line in, images and reports out.
//!
//! Exit codes: 0 success, 1 a failed run, 2 wrong usage, 128 + N stopped by signal N; an error is one sentence on standard error.

use std::process::ExitCode;

use clap::Parser;

pub mod args;
pub mod atomic;
pub mod bench;
pub mod denoise;
pub mod diff;
mod exit;
pub mod farm;
pub mod image;
pub mod info;
pub mod inspect;
pub mod interrupt;
pub mod kept;
mod log;
pub mod merge;
pub mod output;
pub mod progress;
pub mod provenance;
pub mod render;
pub mod report;
#[cfg(test)]
mod rooms;
mod system;
mod terminal;
pub mod tools;
pub mod verify;

pub use exit::Failure;
pub use system::{check_memory, cpu_seconds, memory, require_memory, take_memory};
pub use terminal::{print, tell, warn, warn_all};

/// Runs the program with the arguments of this process.
pub fn main() -> ExitCode {
    interrupt::outlive_file_limits();
    let words: Vec<_> = std::env::args_os().collect();
    // Help and objections have colours, too.
    terminal::choose_colour(args::line::colour(&words).into());
    let outcome = args::line::completed(words).and_then(|words| match args::Cli::try_parse_from(words) {
        Ok(cli) => run(&cli),
        Err(error) => args::usage::answer(&error),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run(cli: &args::Cli) -> Result<(), Failure> {
    log::start(cli.general.verbose);
    match &cli.command {
        args::Command::Render(options) => render::run(options),
        args::Command::Inspect(options) => inspect::run(options),
        args::Command::Scenes(options) => tools::scenes::run(options),
        args::Command::Merge(options) => merge::run(options),
        args::Command::Farm(options) => farm::run(options),
        args::Command::Info(options) => info::run(options),
        args::Command::Diff(options) => diff::run(options),
        args::Command::Verify(options) => verify::run(options),
        args::Command::Bench(options) => bench::run(options),
        args::Command::Completions(options) => tools::completions::run(options),
        args::Command::Man(options) => tools::man::run(options),
    }
}
