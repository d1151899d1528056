//! The values of options side by side, under the conditions or at places of the abscissa.

use crate::analysis::answer::{
    Choice, Line, Named, Outline, Question, at_places, begun, headline, limited, place, sampled, spread,
    table,
};
use crate::analysis::role::less_is_better;
use sagnac_base::table::{Column, Role};
use sagnac_engine::chart::Limit;
use sagnac_report::answer::reading::Reading;
use sagnac_report::answer::{AnswerCell, Kind, MAX_ROWS, MAX_WORDS};
use sagnac_report::chart::figure::Shape;

pub(super) fn outline(question: &Question) -> Outline {
    let is_error = question.limit.is_some() || less_is_better(question.table, question.y, &question.rows);
    let mut choices = question.choices();
    let worst = |choice: &Choice| question.largest(&choice.rows.concat());
    if is_error {
        let size = |choice: &Choice| worst(choice).map_or(f64::INFINITY, |row| question.size(row));
        choices.sort_by(|a, b| b.is_usable.cmp(&a.is_usable).then(size(a).total_cmp(&size(b))));
    }
    let conditions = question.columns();
    let judged = usize::from(question.limit.is_some());
    let places = places(question, &choices, judged);
    let standing =
        |choice: &Choice| question.limit.zip(worst(choice)).map(|(limit, row)| state(question, row, limit));
    let line = |choice: &Choice| {
        let mut cells: Vec<AnswerCell> = match (conditions.len() > 1, &places[..]) {
            // Curves under several conditions count at their largest.
            (true, _) => sampled(conditions.len(), judged)
                .into_iter()
                .map(|at| {
                    question
                        .largest(&choice.rows[at])
                        .map_or_else(AnswerCell::default, |row| question.reading(row).into())
                })
                .collect(),
            (false, []) | (false, [_]) => {
                let reading = worst(choice).map(|row| question.reading(row));
                let interval = reading.as_ref().and_then(Reading::interval_text).unwrap_or_default();
                vec![reading.map_or_else(AnswerCell::default, AnswerCell::from), interval.into()]
            }
            (false, places) => {
                let x = question.x;
                let at = |place: &f64| {
                    let row =
                        choice.rows[0].iter().copied().find(|&row| x.is_some_and(|x| x.value(row) == *place));
                    let known = row.filter(|&row| question.y.cells[row].number().is_some());
                    known.map_or_else(AnswerCell::default, |row| question.reading(row).into())
                };
                places.iter().map(at).collect()
            }
        };
        cells.extend(standing(choice).map(|state| AnswerCell::from(state.to_owned())));
        Line { name: choice.name.clone(), is_usable: choice.is_usable, cells }
    };
    let single = choices.first().filter(|choice| choices.len() == 1 && choice.name.is_empty());
    let (mut columns, mut lines) =
        (vec![question.heading()], choices.iter().map(line).collect::<Vec<Line>>());
    match (conditions.len() > 1, question.x, single) {
        (true, _, _) => {
            columns.extend(sampled(conditions.len(), judged).into_iter().map(|at| conditions[at].clone()))
        }
        (false, Some(x), Some(choice)) => {
            columns = vec![x.label.clone(), question.label(), "95 % interval".to_owned()];
            lines = along(question, x, &choice.rows[0]);
        }
        (false, Some(x), None) if places.len() > 1 => {
            columns = vec![question.heading_by(x)];
            columns.extend(at_places(x, &places));
        }
        _ => columns.extend([question.label(), "95 % interval".to_owned()]),
    }
    columns.extend(
        question.limit.filter(|_| single.is_none() || question.x.is_none()).map(|_| "limit".to_owned()),
    );
    let told = told(question, &choices, is_error);
    let (headline, value, kind) = told.unwrap_or_else(|| (String::new(), None, Kind::Estimate));
    let mut table = table(columns, lines);
    table.are_places = conditions.len() > 1 || places.len() > 1 && single.is_none();
    table.best = table.best.filter(|_| kind != Kind::Estimate && (single.is_none() || question.x.is_none()));
    // The largest value of a curve, where the answer has it.
    let is_told = |label: &String| {
        headline.contains(label.as_str()) || table.rows.iter().flatten().any(|cell| cell.text == *label)
    };
    let mark = |rows: &Vec<usize>| {
        let (x, row) = (question.x?, question.largest(rows)?);
        let label = question.reading(row).text();
        Some(Named {
            rows: rows.clone(),
            x: x.value(row),
            y: None,
            shape: Shape::Extremum,
            label,
            range: None,
        })
    };
    let curves = choices.iter().take(MAX_ROWS).flat_map(|choice| &choice.rows).filter(|_| is_error);
    let marks = curves.filter_map(mark).filter(|mark| is_told(&mark.label)).collect();
    Outline { kind, headline, value, table, marks, met: None }
}

