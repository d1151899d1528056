//! The best option of a study, the condition under which it is worst, and the rows that count for it; the part that a column, and
//! each filler, plays in the question.

use crate::analysis::notch::Notches;
use sagnac_base::table::{Cell, Column, ColumnError, Role, Table, Usual, grouped};
use sagnac_engine::chart::{Chart, Limit, Source};
use sagnac_engine::filler::FILLERS;
use sagnac_engine::kinds::KINDS;
use sagnac_engine::kinds::allan::LENGTH;
use sagnac_engine::kinds::allan::columns::COEFFICIENT;
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::columns::{Tuning, tuned};
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::run::Tables;
use sagnac_engine::study::Study;
use sagnac_report::answer::Reading;
use sagnac_report::answer::reading::{naming, place as place_of};

/// An option with its worst row.
#[derive(Debug, Clone)]
struct Rated {
    name: String,
    row: usize,
    met: usize,
    rows: Vec<usize>,
}

/// The best of the options that a study compares: the one that meets the limit under most conditions, and of these the
/// one whose largest value over all conditions is the least.
#[derive(Debug, Clone)]
pub(crate) struct Choice<'t> {
    /// The table of the judged estimate.
    pub(crate) source: Source,
    /// The judged estimate.
    pub(crate) column: &'t Column,
    pub(crate) limit: Option<Limit>,
    /// The row of the best option under the condition where it is worst.
    pub(crate) row: usize,
    /// Place of that row among those of its point.
    pub(crate) row_of_point: usize,
    /// The point of that row.
    pub(crate) point: usize,
    /// The rows of the best option under all conditions.
    pub(crate) rows: Vec<usize>,
    /// Name of the best option; empty where there is only one.
    pub(crate) option: String,
    /// The condition under which it is worst; empty where there is only one.
    pub(crate) condition: String,
    /// Whether a condition has a whole curve over the averaging time, which counts at its minimum.
    pub(crate) is_minimum: bool,
    /// Whether notches interrupt the curves.
    pub(crate) is_notched: bool,
    /// Number of conditions under which it is within the limit, and of all conditions.
    pub(crate) met: [usize; 2],
    /// Number of options.
    pub(crate) options: usize,
    /// Names of fillers that do not count as options, because firmware cannot have them.
    pub(crate) left_out: Vec<String>,
}

