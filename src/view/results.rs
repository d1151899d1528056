//! The results of a study as a whole: tables, charts, notes and the report.

use crate::answer::Answer;
use crate::quantity::number::short;
use crate::run::{Plan, Tables};
use crate::source::diagnose::StudyError;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::study::Study;
use crate::table::{Cell, Role, Table};
use crate::view::chart::stack::Shown;
use crate::view::picture::{Drawn, incomplete, pictures, shown};
use crate::view::report::Report;
use crate::view::report::gallery::Card;
use crate::view::report::source::Source;
use crate::view::report::still::still;

/// The results of a study that a store holds.
pub struct Results<'a> {
    study: &'a Study,
    tables: &'a Tables,
    /// Number of missing trials.
    pub lacking: u64,
    /// Charts, in the order of the study.
    pub charts: Vec<Drawn>,
    /// The part of a table that each chart shows.
    pub curves: Vec<Shown<'a>>,
    notes: Vec<String>,
    source: Source,
}

impl<'a> Results<'a> {
    /// The results from `tables`, which the plan made from the store. `degraded` lists the deviations of a run from the
    /// requested execution.
    ///
    /// # Errors
    /// The table lacks something that a chart requires, a row of the store is damaged, or the disk fails.
    pub fn of<E: From<StudyError> + From<StoreError>>(
        study: &'a Study,
        plan: &Plan,
        store: &Store,
        tables: &'a Tables,
        lacking: u64,
        degraded: &[String],
    ) -> Result<Results<'a>, E> {
        let of_store = || {
            let index = store.index()?;
            let held = plan.held(&index)?;
            let uneven = if study.precision.is_some() { None } else { uneven(&tables.points) };
            let notes = incomplete(lacking).into_iter().chain(degraded.iter().cloned());
            let notes = notes.chain(plan.notes(store, &index, held)?).chain(uneven).collect();
            Ok::<(Vec<String>, Source), StoreError>((notes, Source::of(study, plan, store, held, lacking)?))
        };
        // Both take long for a long table.
        let (mut charts, mut curves) = (Ok(vec![]), Ok(vec![]));
        let found = rayon::in_place_scope(|scope| {
            scope.spawn(|_| charts = pictures(study, tables, lacking));
            scope.spawn(|_| curves = shown(study, tables));
            of_store()
        });
        let (charts, curves) = (charts?, curves?);
        let (notes, source) = found?;
        Ok(Results { study, tables, lacking, charts, curves, notes, source })
    }

    /// The study that reproduces the run.
    pub fn resolved(&self) -> &str {
        &self.source.study
    }

    /// Notes attached to the results, each a sentence and once, with those on charts first.
    pub fn notes(&self) -> Vec<String> {
        let mut of_charts: Vec<(&str, String)> = Vec::new();
        for drawn in &self.charts {
            let Some(note) = &drawn.note else { continue };
            match of_charts.iter_mut().find(|(earlier, _)| earlier == note) {
                Some((_, stems)) => *stems += &format!(", {}", drawn.stem),
                None => of_charts.push((note, drawn.stem.clone())),
            }
        }
        let of_charts = of_charts.into_iter().map(|(note, stems)| format!("{stems}: {note}"));
        of_charts.chain(self.notes.iter().cloned()).collect()
    }

    /// The card of the study in galleries.
    pub fn card(&self, headline: &str) -> Card {
        let picture = self.charts.first().map(|drawn| still(&drawn.picture));
        let (title, question) = (self.study.title.clone(), self.study.question.clone());
        Card { title, question, headline: headline.to_owned(), picture, ..Card::default() }
    }

    /// The page of the study, with the SHA-256 of its points that [`Table::write_csv`] returned.
    pub fn page(&self, answer: &Answer, digest: &str) -> String {
        let report = Report {
            title: &self.study.title,
            question: &self.study.question,
            answer,
            notes: &self.notes,
            charts: &self.charts,
            tables: self.tables.as_charted(&self.study.charts),
            source: &self.source,
            digest,
        };
        report.html()
    }
}

/// A note that rows have different numbers of trials.
fn uneven(table: &Table) -> Option<String> {
    let column = table.of_role(Role::Trials)?;
    let trials = || column.cells.iter().filter_map(Cell::number);
    let (least, most) = (trials().reduce(f64::min)?, trials().reduce(f64::max)?);
    (least < most).then(|| format!("rows are from {} to {} trials", short(least), short(most)))
}