/// A row for each of some places along a single curve.
pub(super) fn along(question: &Question, x: &Column, rows: &[usize]) -> Vec<Line> {
    let known: Vec<usize> =
        rows.iter().copied().filter(|&row| question.y.cells[row].number().is_some()).collect();
    let rows: Vec<usize> = spread(known.len(), MAX_ROWS).into_iter().map(|at| known[at]).collect();
    let names = at_places(x, &rows.iter().map(|&row| x.value(row)).collect::<Vec<_>>());
    let line = |(name, &row): (String, &usize)| {
        let value = question.reading(row);
        let interval = value.interval_text().unwrap_or_default();
        Line { name, is_usable: true, cells: vec![value.into(), interval.into()] }
    };
    names.into_iter().zip(&rows).map(line).collect()
}

/// The headline, its value and its kind: of errors the best option where it is worst, else the largest value.
fn told(question: &Question, choices: &[Choice], is_error: bool) -> Option<(String, Option<Reading>, Kind)> {
    let first = choices.first()?;
    let all = first.rows.concat();
    let row = match is_error {
        true => question.largest(&all)?,
        false => {
            let every: Vec<usize> = choices.iter().flat_map(|choice| choice.rows.concat()).collect();
            let is_signed = every.iter().any(|&row| question.y.value(row) < 0.0);
            let known =
                |rows: &[usize]| rows.iter().copied().rfind(|&row| question.y.cells[row].number().is_some());
            if is_signed { question.largest(&every)? } else { known(&all)? }
        }
    };
    let value = match is_error {
        true => question.reading(row),
        false => Reading::of_row(question.y, row),
    };
    let names = if is_error { first.long.clone() } else { place(&question.options, row) };
    if let Some(limit) = question.limit {
        let verb = if question.size(row) <= limit.value { "meets" } else { "misses" };
        return Some((
            requirement(question, &names, verb, limit, &value.with_interval()),
            Some(value),
            Kind::Requirement,
        ));
    }
    let given: Vec<_> =
        question.conditions.iter().copied().filter(|_| !question.options.is_empty() || !is_error).collect();
    let given = given.into_iter().chain(question.x).collect::<Vec<_>>();
    let at = place(&given, row);
    let at = if at.is_empty() { String::new() } else { format!(" at {at}") };
    let result = |at: &str| headline(&names, &format!("{} {}{at}", question.label(), value.with_interval()));
    let whole = result(&at);
    let brief = if whole.split_whitespace().count() > MAX_WORDS { result("") } else { whole };
    let kind = if is_error && choices.len() > 1 { Kind::Choice } else { Kind::Estimate };
    Some((brief, Some(value), kind))
}

/// A headline that says whether a limit is met.
pub(super) fn requirement(question: &Question, name: &str, verb: &str, limit: Limit, value: &str) -> String {
    let limit = Reading::new(&limited(limit), limit.value, None).text();
    let told =
        |subject: &str| format!("{} {verb} the {limit} limit: {value}", begun(subject)).replace(" = ", "=");
    let label = question.label();
    let whole = told(if name.is_empty() { &label } else { name });
    if whole.split_whitespace().count() > MAX_WORDS { told("this study") } else { whole }
}

/// The state of a limit in a row.
fn state(question: &Question, row: usize, limit: Limit) -> &'static str {
    let is_open = question
        .y
        .interval_of_magnitude(row)
        .is_some_and(|(low, high)| low <= limit.value && limit.value < high);
    match question.size(row) <= limit.value {
        _ if is_open => "inconclusive",
        true => "met",
        false => "not met",
    }
}

/// The places of the abscissa that are shown beside `judged` columns on the limit: where no option has a value at a place, there is none.
fn places(question: &Question, choices: &[Choice], judged: usize) -> Vec<f64> {
    let Some(x) = question.x else { return vec![] };
    let has_value =
        |&row: &usize| question.y.cells[row].number().is_some() && question.y.role != Role::Fraction;
    let rows = choices.iter().flat_map(|choice| choice.rows.concat()).filter(has_value);
    let mut places: Vec<f64> = rows.map(|row| x.value(row)).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    sampled(places.len(), judged).into_iter().map(|at| places[at]).collect()
}
