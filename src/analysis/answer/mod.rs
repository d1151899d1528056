//! The answer of a study: from the chart that asks its question, else from its points.
//!
//! The rows of the table are the options between which a designer chooses, its columns the conditions. Which of them a column
//! of the study is, its key says.

mod limits;
mod options;

use crate::analysis::decision::Sheet;
use crate::analysis::page;
use crate::analysis::question::{Bandless, Question, apart, is_given, less_is_better, usual_filter};
use crate::view::Shown;
use crate::view::from_table::axis_unit;
use crate::view::{Drawn, refused};
use sagnac_base::diagnostics::{StudyError, listed};
use sagnac_base::table::{Cell, Column, ColumnError, Role, Table, Usual, between, crossing_fraction};
use sagnac_engine::chart::{Chart, Limit, Source};
use sagnac_engine::run::Tables;
use sagnac_engine::study::Study;
use sagnac_report::answer::reading::{begun, joined, place, shown, symbol};
use sagnac_report::answer::{
    Answer, AnswerCell, AnswerTable, Fact, Kind, MAX_COLUMNS, MAX_ROWS, Reading, Status,
};
use sagnac_report::chart::Picture;
use sagnac_report::chart::figure::{Mark, Shape};

/// An answer without facts and checks.
#[derive(Default)]
pub(super) struct Outline {
    pub(super) kind: Kind,
    pub(super) headline: String,
    pub(super) value: Option<Reading>,
    pub(super) table: AnswerTable,
    /// Places on curves that the table or the headline names.
    pub(super) marks: Vec<Named>,
    /// Points within the limit, and all of them, where that is what the answer is about.
    pub(super) met: Option<[usize; 2]>,
    /// The row of the headline's value, where it is that of a row.
    pub(super) row: Option<usize>,
}

/// A place on a curve that an answer names.
pub(super) struct Named {
    /// The rows of the curve by rising x.
    pub(super) rows: Vec<usize>,
    pub(super) x: f64,
    /// The value there where it is known; else it is that of the curve.
    pub(super) y: Option<f64>,
    pub(super) shape: Shape,
    pub(super) label: String,
    /// Values of x around it that are as good.
    pub(super) range: Option<[f64; 2]>,
}

impl Named {
    /// A place on a curve of some rows.
    pub(super) fn at(rows: &[usize], x: f64, shape: Shape, label: String) -> Named {
        Named { rows: rows.to_vec(), x, y: None, shape, label, range: None }
    }
}

/// A row of the table before equal ones are joined.
pub(in crate::analysis) struct Line {
    pub(super) name: String,
    pub(super) is_usable: bool,
    pub(super) cells: Vec<AnswerCell>,
}

