//! `mlt farm`: renders in parts or frames on many machines, by the schedulers that there are.
//!
//! A job has one task for each part and one that merges them, or one for each frame. Tasks know nothing of each other: each is
//! `mlt farm task`, and all that they share is a folder.

mod job;
mod openjd;
mod slurm;
mod task;

use crate::{
    Failure,
    args::farm::{FarmCommand, FarmOptions},
    print,
};
use job::Job;

/// Writes a job, or does a task of one.
pub fn run(options: &FarmOptions) -> Result<(), Failure> {
    match &options.command {
        FarmCommand::Slurm(options) => Ok(print(&slurm::script(&Job::new(options)?))?),
        FarmCommand::Openjd(options) => Ok(print(&openjd::template(&Job::new(options)?)?)?),
        FarmCommand::Task(options) => task::run(options),
    }
}
