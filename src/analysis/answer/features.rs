//! Answers from features of curves: where records show a coefficient, minima, and peaks.

use crate::analysis::answer::options::{Least, curves_at_least, heading, sort_curves};
use crate::analysis::answer::{Line, Named, Outline, at, headline, table};
use crate::analysis::question::{Notches, Question};
use sagnac_base::table::{Column, between};
use sagnac_engine::kinds::allan::columns::is_absent;
use sagnac_report::answer::reading::percent_of;
use sagnac_report::answer::{AnswerCell, Kind, MAX_COLUMNS, MAX_ROWS, Reading};
use sagnac_report::chart::figure::Shape;

/// The part of records from which on a coefficient counts as shown.
const HALF: f64 = 0.5;

pub(super) fn outline_of_detection(question: &Question, x: &Column) -> Outline {
    let (mut lines, mut marks) = (Vec::new(), Vec::new());
    let mut told: Option<(String, f64, bool)> = None;
    for choice in question.choices() {
        let rows = question.known(&choice.rows.concat());
        let is_more = |row: usize| question.y.value(row) >= HALF;
        let passes = rows.windows(2).find(|pair| is_more(pair[0]) != is_more(pair[1]));
        let most = rows.iter().map(|&row| question.y.value(row)).reduce(f64::max);
        let text = match passes {
            Some(&[a, b]) => {
                let part = (HALF - question.y.value(a)) / (question.y.value(b) - question.y.value(a));
                let place = between(x.value(a), x.value(b), part);
                told.get_or_insert((choice.long.clone(), place, is_more(b)));
                let label = Reading::new(x, place, None).text();
                let text = format!("{} {label}", if is_more(b) { "≥" } else { "≤" });
                marks.push(Named { y: Some(HALF), ..Named::at(&rows, place, Shape::Crossing, label) });
                text
            }
            _ if rows.is_empty() || is_absent(question.table, &rows) => "not in this noise".to_owned(),
            _ if is_more(rows[0]) => "everywhere".to_owned(),
            _ => "nowhere".to_owned(),
        };
        let most = most.map_or_else(String::new, percent_of);
        lines.push(Line {
            name: choice.name,
            is_usable: true,
            cells: vec![text.into(), AnswerCell::from(most)],
        });
    }
    let columns = vec![question.heading(), "half of records show it".to_owned(), "largest share".to_owned()];
    let mut table = table(columns, lines);
    if let Some((name, ..)) = &told {
        let is_told = |row: &Vec<AnswerCell>| row[0].text.split(" = ").any(|one| one == name.as_str());
        table.best = table.rows.iter().position(is_told).or(table.best);
    }
    let (headline, value) = match &told {
        Some((name, place, is_from)) => {
            let way = if *is_from { "from" } else { "up to" };
            let text = format!("half of the records show {name} {way} {}", at(x, *place));
            (headline("", &text), Some(Reading::new(x, *place, None)))
        }
        None => {
            let everywhere = table.rows.iter().filter(|row| row[1].text == "everywhere");
            // Equal rows are joined.
            let names: Vec<String> = everywhere.map(|row| row[0].text.replace(" = ", ", ")).collect();
            let names = if names.is_empty() { "no coefficient".to_owned() } else { names.join(", ") };
            (headline("", &format!("half of the records show {names}")), None)
        }
    };
    Outline { kind: Kind::Threshold, headline, value, table, marks, ..Outline::default() }
}

/// Most words of a name with labels in a headline.
const MAX_WORDS: usize = 5;

pub(super) fn outline_of_minimum(question: &Question, x: &Column) -> Outline {
    let choices = question.choices();
    let curves = choices.iter().flat_map(|choice| choice.rows.iter().map(Vec::as_slice));
    let notches = Notches::new(x, question.y, curves);
    let mut found = curves_at_least(question, x, &choices, |place| notches.are_at(place));
    sort_curves(question, &mut found);
    let line = |least: &Least| {
        let value = question.reading(least.row);
        let interval = value.interval_text().unwrap_or_default();
        let cells = vec![value.into(), interval.into(), Reading::new(x, x.value(least.row), None).into()];
        Line { name: least.name.clone(), is_usable: least.is_usable, cells }
    };
    let lines = found.iter().map(line).collect();
    let mark = |least: &Least| {
        let label = question.reading(least.row).text();
        Named::at(&least.rows, x.value(least.row), Shape::Extremum, label)
    };
    let marks = found.iter().take(MAX_ROWS).map(mark).collect();
    let columns = vec![
        heading(question),
        format!("least {}", question.label()),
        "95 % interval".to_owned(),
        format!("at {}", x.label),
    ];
    let (headline, value) = match found.first() {
        Some(Least { name, long, row, .. }) => {
            let value = question.reading(*row);
            let long = if long.split(' ').count() > MAX_WORDS { name } else { long };
            (
                headline(
                    long,
                    &format!("least {} {} at {}", question.label(), value.text(), at(x, x.value(*row))),
                ),
                Some(value),
            )
        }
        None => (String::new(), None),
    };
    let table = table(columns, lines);
    Outline { kind: Kind::Choice, headline, value, table, marks, ..Outline::default() }
}

/// The peaks of curves of which each has some; `None` for others.
pub(super) fn outline_of_peaks(question: &Question, x: &Column) -> Option<Outline> {
    let (mut lines, mut marks, mut first) = (Vec::new(), Vec::new(), None);
    for choice in question.choices() {
        let rows = choice.rows.concat();
        let is_peak = |three: &&[usize]| {
            let [a, b, c] = [three[0], three[1], three[2]].map(|row| question.y.value(row));
            b > a && b >= c
        };
        let peaks: Vec<usize> = rows.windows(3).filter(is_peak).map(|three| three[1]).collect();
        if peaks.is_empty() || peaks.len() >= MAX_COLUMNS {
            return None;
        }
        let highest =
            peaks.iter().copied().max_by(|&a, &b| question.y.value(a).total_cmp(&question.y.value(b)))?;
        first.get_or_insert((choice.long.clone(), highest));
        let cells = peaks.iter().map(|&row| AnswerCell::from(Reading::new(x, x.value(row), None)));
        marks.extend(peaks.iter().map(|&row| {
            let label = Reading::new(x, x.value(row), None).text();
            Named::at(&rows, x.value(row), Shape::Extremum, label)
        }));
        lines.push(Line { name: choice.name, is_usable: true, cells: cells.collect() });
    }
    let (name, row) = first?;
    let most = lines.iter().map(|line| line.cells.len()).max().unwrap_or(0);
    lines.iter_mut().for_each(|line| line.cells.resize_with(most, AnswerCell::default));
    let columns =
        std::iter::once(question.heading()).chain((1..=most).map(|peak| format!("peak {peak}"))).collect();
    let value = Reading::new(x, x.value(row), None);
    let headline = headline(&name, &format!("highest peak at {}", at(x, x.value(row))));
    Some(Outline {
        kind: Kind::Estimate,
        headline,
        value: Some(value),
        table: table(columns, lines),
        marks,
        ..Outline::default()
    })
}
