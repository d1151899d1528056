//! Writing of data to the standard output and to files.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use sagnac::report::page::FILE as REPORT;
use sagnac::report::page::document::json;
use sagnac::store::folder::{self, Folder};
use sagnac::table::Table;
use sagnac::use_cases::Outcome;
use sagnac_base::diagnostics::{visible, visible_json};
use serde::Serialize;

use crate::failure::Failure;
use crate::outcome;
use crate::progress::{How, Shown, aside};

/// Where a command on logs writes its results, and what it prints.
#[derive(Debug, Args)]
pub struct Output {
    /// Results folder [default: results/<name of the log>, with _model behind it for a model, results/<A>_vs_<B> for two logs, results/batch for a batch]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the results as JSON
    #[arg(help_heading = "Output", long)]
    pub json: bool,
    #[command(flatten)]
    pub printed: Printed,
}

// As a group it would have the name of the options around it, which debug builds refuse.
/// The options that choose which parts of the results are printed.
#[derive(Debug, Clone, Copy, Args)]
#[group(skip)]
pub struct Printed {
    /// Also print the tables
    #[arg(help_heading = "Output", long, conflicts_with_all = ["json", "quiet"])]
    pub table: bool,
    /// Also print all notes and the sections of the page
    #[arg(help_heading = "Output", long, short, conflicts_with_all = ["json", "quiet"])]
    pub verbose: bool,
    /// Also draw the first chart as text
    #[arg(help_heading = "Output", long, conflicts_with_all = ["json", "quiet"])]
    pub plot: bool,
    /// Open the page in a browser
    #[arg(help_heading = "Output", long)]
    pub open: bool,
    /// Print only errors and the headline
    #[arg(help_heading = "Output", long, short)]
    pub quiet: bool,
}

impl Printed {
    /// Opens the page of a results folder if that is asked for.
    pub fn open_page(&self, folder: &Path) {
        let page = folder.join(REPORT);
        if self.open
            && let Err(error) = open::that_detached(&page)
        {
            note!("cannot open {}: {error}", page.display());
        }
    }
}

impl Output {
    /// The results folder; by default the one called `name` in `results/`.
    pub fn folder(&self, name: impl AsRef<Path>) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("results").join(name))
    }

    /// Writes the results of a command on logs and prints them, or returns them as JSON, as [`outcome::finish`] does.
    ///
    /// # Errors
    /// It fails where that does.
    pub fn finish<'a>(
        &self,
        outcome: &Outcome,
        folder: &Path,
        inputs: impl IntoIterator<Item = &'a Path>,
        places: &[String],
    ) -> Result<Option<String>, Failure> {
        outcome::finish(outcome, folder, inputs, places, self.json, &self.printed)
    }

    /// Shows progress, unless only errors or JSON are printed.
    pub fn progress(&self) -> Shown {
        Shown::new(if self.printed.quiet || self.json { How::None } else { How::Plain })
    }
}

/// Prints `text`, made [`visible`], with a final line end.
///
/// # Errors
/// The reader has closed the output, or it cannot be written.
pub fn print(text: &str) -> Result<(), Failure> {
    print_drawn(&visible(text))
}

/// Prints a plot, which has colours and texts that are visible already.
///
/// # Errors
/// It fails where [`print`] does.
pub fn print_drawn(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "{}", text.trim_end()).and_then(|()| stdout.flush()).map_err(failure)
}

/// Prints a line on the standard error stream as it is, and changes nothing where that fails.
pub fn say(text: &str) {
    aside(|| {
        let _ = writeln!(io::stderr(), "{}", bounded(text));
    });
}

/// Most characters of a line on the standard error stream, which may quote what a stranger wrote.
const MAX_SAID: usize = 4096;

/// The text with the middle of longer lines left out.
fn bounded(text: &str) -> String {
    let of_line = |line: &str| {
        let count = line.chars().count();
        if count <= MAX_SAID {
            return line.to_owned();
        }
        let left = line.chars().take(MAX_SAID / 2).collect::<String>();
        left + " … " + &line.chars().skip(count - MAX_SAID / 2).collect::<String>()
    };
    text.split('\n').map(of_line).collect::<Vec<_>>().join("\n")
}

/// Prints `value` as an indented JSON document.
///
/// # Errors
/// It fails where [`print`] does.
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    print_documents(&[json(value)], 1)
}

/// Prints the documents of several inputs as an array, and that of a single input as it is.
///
/// # Errors
/// It fails where [`print`] does.
pub fn print_documents(documents: &[String], inputs: usize) -> Result<(), Failure> {
    match documents {
        [] => Ok(()),
        [document] if inputs == 1 => print_drawn(&visible_json(document)),
        several => print_drawn(&visible_json(&format!("[\n{}\n]", several.join(",\n")))),
    }
}

/// The end of what was `printed` to the standard output by other means.
///
/// # Errors
/// It fails where [`print`] does.
pub fn flushed(printed: io::Result<()>) -> Result<(), Failure> {
    printed.and_then(|()| io::stdout().flush()).map_err(failure)
}

/// A closed output is not an error, because the reader, such as `head`, has all it wants. Everything else is lost
/// output.
fn failure(error: io::Error) -> Failure {
    match error.kind() {
        ErrorKind::BrokenPipe => Failure::OutputClosed,
        _ => Failure::Output(error),
    }
}

/// Writes a file that the user names, outside of a results folder.
///
/// # Errors
/// There is one already, or it cannot be written.
pub fn write_new(
    path: &Path,
    contents: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    folder::write_new(path, contents).map_err(unwritten(path))
}

/// The failure to write to a path.
pub fn unwritten(path: &Path) -> impl Fn(io::Error) -> Failure {
    move |source| Failure::Write { path: path.to_owned(), source }
}

/// Writes a table of a results folder as CSV. Returns the SHA-256 of the file, in hexadecimal digits.
///
/// # Errors
/// It cannot be written.
pub fn write_table(folder: &Folder, name: &str, table: &Table) -> Result<String, Failure> {
    Ok(folder.write_by(name, |file| table.write_csv(file).map(drop))?)
}

/// Turns the signal for an exceeded file size limit into an ordinary error; by default it ends the program.
pub fn outlive_limits() {
    #[cfg(unix)]
    {
        let unheard = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        // If the handler cannot be registered, the signal ends the program as usual.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, unheard);
    }
}
