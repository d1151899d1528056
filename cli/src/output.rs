//! The outcome of a command: its files in a folder, and what is printed of it to the standard output.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;

use crate::failure::{Failure, in_options};
use crate::look;
use crate::progress::{How, Shown, aside};
use sagnac::report::chart::Picture;
use sagnac::report::page::FILE as REPORT;
use sagnac::report::page::json;
use sagnac::store::CARD;
use sagnac::store::folder::{self, Folder};
use sagnac::table::Table;
use sagnac::use_cases::Outcome;
use sagnac_base::diagnostics::{visible, visible_json};

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

    /// Writes the results of a command on logs and prints them, or returns them as JSON, as [`finish`] does.
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
        finish(outcome, folder, inputs, places, self.json, &self.printed)
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

/// Notes that are printed in any case, and lines up to which there is room for more of them.
const MIN_NOTES: usize = 2;
const MAX_LINES: usize = 20;

/// Lines that facts take which are not known yet, at most.
pub const LINES_OF_FACTS: usize = 4;

/// Writes the results of a command that read `inputs` into a folder, and prints them with the lines `places` on what else was written;
/// or returns them as JSON.
///
/// # Errors
/// A chart cannot be drawn, a file cannot be written or removed, or the output cannot be written.
pub fn finish<'a>(
    outcome: &Outcome,
    path: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
    places: &[String],
    json: bool,
    printed: &Printed,
) -> Result<Option<String>, Failure> {
    save(outcome, path, inputs)?;
    if json {
        return Ok(Some(outcome.json(&spell)));
    }
    show(outcome, places, printed, path)?;
    Ok(None)
}

/// Writes the results of a command that read `inputs` into a folder.
///
/// # Errors
/// A chart cannot be drawn, or a file cannot be written or removed.
pub fn save<'a>(
    outcome: &Outcome,
    path: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Failure> {
    let folder = Folder::open(path)?.reading(inputs);
    for (name, table) in outcome.all_tables() {
        write_table(&folder, name, table)?;
    }
    folder.write(CARD, json!(outcome.page.card(&spell)).to_string().as_bytes())?;
    save_page(outcome, &folder)
}

/// Spells settings as options.
pub fn spell(text: &str) -> String {
    in_options(&text)
}

/// Writes the page with its charts and the further files, and removes those of the [names](Outcome::names) of the outcome that an
/// earlier command wrote and this one does not.
///
/// # Errors
/// A chart cannot be drawn, or a file cannot be written or removed.
pub fn save_page(outcome: &Outcome, folder: &Folder) -> Result<(), Failure> {
    for (name, contents) in &outcome.files {
        folder.write(name, contents)?;
    }
    let charts: Vec<_> = outcome.page.figures().collect();
    // In parallel: a chart of 10,000 points takes half a second, and the page as long.
    let (drawn, made) = rayon::join(
        || charts.par_iter().try_for_each(|drawn| write_pictures(folder, &drawn.stem, &drawn.picture)),
        || folder.write(REPORT, outcome.page.html(&spell).as_bytes()),
    );
    drawn?;
    made?;
    let pictures = charts.iter().flat_map(|drawn| ["svg", "png"].map(|end| format!("{}.{end}", drawn.stem)));
    let files = outcome.files.iter().map(|(name, _)| name.clone());
    let tables = outcome.all_tables().map(|(name, _)| (*name).to_owned());
    let written: Vec<String> = pictures.chain(files).chain(tables).collect();
    for name in folder.listed() {
        if outcome.names.iter().any(|own| matches(own, &name)) && !written.contains(&name) {
            folder.remove(&name)?;
        }
    }
    Ok(folder.commit()?)
}

/// Writes the page again, whose charts and tables are as they were.
///
/// # Errors
/// The file cannot be written.
pub fn save_text(outcome: &Outcome, folder: &Folder) -> Result<(), Failure> {
    folder.write(REPORT, outcome.page.html(&spell).as_bytes())?;
    Ok(folder.commit()?)
}

/// Prints the notes, what is asked for of the first chart and the details, the answer and where the files are, and opens the page if
/// that is asked for.
///
/// # Errors
/// The output cannot be written.
pub fn show(outcome: &Outcome, places: &[String], printed: &Printed, folder: &Path) -> Result<(), Failure> {
    let facts = outcome.page.answer.text_of_facts(look::width());
    show_result(outcome, printed, facts.lines().count())?;
    show_facts(outcome, places, printed, folder)
}

/// Prints what [`show`] prints before the facts of the answer, for which it leaves room.
///
/// # Errors
/// The output cannot be written.
pub fn show_result(outcome: &Outcome, printed: &Printed, lines_of_facts: usize) -> Result<(), Failure> {
    let Outcome { page, heading, details, .. } = outcome;
    if printed.quiet {
        let headline = &page.answer.headline;
        return if headline.is_empty() { Ok(()) } else { print(headline) };
    }
    let width = look::width();
    let text = format!("{}\n{}", look::wrapped(heading, width), page.answer.text_without_facts(width));
    let notes = page.all_notes();
    let room = MAX_LINES.saturating_sub(text.lines().count() + 1 + lines_of_facts).max(MIN_NOTES);
    let few = if printed.verbose { notes.len() } else { room };
    notes.iter().take(few).for_each(|note| note!("{}", in_options(note)));
    if notes.len() > few {
        note!("{} more with --verbose", notes.len() - few);
    }
    if printed.plot {
        let first = page.figures().next();
        let plot = first.map_or_else(String::new, |drawn| drawn.picture.text(look::of_output()));
        print_drawn(&format!("{plot}\n"))?;
        print("")?;
    }
    let is_table = printed.table || printed.verbose;
    let details = Some(details.clone()).filter(|details| is_table && !details.is_empty());
    let has_sections = printed.verbose || is_table && details.is_none();
    let sections = has_sections.then(|| page.text(look::columns(), &spell));
    for part in [details, sections].into_iter().flatten() {
        print(&part)?;
        print("")?;
    }
    print(&text)
}

/// Prints the facts of the answer and where the files are, and opens the page if that is asked for.
///
/// # Errors
/// The output cannot be written.
pub fn show_facts(
    outcome: &Outcome,
    places: &[String],
    printed: &Printed,
    folder: &Path,
) -> Result<(), Failure> {
    if !printed.quiet {
        let facts = outcome.page.answer.text_of_facts(look::width());
        if !facts.is_empty() {
            print(&format!("\n{facts}"))?;
        }
        places.iter().for_each(|place| say!("{place}"));
        say!("report {}", folder.join(REPORT).display());
    }
    printed.open_page(folder);
    Ok(())
}

/// Writes a chart as `<stem>.svg` and `<stem>.png`.
///
/// # Errors
/// It cannot be drawn or written.
pub fn write_pictures(folder: &Folder, stem: &str, picture: &Picture) -> Result<(), Failure> {
    let png =
        picture.png(2.0).map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
    folder.write(&format!("{stem}.svg"), picture.svg().as_bytes())?;
    folder.write(&format!("{stem}.png"), &png)?;
    Ok(())
}

/// Whether a name is one of `own`: a file, with a star for any text, or without an ending the pictures of a chart.
fn matches(own: &str, name: &str) -> bool {
    let stem = || name.strip_suffix(".svg").or(name.strip_suffix(".png"));
    let Some(name) = (if own.contains('.') { Some(name) } else { stem() }) else { return false };
    match own.split_once('*') {
        Some((start, end)) => {
            name.len() >= start.len() + end.len() && name.starts_with(start) && name.ends_with(end)
        }
        None => own == name,
    }
}
