//! The answer against a limit: how far along a curve the 99.73 % error stays within it.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::table::{Column, ColumnError, Table, significant};

/// What is asked of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Question<'a> {
    /// The column along which the curves run.
    pub x: &'a str,
    /// The columns that tell curves apart.
    pub series: Vec<&'a str>,
    /// Only rows with these values: (column, value as files show it).
    pub filter: Vec<(String, String)>,
    /// In the unit of the 99.73 % error, ″.
    pub limit: f64,
}

/// The answer for one curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Column and value of what tells the curve apart.
    pub series: Vec<(String, String)>,
    pub outcome: Outcome,
    /// Where that is: column with unit, and value.
    pub at: Vec<(String, f64)>,
}

/// How a curve stands to the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It passes the limit for the first time there, found between two points.
    Passes,
    /// It is above the limit from its first point on, which is there.
    AboveFrom,
    /// It stays within the limit up to its last point, which is there.
    WithinUpTo,
}

/// The answer for every curve, in the order of the table.
///
/// # Errors
/// A name selects no single column, or a filter leaves no row.
pub fn verdict(table: &Table, question: &Question) -> Result<Vec<Answer>, ColumnError> {
    let x = table.column(question.x)?;
    let error = table.column("q9973")?;
    let series = question.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    // Wherever the curve runs along, the frequency and Δt·ν are told too.
    let mut coordinates = vec![x];
    for name in ["motion.frequency", "dt_nu"] {
        coordinates.extend(table.column(name).ok().filter(|column| column.name != x.name));
    }
    let mut curves: Vec<Vec<usize>> = Vec::new();
    let mut place = BTreeMap::new();
    for row in table.rows_where(&question.filter)? {
        if x.cells[row].number().is_some() && error.cells[row].number().is_some() {
            let key: Vec<String> = series.iter().map(|column| column.cells[row].text()).collect();
            let next = curves.len();
            let curve = *place.entry(key).or_insert(next);
            if curve == next {
                curves.push(Vec::new());
            }
            curves[curve].push(row);
        }
    }
    let value = |column: &Column, row: usize| column.cells[row].number().unwrap_or(f64::NAN);
    Ok(curves
        .into_iter()
        .map(|mut rows| {
            rows.sort_by(|&a, &b| value(x, a).total_cmp(&value(x, b)));
            let first_above = rows.iter().position(|&row| value(error, row) > question.limit);
            let (outcome, before, after) = match first_above {
                None => (Outcome::WithinUpTo, rows[rows.len() - 1], rows[rows.len() - 1]),
                Some(0) => (Outcome::AboveFrom, rows[0], rows[0]),
                Some(i) => (Outcome::Passes, rows[i - 1], rows[i]),
            };
            let part = fraction(value(error, before), value(error, after), question.limit);
            let at = coordinates
                .iter()
                .map(|column| (column.header(), between(value(column, before), value(column, after), part)))
                .filter(|(_, value)| value.is_finite())
                .collect();
            let named = series.iter().map(|column| (column.header(), column.cells[rows[0]].text())).collect();
            Answer { series: named, outcome, at }
        })
        .collect())
}

/// How far the limit lies from a to b, on a logarithmic scale where there is one.
fn fraction(a: f64, b: f64, limit: f64) -> f64 {
    match a == b {
        true => 0.0,
        false if a > 0.0 => libm::log(limit / a) / libm::log(b / a),
        false => (limit - a) / (b - a),
    }
}

fn between(a: f64, b: f64, part: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a * libm::pow(b / a, part) } else { a + (b - a) * part }
}

impl Answer {
    /// The answer as a sentence.
    pub fn sentence(&self, limit: &str) -> String {
        let series: Vec<String> = self.series.iter().map(|(_, value)| value.clone()).collect();
        let at: Vec<String> =
            self.at.iter().map(|(column, value)| format!("{column} = {}", significant(*value, 3))).collect();
        let (series, at) = (series.join(", "), at.join(", "));
        match self.outcome {
            Outcome::Passes => format!("{series}: passes {limit} at {at}"),
            Outcome::AboveFrom => format!("{series}: above {limit} from the first point on, {at}"),
            Outcome::WithinUpTo => format!("{series}: within {limit} up to the last point, {at}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Cell, Unit};

    fn table() -> Table {
        let column = |name: &str, cells| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit: Unit::NONE,
            cells,
            band: None,
        };
        let numbers = |values: [f64; 6]| values.map(Cell::Number).to_vec();
        let fillers = ["a", "a", "a", "b", "b", "b"].map(|name| Cell::Text(name.to_owned())).to_vec();
        Table {
            columns: vec![
                column("motion.frequency", numbers([4.0, 1.0, 2.0, 1.0, 2.0, 4.0])),
                column("filler", fillers),
                column("q9973", numbers([40.0, 5.0, 20.0, 0.1, 0.2, 0.3])),
            ],
        }
    }

    fn answers(limit: f64) -> Vec<Answer> {
        let question = Question { x: "frequency", series: vec!["filler"], filter: vec![], limit };
        verdict(&table(), &question).unwrap()
    }

    #[test]
    fn the_crossing_is_found_between_sorted_points_on_logarithmic_scales() {
        let answers = answers(10.0);
        assert_eq!((answers[0].outcome, answers[1].outcome), (Outcome::Passes, Outcome::WithinUpTo));
        let (column, at) = &answers[0].at[0];
        assert_eq!(column, "motion.frequency");
        assert!((at - libm::sqrt(2.0)).abs() < 1e-12, "{at}");
        assert_eq!(answers[1].at[0].1, 4.0);
    }

    #[test]
    fn a_curve_above_the_limit_from_the_start_is_said_to_be() {
        let answers = answers(1.0);
        assert_eq!((answers[0].outcome, answers[0].at[0].1), (Outcome::AboveFrom, 1.0));
        assert_eq!(answers[0].sentence("1 ″"), "a: above 1 ″ from the first point on, motion.frequency = 1");
    }
}