/// The answer of a study, with the facts of its decision; its values are marked on the charts from which they are.
///
/// # Errors
/// The table lacks something that a chart requires.
pub(crate) fn of_study(
    study: &Study,
    tables: &Tables,
    drawn: &mut [Drawn],
    curves: &[Shown],
    lacking: u64,
    decided: Option<&Sheet>,
) -> Result<Answer, StudyError> {
    let charts = || {
        let all = study.charts.iter().zip(curves).zip(drawn.iter().enumerate());
        all.filter(|((chart, _), _)| study.is_judged_by(chart))
    };
    let has_curves = |(_, drawn): &(usize, &Drawn)| matches!(drawn.picture, Picture::Curves(_));
    let mut marks: Vec<(usize, Vec<Mark>)> = vec![];
    let role = |curves: &Shown| curves.table.column(&curves.estimate).map(|column| column.role);
    // Where records show a coefficient is what a study of records asks first.
    let asked = charts()
        .find(|((chart, _), drawn)| chart.limit.is_some() && has_curves(drawn))
        .or_else(|| {
            charts().find(|((_, curves), drawn)| role(curves) == Ok(Role::Fraction) && has_curves(drawn))
        })
        .or_else(|| charts().next());
    let (mut outline, limit) = match asked {
        Some(((chart, curves), (at, drawn))) if !curves.is_supplied(chart) || chart.limit.is_some() => {
            let outline = match &drawn.picture {
                Picture::Map(found) => limits::of_map(found),
                Picture::Curves(figure) => {
                    let (outline, found) = Question::answered(study, chart, curves, &figure.x.names)?;
                    marks.push((at, found));
                    outline
                }
            };
            (outline, chart.limit)
        }
        _ => {
            let question = Question::of_points(study, &tables.points, decided);
            let outline = question.as_ref().and_then(|question| question.outline(study));
            if let (Some(((chart, _), (at, drawn))), Some(question), Some(outline)) =
                (asked, question, &outline)
                && let Picture::Curves(figure) = &drawn.picture
            {
                marks.push((at, question.marks(chart, outline, &figure.x.names)));
            }
            (outline, None)
        }
    };
    let continued = charts().filter(|((chart, _), drawn)| chart.limit.is_some() && has_curves(drawn));
    if let Some(outline) = &mut outline
        && let [line] = &outline.table.rows[..]
        && line[0].text.is_empty()
    {
        let found = continued.map(|((chart, curves), (at, _))| {
            let (outline, found) = Question::answered(study, chart, curves, &[])?;
            marks.push((at, found));
            Ok((chart, curves, outline))
        });
        outline.continue_with(&found.collect::<Result<Vec<_>, StudyError>>()?);
    }
    let limit = limit.or(decided.and_then(|sheet| sheet.limit));
    let outline = outline.unwrap_or_default();
    for (at, marks) in marks {
        if let Picture::Curves(figure) = &mut drawn[at].picture {
            figure.marks = marks;
        }
    }
    let limit = limit.map(reading_of_limit);
    let judged = decided.map_or(Status::NoLimit, Sheet::status);
    let status = match outline.met {
        // The sheet judges the best point of each curve alone.
        Some([met, of]) if judged != Status::NoLimit && 0 < met && met < of => Status::PartlyMet { met, of },
        _ => judged,
    };
    let answer = Answer {
        kind: outline.kind,
        status: if lacking > 0 { Status::Incomplete { missing: lacking } } else { status },
        headline: outline.headline,
        value: outline.value,
        limit,
        table: outline.table.without_blanks(),
        facts: vec![],
        checks: page::agreement(&tables.points).into_iter().collect(),
    };
    Ok(Answer { facts: facts(study, tables, decided, &answer), ..answer })
}

/// Removes the worst case; an error budget then names its condition itself.
fn without_worst_case(facts: &mut Vec<Fact>) {
    let place = facts.iter().position(|fact| matches!(fact, Fact::WorstCase { .. }));
    if let Some(Fact::WorstCase { at: condition, .. }) = place.map(|place| facts.remove(place)) {
        for fact in facts {
            if let Fact::ErrorBudget { at, .. } = fact {
                at.clone_from(&condition);
            }
        }
    }
}

impl Outline {
    /// Gives an answer of a single curve a row for each of several charts of such a curve, under other conditions.
    fn continue_with(&mut self, charts: &[(&Chart, &Shown, Option<Outline>)]) {
        let limits = || charts.iter().map(|(chart, ..)| chart.limit);
        let differ = limits().any(|limit| Some(limit) != limits().next());
        let name = |chart: &Chart, curves: &Shown| {
            let value = |(column, value): (String, String)| {
                let column = curves.table.column(&column).ok()?;
                Some(shown(column, &Cell::Text(value.clone())))
            };
            let of_rows = chart.filter().into_iter().filter_map(value);
            let limit = chart.limit.filter(|_| differ).map(|limit| format!("limit {}", limit.text()));
            of_rows.chain(limit).collect::<Vec<_>>().join(", ")
        };
        let row = |(chart, curves, outline): &(&Chart, &Shown, Option<Outline>)| {
            let table = &outline.as_ref()?.table;
            let [row] = &table.rows[..] else { return None };
            let mut row = row.clone();
            row[0].text = name(chart, curves);
            (table.columns == self.table.columns && row.len() == self.table.columns.len()).then_some(row)
        };
        let rows: Vec<Vec<AnswerCell>> = charts.iter().filter_map(row).collect();
        if let [first, _, ..] = &rows[..] {
            let name = first[0].text.split(", limit").next().unwrap_or_default();
            self.headline = headline(name, &uncapitalized(&self.headline));
            if let Some((chart, curves, _)) = charts.first() {
                let column =
                    |(name, _): (String, String)| Some(curves.table.column(&name).ok()?.label.clone());
                self.table.columns[0] =
                    chart.filter().into_iter().filter_map(column).collect::<Vec<_>>().join(", ");
            }
            self.table.rows = rows;
        }
    }
}