impl<'t> Choice<'t> {
    /// The choice among the points of a study. `None` where no estimate can be judged, or no row has a value.
    ///
    /// # Errors
    /// The table lacks a column that a chart requires.
    pub(crate) fn new(study: &Study, tables: &'t Tables) -> Result<Option<Choice<'t>>, ColumnError> {
        let Some(Judged { source, table, column, limit, filter }) = judged(study, tables)? else {
            return Ok(None);
        };
        let mut rows = table.rows_where(&filter).unwrap_or_default();
        // A coefficient that no record of any point shows is none of the gyro's.
        let has_value = |row: usize| column.cells[row].number().is_some();
        match source {
            Source::Coefficients => {
                let name = |row: usize| text_of(study, source, table, row);
                let known: Vec<_> =
                    rows.iter().filter(|row| has_value(**row)).map(|row| name(*row)).collect();
                rows.retain(|&row| has_value(row) || known.contains(&name(row)));
            }
            _ => rows.retain(|&row| has_value(row)),
        }
        let abscissa = table.usual(Usual::Abscissa).filter(|_| table.usual(Usual::Places).is_none());
        // Where each point has a single averaging time, there is no curve.
        let abscissa = abscissa.filter(|_| rows.iter().any(|&row| place(study, table, row).1 > 0));
        let by = apart(study, source, table, vec![])?;
        let by: Vec<&Column> =
            by.into_iter().filter(|by| rows.iter().any(|&row| by.cells[row] != by.cells[rows[0]])).collect();
        let (given, chosen): (Vec<&Column>, Vec<&Column>) = by.into_iter().partition(|by| is_given(by));
        let bandless = Bandless::new(study, table);
        let is_known = |row: usize| bandless.as_ref().is_some_and(|bandless| bandless.has(row));
        let left_out: Vec<String> = match rows.iter().all(|&row| is_known(row)) {
            true => vec![],
            false => {
                let all = rows.clone();
                rows.retain(|&row| !is_known(row));
                let names = bandless.iter().flat_map(|bandless| bandless.names.iter().copied());
                names.filter(|_| all.len() > rows.len()).map(str::to_owned).collect()
            }
        };
        let (condition_of, option_of) = (naming(&given), naming(&chosen));
        let notches = abscissa.map_or_else(Notches::default, |x| {
            let curves = grouped(rows.iter().copied(), |row| (option_of(row), condition_of(row)));
            Notches::new(x, column, curves.iter().map(|(_, rows)| &rows[..]))
        });
        // A coefficient that records do not show has no error, and meets no limit.
        let value = |row: usize| column.magnitude(row);
        let by_value = |a: &usize, b: &usize| value(*a).total_cmp(&value(*b));
        let is_met = |row: usize| limit.is_none_or(|limit| value(row) <= limit.value);
        // A curve over the averaging time counts at its minimum, notches left out.
        let is_notch = |row: usize| abscissa.is_some_and(|x| notches.are_at(x.value(row)));
        let least =
            |(_, rows): (_, Vec<usize>)| rows.into_iter().filter(|&row| !is_notch(row)).min_by(by_value);
        let option = |(name, rows): (String, Vec<usize>)| {
            let rows: Vec<usize> = grouped(rows, &condition_of).into_iter().filter_map(least).collect();
            let row = rows.iter().copied().max_by(by_value)?;
            let met = rows.iter().filter(|row| is_met(**row)).count();
            Some(Rated { name, row, met, rows })
        };
        let options = grouped(rows, &option_of);
        let mut options: Vec<Rated> = options.into_iter().filter_map(option).collect();
        // Of records that meet the limit equally often, the shortest is the best: a longer one costs time.
        let length = match chosen[..] {
            [column] if column.name == LENGTH.name && limit.is_some() => Some(column),
            _ => None,
        };
        let cost = |option: &Rated| match length {
            Some(length) if option.met > 0 => length.value(option.row),
            _ => value(option.row),
        };
        options.sort_by(|a, b| b.met.cmp(&a.met).then(cost(a).total_cmp(&cost(b))));
        let Some(Rated { name, row, met, rows }) = options.first().cloned() else { return Ok(None) };
        let (point, row_of_point) = place(study, table, row);
        let at: Vec<&Column> = given.iter().copied().chain(abscissa).collect();
        let condition = place_of(&at, row);
        let (option, options, is_minimum) = (name, options.len(), abscissa.is_some());
        let met = [met, rows.len()];
        Ok(Some(Choice {
            source,
            column,
            limit,
            row,
            row_of_point,
            point,
            rows,
            option,
            condition,
            is_minimum,
            is_notched: notches.are_any(),
            met,
            options,
            left_out,
        }))
    }

    /// The value of the best option with its interval.
    pub(crate) fn reading(&self) -> Reading {
        Reading::new(self.column, self.value(), self.interval())
    }

    /// The magnitude of the best option.
    pub(crate) fn value(&self) -> f64 {
        self.column.magnitude(self.row)
    }

    /// The 95 % interval of that magnitude.
    pub(crate) fn interval(&self) -> Option<(f64, f64)> {
        self.column.interval_of_magnitude(self.row)
    }
}

/// The texts that distinguish rows of a point.
fn text_of(study: &Study, source: Source, table: &Table, row: usize) -> Vec<String> {
    let texts = study.text_columns(source).into_iter();
    texts.filter_map(|name| Some(table.column(name).ok()?.cells[row].text())).collect()
}

/// What a study judges.
struct Judged<'t> {
    source: Source,
    table: &'t Table,
    column: &'t Column,
    limit: Option<Limit>,
    /// Rows to which it applies, as pairs of a column and its value in files.
    filter: Vec<(String, String)>,
}

