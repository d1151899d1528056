//! Verdicts against a limit: how far along a curve its value stays within it.
//!
//! ```
//! use sagnac::table::{Cell, Column, Table, Unit};
//! use sagnac::view::verdict::{Outcome, Question, verdict};
//!
//! let column = |name: &str, values: [f64; 3]| Column {
//!     name: name.to_owned(),
//!     label: name.to_owned(),
//!     unit: Unit::NONE,
//!     cells: values.map(Cell::Number).to_vec().into(),
//!     ..Column::default()
//! };
//! let table = Table { columns: vec![column("x", [1.0, 2.0, 4.0]), column("y", [1.0, 5.0, 20.0])] };
//! let question = Question { x: "x", y: "y", series: vec![], filter: vec![], limit: 10.0 };
//! let answers = verdict(&table, &question)?;
//! assert_eq!(answers[0].outcome, Outcome::Passes);
//! // Linear in the logarithms of both: 5·(x/2)² is 10 at 2√2.
//! assert!((answers[0].at[0].1 - 8_f64.sqrt()).abs() < 1e-9);
//! # Ok::<(), sagnac::table::ColumnError>(())
//! ```

#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::quantity::number::{Side, digits_within, rounded_to, significant};
use crate::table::{Cell, Column, ColumnError, Role, Table, grouped};

/// A question about a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Question<'a> {
    /// The column along which the curves run.
    pub x: &'a str,
    /// The column that is judged.
    pub y: &'a str,
    /// The columns that distinguish curves.
    pub series: Vec<&'a str>,
    /// Rows to use, as pairs of a column and its value in files.
    pub filter: Vec<(String, String)>,
    /// Limit, in the unit of y.
    pub limit: f64,
}

/// The answer for one curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer<'t> {
    /// Columns and values that distinguish the curve.
    pub series: Vec<(&'t Column, &'t Cell)>,
    /// Relation of the curve to the limit.
    pub outcome: Outcome,
    /// Place of that outcome as columns and values, in the order of the table; empty for names side by side.
    pub at: Vec<(&'t Column, f64)>,
    /// Largest magnitude of the curve, in the unit of y.
    pub most: f64,
    /// Upper end of the 95 % interval of that value; absent for closed forms and few trials.
    pub most_upper: Option<f64>,
    /// Least magnitude of the curve, in the unit of y.
    pub least: f64,
    /// Whether points after the last value of the curve have none, as in an incomplete run.
    pub open: bool,
    /// For [`Outcome::WithinBetween`], the place where it rises above the limit again.
    pub until: Vec<(&'t Column, f64)>,
    /// The further stretches of the curve that are within the limit.
    pub again: Vec<Window<'t>>,
    /// The place of its first value, if points before it have none; else empty.
    pub first: Vec<(&'t Column, f64)>,
}

/// A stretch of a curve that is within the limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Window<'t> {
    /// The place at which the curve falls to the limit.
    pub from: Vec<(&'t Column, f64)>,
    /// The place at which the curve rises above the limit; empty if it stays within.
    pub until: Vec<(&'t Column, f64)>,
}

/// The relation of a curve to the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It rises above the limit for the first time at this place, which lies between two points.
    Passes,
    /// It is above the limit from its first point on, which is this place.
    AboveFrom,
    /// It stays within the limit up to the point at this place and is above it at the next one; counted quantities have
    /// no points in between.
    LastWithin,
    /// It is above the limit at first, falls below it for the last time at this place, which lies between two points,
    /// and stays below.
    WithinFrom,
    /// It is above the limit at first and at last, and within it from this place on for a while.
    WithinBetween,
    /// It stays within the limit up to its last point, which is this place.
    WithinUpTo,
}

/// The answer for every curve, in the order of the table.
///
/// # Errors
/// A name selects no single column, or a filter leaves no row.
pub fn verdict<'t>(table: &'t Table, question: &Question) -> Result<Vec<Answer<'t>>, ColumnError> {
    let (x, y) = (table.column(question.x)?, table.column(question.y)?);
    let mut series = question.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    // Names side by side are judged separately.
    let named = x.cells.any(|cell| matches!(cell, Cell::Text(_)));
    if named {
        series.push(x);
    }
    let placed = |row: &usize| named || x.cells[*row].number().is_some();
    let rows = table.rows_where(&question.filter)?.into_iter().filter(placed);
    let curves =
        grouped(rows, |row| series.iter().map(|column| column.cells[row].text()).collect::<Vec<_>>());
    let has_value = |row: &usize| y.cells[*row].number().is_some();
    let parts = curves.into_iter().map(|(_, rows)| rows.into_iter().partition(has_value));
    let mut curves: Vec<(Vec<usize>, Vec<usize>)> =
        parts.filter(|(known, _): &(Vec<_>, _)| !known.is_empty()).collect();
    curves.sort_by_key(|(known, _)| known[0]);
    let answer = |(mut rows, blank): (Vec<usize>, Vec<usize>)| {
        rows.sort_by(|&a, &b| x.value(a).total_cmp(&x.value(b)));
        let last = rows[rows.len() - 1];
        // Values of both signs are judged by their magnitude.
        let is_above = |row: usize| y.value(row).abs() > question.limit;
        // In turn within and above the limit.
        let stretches: Vec<&[usize]> = rows.chunk_by(|&a, &b| is_above(a) == is_above(b)).collect();
        // The rows between which one stretch ends and the next begins.
        let after =
            |stretch: usize| (stretches[stretch][stretches[stretch].len() - 1], stretches[stretch + 1][0]);
        // So many stretches are told by the outcome; the others are windows further on.
        let (outcome, at, until, told) = match (is_above(rows[0]), stretches.len()) {
            (false, 1) => (Outcome::WithinUpTo, (last, last), None, 1),
            (false, _) => match after(0) {
                (a, b) if counts_between(table, a, b) => (Outcome::LastWithin, (a, a), None, 1),
                between => (Outcome::Passes, between, None, 1),
            },
            (true, 1) => (Outcome::AboveFrom, (rows[0], rows[0]), None, 1),
            (true, count) if count % 2 == 0 => (Outcome::WithinFrom, after(count - 2), None, count),
            (true, _) => (Outcome::WithinBetween, after(0), Some(after(1)), 2),
        };
        let crossing = |(before, after): (usize, usize)| {
            let part = fraction(y.value(before), y.value(after), question.limit);
            coordinates(table, x, rows[0], last)
                .map(|column| (column, between(column.value(before), column.value(after), part)))
                .filter(|(_, value)| value.is_finite())
                .collect::<Vec<_>>()
        };
        let (at, until) = (crossing(at), until.map_or(vec![], crossing));
        let within = (told..stretches.len()).filter(|&stretch| !is_above(stretches[stretch][0]));
        let window = |stretch: usize| {
            let (before, from) = after(stretch - 1);
            let to = (stretch + 1 < stretches.len()).then(|| after(stretch));
            match counts_between(table, before, from) {
                true => Window {
                    from: crossing((from, from)),
                    until: to.map_or(vec![], |(to, _)| crossing((to, to))),
                },
                false => Window { from: crossing((before, from)), until: to.map_or(vec![], crossing) },
            }
        };
        let again = within.map(window).collect();
        let named: Vec<(&Column, &Cell)> =
            series.iter().map(|column| (*column, &column.cells[rows[0]])).collect();
        let open = blank.iter().any(|&row| x.value(row) > x.value(last));
        let late = blank.iter().any(|&row| x.value(row) < x.value(rows[0]));
        let first = if late { crossing((rows[0], rows[0])) } else { vec![] };
        let sizes = || rows.iter().map(|&row| y.value(row).abs());
        let (least, most) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
        let at_most = rows.iter().copied().max_by(|&a, &b| y.value(a).abs().total_cmp(&y.value(b).abs()));
        let interval = at_most.and_then(|row| y.interval(row));
        let most_upper = interval.map(|(low, high)| high.abs().max(low.abs()));
        Answer { series: named, outcome, at, most, most_upper, least, open, until, again, first }
    };
    Ok(curves.into_iter().map(answer).collect())
}

