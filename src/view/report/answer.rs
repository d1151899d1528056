//! The answer of a study to its question.

use crate::chart::Source;
use crate::kinds::navigation::keys::{ALIGNMENT, FILTER};
use crate::motion::keys::GYRO as SUSPENDED_GYRO;
use crate::noise::keys::{FILE as NOISE_FILE, INTERVAL};
use crate::quantity::number::short;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::table::{Column, ColumnError, Role, Table, Usual};
use crate::view::chart::stack::Shown;
use crate::view::picture::verdict::Verdict;
use crate::view::picture::{Drawn, refused};
use crate::view::report::bandless::Bandless;
use crate::view::report::headline::Resolved;
use crate::view::report::sentences::best;
use crate::view::report::standing::of_verdict;

/// Prefixes of keys that are conditions or requirements instead of choices of a designer.
const GIVEN: [&str; 14] = [
    "coefficient",
    "record.rate",
    "suspension.frequency",
    "run.",
    "motion.",
    "drift.",
    "noise.",
    "navigation.",
    "relock.adc_noise",
    "lock_in.threshold",
    "input.rate",
    "gyro.tick_noise",
    "gyro.readout_lsb",
    "switching.gap_ticks",
];

/// Keys of these between which a designer chooses: those that tell gyros or filters apart, the time of alignment, and the interval
/// between switches.
const CHOSEN: [&str; 5] = [SUSPENDED_GYRO.name, NOISE_FILE.name, FILTER.name, ALIGNMENT.name, INTERVAL.name];

/// Whether a column is a condition or a requirement instead of a choice.
pub(crate) fn is_given(column: &Column) -> bool {
    let key = if column.of.is_empty() { &column.name } else { &column.of };
    !CHOSEN.contains(&key.as_str()) && GIVEN.iter().any(|given| key.starts_with(given))
}

/// The answer as a sentence, with its details.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Answer {
    /// One sentence; empty where there is nothing to say, as for a table without a value.
    pub headline: String,
    /// A heading for each chart with this kind of answer, with a sentence for each curve: its verdict, or its minimum.
    pub curves: Vec<(String, Vec<String>)>,
    /// The lines of the decision sheet, each with its heading; empty where there is none.
    pub sheet: Vec<(&'static str, String)>,
}