/// A headline as what follows a name.
fn uncapitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// A limit in the unit in which it is shown.
pub(in crate::analysis) fn reading_of_limit(limit: Limit) -> Reading {
    let (name, unit) = ("limit".to_owned(), limit.unit);
    Reading::new(&Column { name, unit, role: Role::Error, ..Column::default() }, limit.value, None)
}

/// The facts of a decision beside an answer; without a decision, on fillers that firmware cannot have.
pub(crate) fn facts(study: &Study, tables: &Tables, decided: Option<&Sheet>, answer: &Answer) -> Vec<Fact> {
    let Some(sheet) = decided else {
        let unusable = Bandless::new(study, &tables.points);
        let caveat = |Bandless { names, why, .. }: Bandless| {
            Fact::caveat(format!("{}: designed for {why}", listed(&names)))
        };
        return unusable.map(caveat).into_iter().collect();
    };
    let mut facts = sheet.facts();
    let judges_more = sheet.status() == Status::Met && answer.status != Status::Met;
    let is_free_optimum = answer.limit.is_none() && answer.kind == Kind::Optimum;
    // The worst case of something else is none of this answer.
    let is_of_other = answer
        .value
        .as_ref()
        .is_some_and(|value| answer.kind == Kind::Estimate && sheet.reading.quantity != value.quantity);
    if judges_more || is_free_optimum || is_of_other {
        without_worst_case(&mut facts);
    }
    facts
}

