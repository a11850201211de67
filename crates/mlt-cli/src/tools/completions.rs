//! `mlt completions`: what a shell needs to complete command lines.

use clap::CommandFactory;

use crate::{
    Failure,
    args::{Cli, tools::CompletionsOptions},
    print,
};

/// Prints the completions.
pub fn run(options: &CompletionsOptions) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(options.shell, &mut Cli::command(), "mlt", &mut text);
    Ok(print(&String::from_utf8_lossy(&text))?)
}