impl Answer {
    /// The answer of a study: the verdicts if there are any, else the content of the first chart, else the best row of
    /// the `points`. It states first how many trials are `lacking`.
    ///
    /// # Errors
    /// The table lacks something that a chart requires.
    pub(crate) fn of(
        study: &Study,
        points: &Table,
        charts: &[Drawn],
        shown: &[Shown],
        verdicts: &[Verdict],
        lacking: u64,
    ) -> Result<Answer, StudyError> {
        let refuse = |chart, error: ColumnError| refused(study, chart, &error.into());
        let charts = study.charts.iter().zip(shown).zip(charts).map(|((chart, shown), drawn)| {
            Resolved::of(study, chart, shown, drawn).map_err(|error| refuse(chart, error))
        });
        let charts = charts.collect::<Result<Vec<_>, _>>()?;
        let asked = || charts.iter().filter(|resolved| study.is_judged_by(resolved.chart));
        let is_judged = |resolved: &&Resolved| resolved.chart.limit.is_some() && resolved.has_curves();
        let judged = asked().find(is_judged);
        // Where records show a coefficient is what a study of records asks first.
        let shows = |resolved: &&Resolved| resolved.estimate.role == Role::Fraction && resolved.has_curves();
        let first = asked().find(shows).or_else(|| asked().next());
        let verdict_of =
            |resolved: &Resolved| verdicts.iter().find(|verdict| verdict.is_of(&resolved.drawn.stem));
        let headline = match (judged.and_then(|judged| verdict_of(judged).zip(Some(judged))), first) {
            (Some((first, resolved)), _) => {
                let told = resolved.judged(first).map_err(|error| refuse(resolved.chart, error))?;
                // Charts of the same curves under other conditions answer the same question.
                let judged = asked().filter(is_judged).filter(|other| resolved.is_continued_by(other));
                let further = judged
                    .filter_map(verdict_of)
                    .filter_map(|verdict| of_verdict(&verdict.answers, verdict.limit));
                let further: Vec<String> = further.collect();
                let told = told.map(|told| [&[told], &further[..]].concat().join(" "));
                if further.is_empty() { resolved.with_conditions(told) } else { told }
            }
            (None, Some(resolved)) if !resolved.shown.is_supplied(resolved.chart) => {
                let told = resolved.of_picture().map_err(|error| refuse(resolved.chart, error))?;
                resolved.with_conditions(told)
            }
            _ => undrawn(study, points),
        };
        let mut curves: Vec<(String, Vec<String>)> =
            verdicts.iter().map(|verdict| (verdict.heading(), verdict.sentences())).collect();
        // The least over what is given, as over the run time, is nobody's choice.
        let has_minima = |resolved: &&Resolved| {
            let is_asked = resolved.is_environment() || !is_given(resolved.x);
            resolved.has_curves() && resolved.chart.limit.is_none() && is_asked
        };
        for resolved in charts.iter().filter(has_minima) {
            let is_largest = resolved.is_environment();
            let each = resolved.curves().map_or(vec![], |curves| curves.of_each(is_largest));
            if !each.is_empty() {
                let which = if is_largest { "largest" } else { "least" };
                let Drawn { stem, picture, .. } = resolved.drawn;
                curves.push((format!("{stem}: the {which} {} of each curve", picture.shown().label), each));
            }
        }
        let headline = match (headline, lacking) {
            (headline, 0) => headline.unwrap_or_default(),
            (headline, lacking) => {
                let so_far = headline.map_or(String::new(), |headline| format!(" So far: {headline}"));
                format!("Incomplete, {} trials are missing.{so_far}", short(lacking as f64))
            }
        };
        Ok(Answer { headline, curves, sheet: vec![] })
    }
}

/// The best row, and where that has a filler that firmware cannot have, the best of the others.
pub(super) fn leading(
    study: &Study,
    table: &Table,
    estimate: &Column,
    rows: &[usize],
    by: &[&Column],
) -> Option<String> {
    let first = best(table, estimate, rows, by)?;
    let sentence = first.sentence();
    let Some((row, Bandless { column, names, why })) = first.row.zip(Bandless::of(study, table)) else {
        return Some(sentence);
    };
    let is_bandless = |row: usize| names.contains(&column.cells[row].text().as_str());
    if !is_bandless(row) {
        return Some(sentence);
    }
    let others: Vec<usize> = rows.iter().copied().filter(|&row| !is_bandless(row)).collect();
    let aim = format!("designed for {why}, which firmware does not know");
    Some(match best(table, estimate, &others, by) {
        Some(second) => format!(
            "{} Fillers that are {aim}, are left out; the least of them is {}.",
            second.sentence(),
            first.value
        ),
        None => format!("{sentence} That filler is {aim}."),
    })
}

/// The best row of a study without its own chart.
fn undrawn(study: &Study, points: &Table) -> Option<String> {
    let estimate = points.usual(Usual::Answer)?;
    // Errors and angles that the study omits have no rows.
    let filter = Some(study.usual_rows()).filter(|rows| points.rows_where(rows).is_ok()).unwrap_or_default();
    let rows = points.rows_where(&filter).ok()?;
    // Every study of the kind has the columns.
    let abscissa = points.usual(Usual::Abscissa).into_iter().collect();
    let by = apart(study, Source::Points, points, abscissa).ok()?;
    leading(study, points, estimate, &rows, &by)
}

/// The columns that distinguish rows, each once, after some `columns`.
pub(crate) fn apart<'t>(
    study: &Study,
    source: Source,
    table: &'t Table,
    mut columns: Vec<&'t Column>,
) -> Result<Vec<&'t Column>, ColumnError> {
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    for name in study.text_columns(source).into_iter().chain(sweeps) {
        if columns.iter().all(|column| column.name != name) {
            columns.push(table.column(name)?);
        }
    }
    Ok(columns)
}
