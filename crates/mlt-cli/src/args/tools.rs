//! Options of the commands that describe the program: `mlt scenes`, `mlt completions` and `mlt man`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use clap_complete::Shell;

/// Options of `mlt scenes`.
#[derive(Args, Debug)]
pub struct ScenesOptions {
    /// Print a list of objects
    #[arg(long)]
    pub json: bool,
}

/// Options of `mlt completions`.
#[derive(Args, Debug)]
#[command(after_help = "\
Where they go:
  bash        mlt completions bash > ~/.local/share/bash-completion/completions/mlt
  zsh         mlt completions zsh > ~/.zfunc/_mlt
              with fpath+=~/.zfunc before compinit in ~/.zshrc
  fish        mlt completions fish > ~/.config/fish/completions/mlt.fish
  powershell  mlt completions powershell >> $PROFILE")]
pub struct CompletionsOptions {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Options of `mlt man`.
#[derive(Args, Debug)]
pub struct ManOptions {
    /// Write a page for each command into FOLDER, which has to exist; else the program's page to standard output
    #[arg(value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub folder: Option<PathBuf>,
    /// Write the page of this command to standard output
    #[arg(long = "command", value_name = "COMMAND", conflicts_with = "folder")]
    pub name: Option<String>,
}