impl<'t> Question<'t> {
    fn of_chart(study: &'t Study, chart: &'t Chart, curves: &'t Shown) -> Result<Question<'t>, ColumnError> {
        let table: &Table = &curves.table;
        let (x, y) = (table.column(&chart.x.name)?, table.column(&curves.estimate)?);
        let series = curves.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let mut filter = chart.filter();
        let is_named = curves.is_named(chart);
        // The least of all parts says nothing about an option; what is left in their sum does.
        let ground = study.ground(chart.source);
        let whole =
            ground.and_then(|ground| ground.texts.iter().find_map(|text| Some((text.name, text.whole?))));
        let whole = whole.filter(|(name, _)| {
            (is_named || x.role == Role::Coordinate) && filter.iter().all(|(column, _)| column != name)
        });
        filter.extend(whole.map(|(name, whole)| (name.to_owned(), whole.to_owned())));
        let mut rows = table.rows_where(&filter)?;
        // A key is asked for, not what follows from it.
        let key = table.column(&x.of).ok().filter(|_| x.role == Role::Coordinate && !x.of.is_empty());
        let x = if whole.is_some() { x } else { key.unwrap_or(x) };
        let is_named = is_named || whole.is_some();
        let by = series.into_iter().chain(is_named.then_some(x)).collect();
        let x = Some(x).filter(|_| !is_named);
        retain_placed(&mut rows, x, y);
        let question = Question::new(study, table, x, y, by, rows, chart.limit);
        Ok(Question { axis: table.column(&chart.x.name).ok(), ..question })
    }

    /// The answer of a chart of curves, and what it names as marks; the chart may have names on its abscissa.
    fn answered(
        study: &Study,
        chart: &Chart,
        curves: &Shown,
        names: &[String],
    ) -> Result<(Option<Outline>, Vec<Mark>), StudyError> {
        let question =
            Question::of_chart(study, chart, curves).map_err(|error| refused(study, chart, &error.into()))?;
        let outline = question.outline(study);
        let marks = outline.as_ref().map_or(vec![], |outline| question.marks(chart, outline, names));
        Ok((outline, marks))
    }

    /// The places that an answer names, in the units of the axes, each once; on an axis with names, the row of the headline.
    fn marks(&self, chart: &Chart, outline: &Outline, names: &[String]) -> Vec<Mark> {
        let up = axis_unit(self.y, chart.y_scale).0;
        if !names.is_empty() {
            let mark = |row: usize| {
                let x = self.table.column(&chart.x.name).ok()?;
                let place = names.iter().position(|name| *name == x.cells[row].text())?;
                let place = (1.0 + place as f64, up * self.y.value(row));
                let label = self.reading(row).text();
                Some(Mark { shape: Shape::Extremum, place, range: None, label })
            };
            let is_y = |name: &str| self.table.column(name).is_ok_and(|column| column.name == self.y.name);
            let is_shown = chart.columns().any(|column| is_y(&column.name));
            return outline.row.filter(|_| is_shown).and_then(mark).into_iter().collect();
        }
        let Some(axis) = self.axis else { return vec![] };
        let across = axis_unit(axis, chart.x_scale).0;
        let mut marks: Vec<Mark> = vec![];
        for Named { rows, x, y, shape, label, range } in &outline.marks {
            let place = |x: f64| self.place(rows, x).map(|(x, y)| (across * x, up * y));
            let Some((across_x, up_y)) = place(*x) else { continue };
            let place_of_mark = (across_x, y.map_or(up_y, |y| up * y));
            let range = range.and_then(|[from, to]| Some((place(from)?.0, place(to)?.0)));
            let mark = Mark { shape: *shape, place: place_of_mark, range, label: label.clone() };
            // Curves that coincide cross at the same place.
            if !marks.contains(&mark) {
                marks.push(mark);
            }
        }
        marks
    }

    /// The place on the chart at a value of x on a curve, between whose points it runs as crossings of a limit are found.
    fn place(&self, rows: &[usize], at: f64) -> Option<(f64, f64)> {
        let (x, axis) = (self.x?, self.axis?);
        let known = self.known(rows);
        let after = known.iter().position(|&row| x.value(row) >= at)?;
        let b = known[after];
        let Some(a) = after.checked_sub(1).map(|before| known[before]).filter(|_| x.value(b) > at) else {
            return Some((axis.value(b), self.y.value(b)));
        };
        let part = crossing_fraction(x.value(a), x.value(b), at);
        let [low, high] = [a, b].map(|row| self.y.value(row));
        let y = if high < 0.0 && low < 0.0 { -between(-low, -high, part) } else { between(low, high, part) };
        Some((between(axis.value(a), axis.value(b), part), y))
    }

    /// The points of a study without its own chart.
    fn of_points(study: &'t Study, table: &'t Table, decided: Option<&Sheet>) -> Option<Question<'t>> {
        let y = table.usual(Usual::Answer)?;
        let mut rows = table.rows_where(&usual_filter(study, table)).ok()?;
        let x = table.usual(Usual::Abscissa).filter(|_| table.usual(Usual::Places).is_none());
        retain_placed(&mut rows, x, y);
        // Every study of the kind has the columns.
        let by = apart(study, Source::Points, table).ok()?;
        let limit = decided.filter(|sheet| sheet.label == y.label).and_then(|sheet| sheet.limit);
        Some(Question::new(study, table, x, y, by, rows, limit))
    }

    /// The answer in the shape of the question; `None` for rows without a value.
    fn outline(&self, study: &Study) -> Option<Outline> {
        if self.known(&self.rows).is_empty() {
            return None;
        }
        let is_error = less_is_better(self.table, self.y, &self.rows);
        Some(match (self.x, self.limit) {
            (Some(x), _) if self.y.role == Role::Fraction => options::outline_of_detection(self, x),
            (Some(x), Some(limit)) => limits::outline(self, x, limit),
            (Some(x), None) if is_error && x.usual == Some(Usual::Abscissa) => {
                options::outline_of_minimum(self, x)
            }
            (Some(x), None) if is_error && !is_given(x) => options::outline_of_optimum(self, x),
            (Some(x), None) if study.kind().is_exact => {
                options::outline_of_peaks(self, x).unwrap_or_else(|| options::outline_of_values(self))
            }
            _ => options::outline_of_values(self),
        })
    }
}

