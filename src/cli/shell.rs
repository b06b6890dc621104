//! `rootvox completions` and `rootvox man`: what shells and `man` know of the program.

use super::terminal::{data, talkln};
use crate::error::{Error, Result};
use clap::{Args, Command};
use clap_complete::Shell;
use std::path::PathBuf;

/// Print what makes a shell complete rootvox's commands and options.
///
/// Examples:
///   rootvox completions bash > ~/.local/share/bash-completion/completions/rootvox
///   rootvox completions zsh > ~/.zfunc/_rootvox
///   rootvox completions fish > ~/.config/fish/completions/rootvox.fish
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Completions {
    /// The shell.
    shell: Shell,
}

impl Completions {
    /// Prints the script.
    pub fn run(&self, mut command: Command) {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut command, "rootvox", &mut script);
        data!("{}", String::from_utf8_lossy(&script));
    }
}

/// Write the manual pages, one for each command.
///
/// Example:
///   rootvox man ~/.local/share/man/man1 && man rootvox-run
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Man {
    /// Folder to write into; made when it is not there.
    folder: PathBuf,
}

impl Man {
    /// Writes the pages.
    ///
    /// # Errors
    /// A folder that cannot be written into.
    pub fn run(&self, command: Command) -> Result<()> {
        std::fs::create_dir_all(&self.folder).map_err(|e| Error::io("make", &self.folder, e))?;
        clap_mangen::generate_to(command, &self.folder).map_err(|e| Error::io("write", &self.folder, e))?;
        talkln!("manual pages written: {}", self.folder.display());
        Ok(())
    }
}
