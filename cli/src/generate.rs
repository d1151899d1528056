//! What the program generates: studies with every key explained, schemas, completions and manual pages.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::arg_parsers::one_of;
use crate::failure::Failure;
use crate::output::{print, unwritten};
use crate::program::command;
use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Args, Command};
use clap_complete::{Shell, generate};
use sagnac::store::folder::{Folder, write_new};
use sagnac::study::Kind;
use sagnac_engine::kinds::{self, KINDS};

const NEW_EXAMPLES: &str = "\
Examples:
  sagnac new gap-fill
  sagnac new switched-run my_run.toml";

#[derive(Debug, Args)]
#[command(after_long_help = NEW_EXAMPLES)]
pub struct New {
    /// Kind of the study
    #[arg(value_name = "KIND", value_parser = kinds())]
    kind: &'static Kind,
    /// File to write [default: <KIND>.toml]
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
}

/// The kinds of studies as values of an argument.
fn kinds() -> impl TypedValueParser<Value = &'static Kind> {
    let named = |kind: &Kind| PossibleValue::new(kind.name).help(kind.subject.trim_end_matches('.'));
    one_of(KINDS.map(|kind| (named(kind), kind)))
}

/// Writes a commented study, unless the file exists.
pub fn new(options: &New) -> Result<(), Failure> {
    let kind = options.kind.name;
    let path = options.file.clone().unwrap_or_else(|| PathBuf::from(format!("{kind}.toml")));
    let written = write_new(&path, |file| file.write_all(options.kind.template.as_bytes()));
    written.map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => Failure::Usage(format!(
            "{} already exists and was not changed\nname another file: sagnac new {kind} FILE",
            path.display()
        )),
        _ => unwritten(&path)(source),
    })?;
    let path = path.display();
    print(&format!("wrote {path}\nchange it, then run it: sagnac run {path} --plot"))
}

const SCHEMA_EXAMPLES: &str = "\
Examples:
  sagnac schema > study.schema.json
  sagnac schema run";

#[derive(Debug, Args)]
#[command(after_long_help = SCHEMA_EXAMPLES)]
pub struct Schema {
    /// Documents to describe: study files, or the output of a command with --json
    #[arg(value_name = "OF", value_parser = documents(), default_value = "study")]
    of: fn() -> String,
}

/// The documents with their schemas. All commands with results print documents of one form.
fn documents() -> impl TypedValueParser<Value = fn() -> String> {
    fn document() -> String {
        include_str!("../../schema/document.schema.json").to_owned()
    }
    one_of::<_, fn() -> String, 11>([
        ("study", kinds::schema),
        ("run", document),
        ("merge", document),
        ("design", document),
        ("sensitivity", document),
        ("filler", document),
        ("allan", document),
        ("compare", document),
        ("lot", document),
        ("model", document),
        ("bench", || include_str!("../../schema/bench.schema.json").to_owned()),
    ])
}

/// Prints a JSON schema.
pub fn schema(options: &Schema) -> Result<(), Failure> {
    print(&(options.of)())
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  sagnac completions bash > ~/.local/share/bash-completion/completions/sagnac
  sagnac completions fish > ~/.config/fish/completions/sagnac.fish";

#[derive(Debug, Args)]
#[command(after_long_help = COMPLETIONS_EXAMPLES)]
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