/// The coordinates that describe the place on a curve between the rows `a` and `b`: x, and those coordinates and keys
/// that vary with it, such as Δt·ν and the frequency.
fn coordinates<'t>(table: &'t Table, x: &Column, a: usize, b: usize) -> impl Iterator<Item = &'t Column> {
    let coordinates = || table.columns.iter().filter(|column| column.role == Role::Coordinate);
    let told = move |column: &Column| {
        let with = |other: &Column| !other.of.is_empty() && [&other.name, &other.of].contains(&&column.name);
        column.cells[a] != column.cells[b] && coordinates().any(with)
    };
    table.columns.iter().filter(move |column| column.name == x.name || told(column))
}

/// Whether a count leads from one row to the other, so that nothing lies between them.
pub(crate) fn counts_between(table: &Table, a: usize, b: usize) -> bool {
    table.columns.iter().filter(|column| !matches!(column.role, Role::Trials | Role::Count)).any(|column| {
        let (a, b) = (&column.cells[a], &column.cells[b]);
        matches!((a, b), (Cell::Integer(_), Cell::Integer(_))) && a != b
    })
}

/// The fraction of the way from a to b at which the limit lies, one of the two being beyond it; on a logarithmic scale
/// where possible.
pub(crate) fn fraction(a: f64, b: f64, limit: f64) -> f64 {
    let beyond = if a.abs() > b.abs() { a } else { b };
    let limit = limit * beyond.signum();
    match a == b {
        true => 0.0,
        false if a * b > 0.0 => libm::log(limit / a) / libm::log(b / a),
        false => (limit - a) / (b - a),
    }
}

pub(crate) fn between(a: f64, b: f64, part: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a * libm::pow(b / a, part) } else { a + (b - a) * part }
}