/// Keeps the rows that have a place on the abscissa, or where there is none, a value.
fn retain_placed(rows: &mut Vec<usize>, x: Option<&Column>, y: &Column) {
    let column = x.unwrap_or(y);
    rows.retain(|&row| column.cells[row].number().is_some());
}

/// A table of lines, usable ones in their order first; equal ones are joined, and the first one is the best.
pub(in crate::analysis) fn table(columns: Vec<String>, lines: Vec<Line>) -> AnswerTable {
    let (usable, others): (Vec<Line>, Vec<Line>) = lines.into_iter().partition(|line| line.is_usable);
    let mut joined: Vec<Line> = Vec::new();
    for line in usable.into_iter().chain(others) {
        match joined.iter_mut().find(|other| {
            other.is_usable == line.is_usable && !line.cells.is_empty() && other.cells == line.cells
        }) {
            Some(other) => other.name += &format!(" = {}", line.name),
            None => joined.push(line),
        }
    }
    let omitted = joined.len().saturating_sub(MAX_ROWS);
    joined.truncate(MAX_ROWS);
    let row = |line: Line| std::iter::once(AnswerCell::from(line.name)).chain(line.cells).collect();
    let rows: Vec<Vec<AnswerCell>> = joined.into_iter().map(row).collect();
    AnswerTable { columns, best: (rows.len() > 1).then_some(0), rows, omitted, ..AnswerTable::default() }
}

/// At most as many of some places as columns beside the first and some `others` are shown, evenly and with both ends.
pub(super) fn sampled(count: usize, others: usize) -> Vec<usize> {
    spread(count, MAX_COLUMNS - 1 - others)
}

/// At most so many of `count` places, evenly and with both ends.
pub(super) fn spread(count: usize, most: usize) -> Vec<usize> {
    match count <= most {
        true => (0..count).collect(),
        false => (0..most).map(|at| at * (count - 1) / (most - 1)).collect(),
    }
}

/// A name and a result as a headline; a name of its own may be missing.
pub(super) fn headline(name: &str, result: &str) -> String {
    let name = if name.is_empty() { String::new() } else { format!("{name}: ") };
    compact(&begun(&format!("{name}{result}")))
}

/// A text without the spaces around signs of equality.
fn compact(text: &str) -> String {
    text.replace(" = ", "=")
}

/// The name of an option under a condition; either may be empty.
pub(super) fn joined_names(option: &str, condition: &str) -> String {
    let names = [option, condition].into_iter().filter(|name| !name.is_empty());
    names.collect::<Vec<_>>().join(", ")
}

/// A value of the abscissa in a headline: with its symbol where it has no unit.
pub(super) fn at(x: &Column, value: f64) -> String {
    let reading = Reading::new(x, value, None);
    let symbol = symbol(&x.label);
    match (reading.unit.is_empty(), symbol == x.label) {
        (true, false) => format!("{symbol}={}", reading.text()),
        _ => joined(&sagnac_report::answer::reading::number(reading.value), &reading.unit),
    }
}

/// A value of the abscissa as the name of a row or a column of the table.
pub(super) fn at_place(x: &Column, value: f64) -> String {
    shown(x, &Cell::Number(value))
}

/// Values of the abscissa as such names, in full where three digits do not tell them apart.
pub(super) fn at_places(x: &Column, values: &[f64]) -> Vec<String> {
    let names: Vec<String> = values.iter().map(|&value| at_place(x, value)).collect();
    match names.windows(2).any(|pair| pair[0] == pair[1]) {
        true => values.iter().map(|&value| x.valued(&Cell::Number(value).text())).collect(),
        false => names,
    }
}
