//! The value of a design choice at which an estimate is least.

use crate::analysis::answer::{
    Line, Named, Outline, Question, at, at_place, headline, joined_names, table, values,
};
use sagnac_base::table::Column;
use sagnac_report::answer::reading::span;
use sagnac_report::answer::{AnswerCell, Kind, MAX_ROWS, Reading};
use sagnac_report::chart::figure::Shape;

/// The excess over the least value up to which the cost counts as equal.
const FLAT: f64 = 0.04;

/// A curve at its least value.
struct Least {
    name: String,
    long: String,
    is_usable: bool,
    /// The rows of the curve.
    rows: Vec<usize>,
    row: usize,
    /// The values of x around it at which the cost is at most [`FLAT`] larger.
    flat: [f64; 2],
    /// The values of x around it whose 95 % intervals overlap with its own.
    alike: [f64; 2],
    is_end: bool,
}

pub(super) fn outline(question: &Question, x: &Column) -> Outline {
    let conditions = question.columns();
    let mut found: Vec<Least> = Vec::new();
    for choice in question.choices() {
        for (rows, condition) in choice.rows.iter().zip(&conditions) {
            let named = |name: &str| joined_names(name, condition);
            found.extend(least(question, x, rows).map(|(row, flat, alike, is_end)| Least {
                name: named(&choice.name),
                long: named(&choice.long),
                is_usable: choice.is_usable,
                rows: rows.clone(),
                row,
                flat,
                alike,
                is_end,
            }));
        }
    }
    if !question.options.is_empty() {
        found.sort_by(|a, b| {
            b.is_usable.cmp(&a.is_usable).then(question.size(a.row).total_cmp(&question.size(b.row)))
        });
    }
    // A single curve is shown along its places.
    let is_single = found.len() == 1 && found[0].name.is_empty();
    let has_bands = found.iter().all(|least| question.y.interval(least.row).is_some());
    let line = |least: &Least| {
        let best = Reading::new(x, x.value(least.row), None);
        let end = if least.is_end { " (end)" } else { "" };
        let mut cells = vec![
            AnswerCell::with_text(best.text() + end, best),
            AnswerCell::from(range(x, least.flat)),
            question.reading(least.row).into(),
        ];
        if has_bands {
            cells.insert(2, range(x, least.alike).into());
            cells.push(question.reading(least.row).interval_text().unwrap_or_default().into());
        }
        Line { name: least.name.clone(), is_usable: least.is_usable, cells }
    };
    let mut lines: Vec<Line> = found.iter().map(line).collect();
    let mut columns =
        vec![heading(question), format!("best {}", x.label), "within 4 %".to_owned(), question.label()];
    if has_bands {
        columns.insert(3, "not distinguishable".to_owned());
        columns.push("95 % interval".to_owned());
    }
    // Where all curves are given, the one that costs most.
    let told = match question.options.is_empty() {
        true => found.iter().max_by(|a, b| question.size(a.row).total_cmp(&question.size(b.row))),
        false => found.first(),
    };
    let (headline, value) = match told {
        Some(least) => {
            let with = if least.long.is_empty() { String::new() } else { format!(" ({})", least.long) };
            let end = match (least.is_end, least.flat[0] == least.flat[1]) {
                (true, _) => ", end of the range".to_owned(),
                (false, true) => String::new(),
                (false, false) => format!("; flat {}", span(x, least.flat[0], least.flat[1])),
            };
            let best = at(x, x.value(least.row));
            (
                headline("", &format!("best {}: {best}{with}{end}", x.label)),
                Some(Reading::new(x, x.value(least.row), Some((least.flat[0], least.flat[1])))),
            )
        }
        None => (String::new(), None),
    };
    if let (true, [choice]) = (is_single, &question.choices()[..]) {
        lines = values::along(question, x, &choice.rows[0]);
        columns = vec![x.label.clone(), question.label(), "95 % interval".to_owned()];
    }
    // The range is that of the headline alone, as several would cover each other.
    let mark = |least: &Least| Named {
        rows: least.rows.clone(),
        x: x.value(least.row),
        y: None,
        shape: Shape::Extremum,
        label: Reading::new(x, x.value(least.row), None).text(),
        range: Some(least.flat)
            .filter(|[from, to]| from < to && told.is_some_and(|told| told.row == least.row)),
    };
    let marks = found.iter().take(MAX_ROWS).map(mark).collect();
    let mut table = table(columns, lines);
    if is_single {
        let name = at_place(x, x.value(found[0].row));
        table.best = table.rows.iter().position(|row| row[0].text == name);
    }
    if question.options.is_empty() && table.best.is_some() {
        let name = told.map(|least| least.name.clone()).unwrap_or_default();
        table.best = table.rows.iter().position(|row| row[0].text == name);
    }
    Outline { kind: Kind::Optimum, headline, value, table, marks, met: None }
}

fn heading(question: &Question) -> String {
    let labels = question.options.iter().chain(&question.conditions).map(|column| column.label.as_str());
    labels.collect::<Vec<_>>().join(", ")
}

/// The row with the least value of a curve, the ranges around it that cost as much and that do not differ, and whether it is at an
/// end of a range with several places.
fn least(question: &Question, x: &Column, rows: &[usize]) -> Option<(usize, [f64; 2], [f64; 2], bool)> {
    let known: Vec<usize> =
        rows.iter().copied().filter(|&row| question.y.cells[row].number().is_some()).collect();
    let best =
        (0..known.len()).min_by(|&a, &b| question.size(known[a]).total_cmp(&question.size(known[b])))?;
    let around = |is_in: &dyn Fn(usize) -> bool| {
        let first = (0..=best).rev().take_while(|&at| at == best || is_in(known[at])).last().unwrap_or(best);
        let last =
            (best..known.len()).take_while(|&at| at == best || is_in(known[at])).last().unwrap_or(best);
        [first, last].map(|at| x.value(known[at]))
    };
    let flat = around(&|row| question.size(row) <= (1.0 + FLAT) * question.size(known[best]));
    let alike = around(&|row| question.y.is_alike(row, known[best]));
    let is_end = known.len() > 1 && (best == 0 || best == known.len() - 1);
    Some((known[best], flat, alike, is_end))
}

fn range(x: &Column, [from, to]: [f64; 2]) -> String {
    if from == to { Reading::new(x, from, None).text() } else { span(x, from, to) }
}