/// The judged estimate: that of the requirement, else of the first chart of an error with a limit, else of the first chart
/// of an error, else the default one where the study has no charts of its own.
fn judged<'t>(study: &Study, tables: &'t Tables) -> Result<Option<Judged<'t>>, ColumnError> {
    let of = |source: Source, name: &str, limit, filter: Option<Vec<(String, String)>>| {
        let table = tables.of(source);
        let filter = filter.unwrap_or_else(|| usual_filter(study, table));
        let filter = with_whole(study, source, filter);
        Ok(Judged { source, table, column: table.column(name)?, limit, filter })
    };
    if let Some(required) = study.requirement {
        return of(required.source, required.column, Some(required.limit), None).map(Some);
    }
    // A supplied chart of names side by side shows more than what is judged.
    let is_own = |chart: &&Chart| {
        let has_x =
            !chart.x.span.is_empty() || study.sweeps.iter().any(|sweep| sweep.key.name == chart.x.name);
        has_x && chart.source != Source::Trajectories && study.is_judged_by(chart)
    };
    let judges = |chart: &&Chart| {
        let column = tables.of(chart.source).column(&chart.estimate().name);
        column.is_ok_and(|column| column.role.less_is_better() || chart.limit.is_some())
    };
    let own = || study.charts.iter().filter(is_own);
    let charts = || own().filter(judges);
    if let Some(chart) = charts().find(|chart| chart.limit.is_some()).or_else(|| charts().next()) {
        return of(chart.source, &chart.estimate().name, chart.limit, Some(chart.filter())).map(Some);
    }
    // A study whose first chart asks for something else is not judged by an error that it has besides.
    let asks = |chart: &Chart| {
        let column = tables.of(chart.source).column(&chart.estimate().name);
        !chart.x.span.is_empty() && column.is_ok_and(|column| column.role == Role::Estimate)
    };
    if own().next().is_some_and(asks) {
        return Ok(None);
    }
    let mut usual =
        [Usual::Answer, Usual::Estimate].into_iter().filter_map(|usual| tables.points.usual(usual));
    let usual = usual.find(|column| column.role.less_is_better());
    usual.map(|column| of(Source::Points, &column.name, None, None)).transpose()
}

/// The filter of the usual rows of a study; an empty one where the study omits them.
pub(crate) fn usual_filter(study: &Study, table: &Table) -> Vec<(String, String)> {
    Some(study.usual_rows()).filter(|rows| table.rows_where(rows).is_ok()).unwrap_or_default()
}

/// A filter that selects the value of a text column that stands for all others, unless it selects one already.
fn with_whole(study: &Study, source: Source, mut filter: Vec<(String, String)>) -> Vec<(String, String)> {
    for text in study.ground(source).map(|ground| ground.texts).unwrap_or_default() {
        let whole = text.whole.filter(|_| filter.iter().all(|(name, _)| name != text.name));
        filter.extend(whole.map(|whole| (text.name.to_owned(), whole.to_owned())));
    }
    filter
}

/// The point of a row, and the place of the row among those of its point. The rows of a point follow one another, and
/// have the same swept values.
fn place(study: &Study, table: &Table, row: usize) -> (usize, usize) {
    let swept: Vec<&Column> =
        study.sweeps.iter().filter_map(|sweep| table.column(sweep.key.name).ok()).collect();
    let values = |row: usize| swept.iter().map(|column| &column.cells[row]).collect::<Vec<&Cell>>();
    let starts: Vec<usize> = (0..=row).filter(|&row| row == 0 || values(row) != values(row - 1)).collect();
    (starts.len() - 1, row - starts.last().copied().unwrap_or(0))
}

/// Whether a column is a condition instead of a choice: that of a key by its role, of others the names of coefficients.
pub(crate) fn is_given(column: &Column) -> bool {
    let name = if column.of.is_empty() { &column.name } else { &column.of };
    let keys = KINDS.iter().flat_map(|kind| (kind.keys)().into_iter().chain((kind.sweepable)()));
    keys.into_iter()
        .find(|key| key.name == *name)
        .map_or_else(|| name.starts_with(COEFFICIENT), |key| key.role.is_given())
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

/// Whether less of an estimate is better in all selected rows: its role says so, and none of its values is negative.
pub(crate) fn less_is_better(table: &Table, column: &Column, rows: &[usize]) -> bool {
    let estimate = if column.role == Role::Theory { table.referred(column) } else { Some(column) };
    let signed = rows.iter().any(|&row| column.value(row) < 0.0);
    estimate.is_some_and(|column| column.role.less_is_better()) && !signed
}

/// The fillers that are designed without a band, whose weights firmware cannot have: they follow the motion of each
/// point, or one motion to the last digit. For a motion that is drawn from a band, they are those of the band.
pub(crate) struct Bandless<'a> {
    /// The column of all fillers.
    pub(crate) column: &'a Column,
    pub(crate) names: Vec<&'a str>,
    /// What they are designed for.
    pub(crate) why: &'static str,
}

impl<'a> Bandless<'a> {
    pub(crate) fn new(study: &'a Study, table: &'a Table) -> Option<Bandless<'a>> {
        let column = table.listed_by(FILLERS)?;
        let fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref())?;
        let (tuning, names) = tuned(study, fill)?;
        let why = match tuning {
            Tuning::Points => "the very motion of each point",
            Tuning::Frequency => "exactly this motion",
        };
        Some(Bandless { column, names, why })
    }

    /// Whether a row has one of them.
    pub(crate) fn has(&self, row: usize) -> bool {
        self.names.contains(&self.column.cells[row].text().as_str())
    }
}