impl Answer<'_> {
    /// Description that distinguishes the curve, such as `quadratic, lost ticks n = 1`.
    pub fn name(&self) -> String {
        let name = |(column, cell): &(&Column, &Cell)| match cell {
            Cell::Text(text) => text.clone(),
            Cell::Number(number) => column.valued(&significant(*number, 6)),
            cell => column.valued(&cell.text()),
        };
        let series: Vec<String> = self.series.iter().map(name).collect();
        if series.is_empty() { "the curve".to_owned() } else { series.join(", ") }
    }

    /// The place of its outcome as in a sentence, such as `vibration frequency 20 Hz, Δt·ν = 0.2`.
    pub fn place(&self) -> String {
        places(&self.at, self.outcome.side())
    }

    /// The place where it rises above the limit again, in the same form.
    pub fn end(&self) -> String {
        places(&self.until, Side::Down)
    }

    /// The answer as a sentence.
    pub fn sentence(&self, limit: &str) -> String {
        let series = self.name();
        let [at, until] = match (&self.until[..], self.outcome) {
            ([_, ..], Outcome::WithinBetween) => ends(&self.at, &self.until),
            _ => [self.place(), self.end()],
        };
        let outcome = match self.outcome {
            Outcome::AboveFrom if at.is_empty() => format!("above {limit}"),
            _ if at.is_empty() => format!("within {limit}"),
            // Before a further window, what was left is not the news.
            Outcome::Passes if !self.again.is_empty() => format!("within {limit} up to {at}"),
            Outcome::Passes => format!("rises above {limit} at {at}"),
            Outcome::AboveFrom if self.first.is_empty() => {
                format!("above {limit} from the first point on, {at}")
            }
            Outcome::AboveFrom => format!("above {limit} from its first value on, {at}"),
            Outcome::WithinFrom => format!("within {limit} from {at} on"),
            Outcome::WithinBetween => format!("within {limit} from {at} to {until}"),
            Outcome::LastWithin => format!("within {limit} up to {at}"),
            Outcome::WithinUpTo if self.open => {
                format!("within {limit} up to the last point that has a value, {at}")
            }
            Outcome::WithinUpTo => format!("within {limit} up to the last point, {at}"),
        };
        let again: String = self.again.iter().map(Window::told).collect();
        let first = match (self.outcome, &self.first[..]) {
            (_, []) => String::new(),
            (Outcome::AboveFrom, _) => ", without one before".to_owned(),
            (_, first) => format!(", without a value before {}", places(first, Side::Nearest)),
        };
        format!("{series}: {outcome}{again}{first}")
    }
}

impl Window<'_> {
    /// The window as a further part of a sentence.
    fn told(&self) -> String {
        match &self.until[..] {
            [] => format!(", and again from {} on", places(&self.from, Side::Up)),
            until => {
                let [from, until] = ends(&self.from, until);
                format!(", and again from {from} to {until}")
            }
        }
    }
}

impl Outcome {
    /// The side to which its place is rounded, so that what is told to be within the limit is.
    pub(crate) fn side(self) -> Side {
        match self {
            Outcome::Passes => Side::Down,
            Outcome::WithinFrom | Outcome::WithinBetween => Side::Up,
            // The places of points, of which a limit says nothing beyond.
            Outcome::AboveFrom | Outcome::LastWithin | Outcome::WithinUpTo => Side::Nearest,
        }
    }
}

/// Significant digits of a place.
const DIGITS: usize = 3;

/// Places as in a sentence, rounded to a side.
pub(crate) fn places(places: &[(&Column, f64)], side: Side) -> String {
    with_digits(places, side, DIGITS)
}

/// The ends of a window within the limit, rounded inwards, with as many digits as keep them in order.
fn ends(from: &[(&Column, f64)], until: &[(&Column, f64)]) -> [String; 2] {
    let pairs = from.iter().zip(until);
    let digits = pairs.map(|(from, until)| digits_within(from.1, until.1, DIGITS)).max().unwrap_or(DIGITS);
    [with_digits(from, Side::Up, digits), with_digits(until, Side::Down, digits)]
}

fn with_digits(places: &[(&Column, f64)], side: Side, digits: usize) -> String {
    let each = places.iter().map(|(column, value)| {
        let text = rounded_to(side, *value, digits);
        match (column.unit.symbol, *value) {
            ("s", 1e5..) => format!("{} {}", column.label, spoken(*value, side, digits)),
            // Beside the rounded seconds, the other unit is theirs.
            ("s", 600.0..) => {
                let seconds = text.parse().unwrap_or(*value);
                format!("{} ({})", column.valued(&text), spoken(seconds, Side::Nearest, digits))
            }
            _ => column.valued(&text),
        }
    });
    each.collect::<Vec<_>>().join(", ")
}

/// A long time in a convenient unit, such as `52.2 min` or `20.1 h`.
fn spoken(seconds: f64, side: Side, digits: usize) -> String {
    let (unit_s, unit) = match seconds {
        172_800.0.. => (86_400.0, "d"),
        7200.0.. => (3600.0, "h"),
        _ => (60.0, "min"),
    };
    format!("{} {unit}", rounded_to(side, seconds / unit_s, digits))
}
