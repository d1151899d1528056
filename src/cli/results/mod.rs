//! The results of a study as files of its folder, as text and as JSON.

mod summary;

use std::path::Path;

use sagnac::run::{Done, Plan, Tables};
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::table::{Cell, Table};
use serde_json::{Value, json};

use super::Failure;
use super::charts::{draw, drawn, shown};
use super::look;
use super::output::{print, write};
use super::progress::{How, Shown, short};
use super::verdicts::{Verdict, verdicts};

/// The name of the study that a run writes beside its results.
pub const RESOLVED: &str = "resolved_study.toml";

/// The tables of a study with the names of their files.
pub fn files(tables: &Tables) -> impl Iterator<Item = (&'static str, &Table)> {
    let coefficients = tables.coefficients.as_ref().map(|table| ("coefficients.csv", table));
    let trajectories = tables.trajectories.as_ref().map(|table| ("trajectories.csv", table));
    std::iter::once(("points.csv", &tables.points)).chain(coefficients).chain(trajectories)
}

/// A table as the bytes of its file.
///
/// # Errors
/// None but of the memory that it is written to.
pub fn csv(table: &Table, path: &Path) -> Result<Vec<u8>, Failure> {
    let mut csv = Vec::new();
    table.write_csv(&mut csv).map_err(|source| Failure::Write { path: path.to_owned(), source })?;
    Ok(csv)
}

/// A study whose results are to be shown.
pub struct Results<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan<'a>,
    pub folder: &'a Path,
    /// What was sampled, and on which device, where anything can be.
    pub done: Option<(&'a Done, String)>,
    /// Trials that are missing of the whole.
    pub lacking: u64,
}

/// Where results go besides their files.
#[derive(Debug, Clone, Copy)]
pub struct Out {
    pub json: bool,
    pub quiet: bool,
    /// Whether the first chart is drawn as text too.
    pub plot: bool,
    pub progress: How,
}

impl Results<'_> {
    /// Writes the files of all that the store holds, prints what the options ask for, and returns the results as JSON where
    /// that is wanted.
    ///
    /// # Errors
    /// A row of the store is damaged, or a file cannot be written.
    pub fn show(&self, store: &Store, out: Out) -> Result<Option<Value>, Failure> {
        let Results { study, plan, folder, done, .. } = self;
        let tables = plan.tables(store, &Shown::new(out.progress))?;
        for (name, table) in files(&tables) {
            let path = folder.join(name);
            write(&path, &csv(table, &path)?)?;
        }
        write(&folder.join(RESOLVED), study.resolved(plan.held(store)?).as_bytes())?;
        let notes = draw(study, &tables, folder)?;
        let curves = shown(study, &tables)?;
        let verdicts = verdicts(study, &curves)?;
        let degraded = done.iter().flat_map(|(done, _)| done.degraded.clone());
        let uneven = if study.has_stop_rule() { None } else { uneven(&tables.points) };
        let notes: Vec<String> = degraded.chain(notes).chain(plan.notes(store)?).chain(uneven).collect();
        if out.json {
            return Ok(Some(self.to_json(&tables, &verdicts, &notes)));
        }
        if !out.quiet {
            for note in notes {
                say!("note: {note}");
            }
            if let Some(chart) = study.charts.first().filter(|_| out.plot) {
                let (drawn, _) = drawn(study, &tables, chart)?;
                print(&format!("{}\n", drawn.text(look::of_output())))?;
            }
            print(&summary::summary(study, &tables, &curves, &verdicts, self.lacking)?)?;
        }
        Ok(None)
    }

    fn to_json(&self, tables: &Tables, verdicts: &[Verdict], notes: &[String]) -> Value {
        let done = self.done.as_ref().map(|(done, _)| done);
        let sampled = self.plan.is_sampled().then_some(());
        let cell = |cell: &Cell| match cell {
            Cell::Blank => json!(null),
            Cell::Text(text) => json!(text),
            Cell::Integer(integer) => json!(integer),
            Cell::Number(number) => json!(number),
        };
        let rows = |table: &Table| -> Vec<Value> {
            let row = |row: usize| {
                table.columns.iter().map(|column| (column.header(), cell(&column.cells[row]))).collect()
            };
            (0..table.rows()).map(row).collect()
        };
        let mut document = json!({
            "title": self.study.title,
            "question": self.study.question,
            "seed": sampled.map(|_| self.study.seed),
            "trials": sampled.map(|_| self.study.trials),
            "device": self.done.as_ref().map(|(_, device)| device),
            "sampled_trials": done.map(|done| done.trials),
            "seconds": done.map(|done| done.seconds),
            "notes": notes,
            "verdicts": verdicts.iter().map(Verdict::json).collect::<Vec<_>>(),
            "points": rows(&tables.points),
        });
        if self.lacking > 0 {
            document["missing_trials"] = json!(self.lacking);
        }
        if let Some(coefficients) = &tables.coefficients {
            document["coefficients"] = json!(rows(coefficients));
        }
        document
    }
}

/// That rows are of different numbers of trials.
fn uneven(table: &Table) -> Option<String> {
    let column = table.columns.iter().find(|column| column.name == "trials")?;
    let trials = || column.cells.iter().filter_map(Cell::number);
    let (least, most) = (trials().reduce(f64::min)?, trials().reduce(f64::max)?);
    (least < most).then(|| format!("rows are from {} to {} trials", short(least), short(most)))
}
