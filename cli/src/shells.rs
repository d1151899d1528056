//! `sagnac completions` and `sagnac man`: files for shells and for `man`.

use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::{Shell, generate};
use sagnac::store::folder::Folder;

use crate::failure::Failure;
use crate::output::{print, unwritten};
use crate::program::command;

const EXAMPLES: &str = "\
Examples:
  sagnac completions bash > ~/.local/share/bash-completion/completions/sagnac
  sagnac completions fish > ~/.config/fish/completions/sagnac.fish";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Completions {
    /// Shell
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

const MAN_EXAMPLES: &str = "\
Examples:
  sagnac man ~/.local/share/man/man1";

#[derive(Debug, Args)]
#[command(after_long_help = MAN_EXAMPLES)]
pub struct Man {
    /// Folder for the pages, such as ~/.local/share/man/man1
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Prints the script that completes commands and options.
pub fn completions(options: &Completions) -> Result<(), Failure> {
    let mut script = Vec::new();
    generate(options.shell, &mut command(), "sagnac", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Writes a page for the program and one for each command.
pub fn man(options: &Man) -> Result<(), Failure> {
    let folder = &options.folder;
    let written = Folder::open(folder)?;
    page(command(), "sagnac".to_owned(), &written)?;
    for command in command().get_subcommands().filter(|command| !command.is_hide_set()) {
        page(command.clone(), format!("sagnac-{}", command.get_name()), &written)?;
    }
    written.commit()?;
    print(&format!(
        "pages are in {}; read them with `man -l {}`",
        folder.display(),
        folder.join("sagnac.1").display()
    ))
}

fn page(command: Command, name: String, folder: &Folder) -> Result<(), Failure> {
    let file = format!("{name}.1");
    let command = command.display_name(name.clone()).bin_name(name.replacen('-', " ", 1));
    let mut page = Vec::new();
    clap_mangen::Man::new(command).title(name).render(&mut page).map_err(unwritten(Path::new(&file)))?;
    folder.write(&file, &page)?;
    Ok(())
}
