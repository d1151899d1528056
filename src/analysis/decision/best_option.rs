//! The best option of a study, the condition under which it is worst, and the rows that count for it.

use crate::analysis::question::{Choice, Notches, Question, Rank, apart, sort_best_first, usual_filter};
use sagnac_base::table::{Cell, Column, ColumnError, Role, Table, Usual};
use sagnac_engine::chart::{Chart, Limit, Source};
use sagnac_engine::kinds::allan::LENGTH;
use sagnac_engine::run::Tables;
use sagnac_engine::study::Study;
use sagnac_report::answer::Reading;
use sagnac_report::answer::reading::place as place_of;

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
pub(crate) struct BestOption<'t> {
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

impl<'t> BestOption<'t> {
    /// The choice among the points of a study. `None` where no estimate can be judged, or no row has a value.
    ///
    /// # Errors
    /// The table lacks a column that a chart requires.
    pub(crate) fn new(study: &Study, tables: &'t Tables) -> Result<Option<BestOption<'t>>, ColumnError> {
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
        let by = apart(study, source, table)?;
        let question = Question::new(study, table, abscissa, column, by, rows, limit);
        let mut choices = question.under_conditions();
        let mut left_out = vec![];
        if let (Some(unusable), true) = (&question.unusable, choices.iter().any(|choice| choice.is_usable)) {
            let all = choices.len();
            choices.retain(|choice| choice.is_usable);
            let names = unusable.names.iter().filter(|_| choices.len() < all);
            left_out.extend(names.map(|name| (*name).to_owned()));
        }
        let notches = abscissa.map_or_else(Notches::default, |x| {
            let curves = choices.iter().flat_map(|choice| choice.rows.iter().map(Vec::as_slice));
            Notches::new(x, column, curves)
        });
        // A coefficient that records do not show has no error, and meets no limit.
        let value = |row: usize| column.magnitude(row);
        let by_value = |a: &usize, b: &usize| value(*a).total_cmp(&value(*b));
        let is_met = |row: usize| limit.is_none_or(|limit| value(row) <= limit.value);
        // A curve over the averaging time counts at its minimum, notches left out.
        let is_notch = |row: usize| abscissa.is_some_and(|x| notches.are_at(x.value(row)));
        let least = |rows: &Vec<usize>| rows.iter().copied().filter(|&row| !is_notch(row)).min_by(by_value);
        let rated = |choice: &Choice| {
            let rows: Vec<usize> = choice.rows.iter().filter_map(least).collect();
            let row = rows.iter().copied().max_by(by_value)?;
            let met = rows.iter().filter(|row| is_met(**row)).count();
            Some(Rated { name: place_of(&question.options, row), row, met, rows })
        };
        let mut options: Vec<Rated> = choices.iter().filter_map(rated).collect();
        // Of records that meet the limit equally often, the shortest is the best: a longer one costs time.
        let length = match question.options[..] {
            [column] if column.name == LENGTH.name && limit.is_some() => Some(column),
            _ => None,
        };
        sort_best_first(&mut options, |&Rated { row, met, .. }| {
            let cost = length.filter(|_| met > 0).map_or_else(|| value(row), |length| length.value(row));
            Rank { is_usable: true, met, cost }
        });
        let Some(Rated { name, row, met, rows }) = options.first().cloned() else { return Ok(None) };
        let (point, row_of_point) = place(study, table, row);
        let at: Vec<&Column> = question.conditions.iter().copied().chain(abscissa).collect();
        let condition = place_of(&at, row);
        let (option, options, is_minimum) = (name, options.len(), abscissa.is_some());
        let met = [met, rows.len()];
        Ok(Some(BestOption {
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
