//! `mlt man`: manual pages.

use anyhow::{Context, anyhow};
use clap::{Arg, Command, CommandFactory};
use clap_mangen::Man;

use crate::{
    Failure,
    args::{Cli, tools::ManOptions},
    atomic, print,
};

/// Prints a page, or writes all of them into a folder.
pub fn run(options: &ManOptions) -> Result<(), Failure> {
    let without_help = |command: Command| command.disable_help_subcommand(true);
    let mut program = without_help(Cli::command()).mut_subcommands(without_help);
    program.build();
    if let Some(folder) = &options.folder {
        if !folder.is_dir() {
            let name = folder.display();
            return Err(Failure::Usage(anyhow!(
                "{name}: is no folder; make it first, or print a page by --command NAME"
            )));
        }
        for command in all(&program) {
            let (name, text) = page(command)?;
            atomic::write(&folder.join(name), &text)?;
        }
        return Ok(());
    }
    let command = match &options.name {
        None => &program,
        Some(name) => program.find_subcommand(name).ok_or_else(|| {
            let names: Vec<_> = program.get_subcommands().map(Command::get_name).collect();
            Failure::Usage(anyhow!("there is no command \"{name}\"; mlt: {}", mlt_scene::instead_of(name, &names)))
        })?,
    };
    Ok(print(&String::from_utf8_lossy(&page(command)?.1))?)
}

/// A command and all below it.
fn all(command: &Command) -> Vec<&Command> {
    std::iter::once(command).chain(command.get_subcommands().flat_map(all)).collect()
}

/// The file name of a command's page, and its text in roff.
fn page(command: &Command) -> anyhow::Result<(String, Vec<u8>)> {
    // Of options that are hidden in short help, the page shows long help alone.
    let with_long_help = |argument: Arg| match (argument.get_long_help(), argument.get_help().cloned()) {
        (None, Some(help)) => argument.long_help(help),
        _ => argument,
    };
    let command = command.clone().mut_args(with_long_help);
    let page = Man::new(command.version(env!("CARGO_PKG_VERSION")));
    let page = page.date(concat!("version ", env!("CARGO_PKG_VERSION"))).source("mlt");
    let mut text = Vec::new();
    page.render(&mut text).context("cannot make the manual page")?;
    Ok((page.get_filename(), text))
}
