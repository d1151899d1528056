//! Answers that compare options: their values side by side, and the value of the abscissa at which each is best; and answers
//! from features of curves: where records show a coefficient, minima, and peaks.

use crate::analysis::answer::{
    Line, Named, Outline, at, at_place, at_places, begun, headline, joined_names, place, reading_of_limit,
    sampled, spread, table,
};
use crate::analysis::question::{Choice, Notches, Question, Rank, less_is_better, sort_best_first};
use sagnac_base::table::{Column, Role, between};
use sagnac_engine::chart::Limit;
use sagnac_engine::kinds::allan::columns::is_absent;
use sagnac_report::answer::reading::{Reading, percent_of, span};
use sagnac_report::answer::{AnswerCell, Kind, MAX_COLUMNS, MAX_ROWS, MAX_WORDS};
use sagnac_report::chart::figure::Shape;

pub(super) fn outline_of_values(question: &Question) -> Outline {
    let is_error = question.limit.is_some() || less_is_better(question.table, question.y, &question.rows);
    let mut choices = question.choices();
    let worst = |choice: &Choice| question.largest(&choice.rows.concat());
    if is_error {
        sort_best_first(&mut choices, |choice| {
            let cost = worst(choice).map_or(f64::INFINITY, |row| question.size(row));
            Rank { is_usable: choice.is_usable, met: 0, cost }
        });
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
                    let known = row.and_then(|row| question.known(&[row]).pop());
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
    let mut outline = headed(question, &choices, is_error).unwrap_or_default();
    let kind = outline.kind;
    let mut table = table(columns, lines);
    table.are_places = conditions.len() > 1 || places.len() > 1 && single.is_none();
    table.best = table.best.filter(|_| kind != Kind::Estimate && (single.is_none() || question.x.is_none()));
    // The largest value of a curve, where the answer has it; of what is no error, the value of the headline.
    let is_told = |label: &String| {
        outline.headline.contains(label.as_str())
            || table.rows.iter().flatten().any(|cell| cell.text == *label)
    };
    let mark = |rows: &Vec<usize>| {
        let x = question.x?;
        let row = match is_error {
            true => question.largest(rows)?,
            false => outline.row.filter(|row| rows.contains(row))?,
        };
        let label = question.reading(row).text();
        Some(Named::at(rows, x.value(row), Shape::Extremum, label))
    };
    let curves = choices.iter().take(MAX_ROWS).flat_map(|choice| &choice.rows);
    outline.marks = curves.filter_map(mark).filter(|mark| is_told(&mark.label)).collect();
    Outline { table, ..outline }
}

/// A row for each of some places along a single curve.
fn along(question: &Question, x: &Column, rows: &[usize]) -> Vec<Line> {
    let known = question.known(rows);
    let rows: Vec<usize> = spread(known.len(), MAX_ROWS).into_iter().map(|at| known[at]).collect();
    let names = at_places(x, &rows.iter().map(|&row| x.value(row)).collect::<Vec<_>>());
    let line = |(name, &row): (String, &usize)| {
        let value = question.reading(row);
        let interval = value.interval_text().unwrap_or_default();
        Line { name, is_usable: true, cells: vec![value.into(), interval.into()] }
    };
    names.into_iter().zip(&rows).map(line).collect()
}

/// An answer without its table: of errors the best option where it is worst, else the largest value.
fn headed(question: &Question, choices: &[Choice], is_error: bool) -> Option<Outline> {
    let first = choices.first()?;
    let all = first.rows.concat();
    let row = match is_error {
        true => question.largest(&all)?,
        false => {
            let every: Vec<usize> = choices.iter().flat_map(|choice| choice.rows.concat()).collect();
            let is_signed = every.iter().any(|&row| question.y.value(row) < 0.0);
            if is_signed { question.largest(&every)? } else { question.known(&all).pop()? }
        }
    };
    let value = match is_error {
        true => question.reading(row),
        false => Reading::of_row(question.y, row),
    };
    let names = if is_error { first.long.clone() } else { place(&question.options, row) };
    if let Some(limit) = question.limit {
        let verb = if question.size(row) <= limit.value { "meets" } else { "misses" };
        let headline = requirement(question, &names, verb, limit, &value.with_interval());
        return Some(Outline {
            kind: Kind::Requirement,
            headline,
            value: Some(value),
            row: Some(row),
            ..Outline::default()
        });
    }
    let given: Vec<_> =
        question.conditions.iter().copied().filter(|_| !question.options.is_empty() || !is_error).collect();
    let given = given.into_iter().chain(question.x).collect::<Vec<_>>();
    let at = place(&given, row);
    let at = if at.is_empty() { String::new() } else { format!(" at {at}") };
    // What is left at a place where it is least.
    let least = question.least_beside(row).map_or_else(String::new, |least| format!(": {}", least.text()));
    let result =
        |end: &str| headline(&names, &format!("{} {}{end}", question.label(), value.with_interval()));
    let headline = first_that_fits([result(&format!("{at}{least}")), result(&at), result("")]);
    let kind = if is_error && choices.len() > 1 { Kind::Choice } else { Kind::Estimate };
    Some(Outline { kind, headline, value: Some(value), row: Some(row), ..Outline::default() })
}

/// The first of some headlines that is short enough, else the last one.
fn first_that_fits<const N: usize>(headlines: [String; N]) -> String {
    let fits = |headline: &String| headline.split_whitespace().count() <= MAX_WORDS;
    let at = headlines.iter().position(fits).unwrap_or(N - 1);
    headlines.into_iter().nth(at).unwrap_or_default()
}

/// A headline that says whether a limit is met.
pub(super) fn requirement(question: &Question, name: &str, verb: &str, limit: Limit, value: &str) -> String {
    let limit = reading_of_limit(limit).text();
    let told =
        |subject: &str| format!("{} {verb} the {limit} limit: {value}", begun(subject)).replace(" = ", "=");
    let label = question.label();
    first_that_fits([told(if name.is_empty() { &label } else { name }), told("this study")])
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
    /// Whether it is at an end of several values of x.
    is_end: bool,
}

/// The curves of options and conditions at their least values, without some values of x.
fn curves_at_least(
    question: &Question,
    x: &Column,
    choices: &[Choice],
    is_left_out: impl Fn(f64) -> bool,
) -> Vec<Least> {
    let conditions = question.columns();
    let mut found = Vec::new();
    for choice in choices {
        for (rows, condition) in choice.rows.iter().zip(&conditions) {
            let mut known = question.known(rows);
            known.retain(|&row| !is_left_out(x.value(row)));
            let size = |at: usize| question.size(known[at]);
            let Some(best) = (0..known.len()).min_by(|&a, &b| size(a).total_cmp(&size(b))) else { continue };
            let around = |is_in: &dyn Fn(usize) -> bool| {
                let holds = |at: &usize| *at == best || is_in(known[*at]);
                let first = (0..=best).rev().take_while(holds).last();
                let last = (best..known.len()).take_while(holds).last();
                [first, last].map(|at| x.value(known[at.unwrap_or(best)]))
            };
            let row = known[best];
            let named = |name: &str| joined_names(name, condition);
            found.push(Least {
                name: named(&choice.name),
                long: named(&choice.long),
                is_usable: choice.is_usable,
                rows: rows.clone(),
                row,
                flat: around(&|other| question.size(other) <= (1.0 + FLAT) * question.size(row)),
                alike: around(&|other| question.y.is_alike(other, row)),
                is_end: known.len() > 1 && (best == 0 || best == known.len() - 1),
            });
        }
    }
    found
}

/// Sorts curves from the best one on.
fn sort_curves(question: &Question, found: &mut [Least]) {
    sort_best_first(found, |least| Rank {
        is_usable: least.is_usable,
        met: 0,
        cost: question.size(least.row),
    });
}

pub(super) fn outline_of_optimum(question: &Question, x: &Column) -> Outline {
    let choices = question.choices();
    let mut found = curves_at_least(question, x, &choices, |_| false);
    if !question.options.is_empty() {
        sort_curves(question, &mut found);
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
            let end = least.is_end.then_some("end");
            let with: Vec<&str> =
                Some(&*least.long).filter(|long| !long.is_empty()).into_iter().chain(end).collect();
            let with = if with.is_empty() { String::new() } else { format!(" ({})", with.join(", ")) };
            let (best, left) = (at(x, x.value(least.row)), question.reading(least.row));
            let told = |left: &str| headline("", &format!("best {}: {best}{with}{left}", x.label));
            let left = [left.with_interval(), left.text()].map(|left| told(&format!(": {left}")));
            let [with_interval, without] = left;
            (
                first_that_fits([with_interval, without, told("")]),
                Some(Reading::new(x, x.value(least.row), Some((least.flat[0], least.flat[1])))),
            )
        }
        None => (String::new(), None),
    };
    if let (true, [choice]) = (is_single, &choices[..]) {
        lines = along(question, x, &choice.rows[0]);
        columns = vec![x.label.clone(), question.label(), "95 % interval".to_owned()];
    }
    // The range is that of the headline alone, as several would cover each other.
    let mark = |least: &Least| {
        let best = x.value(least.row);
        let is_told = told.is_some_and(|told| told.row == least.row);
        let range = Some(least.flat).filter(|[from, to]| from < to && is_told);
        Named { range, ..Named::at(&least.rows, best, Shape::Extremum, Reading::new(x, best, None).text()) }
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
    Outline { kind: Kind::Optimum, headline, value, table, marks, ..Outline::default() }
}

/// The labels of options and conditions.
fn heading(question: &Question) -> String {
    let labels = question.options.iter().chain(&question.conditions).map(|column| column.label.as_str());
    labels.collect::<Vec<_>>().join(", ")
}

fn range(x: &Column, [from, to]: [f64; 2]) -> String {
    if from == to { Reading::new(x, from, None).text() } else { span(x, from, to) }
}

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
const MAX_WORDS_OF_NAME: usize = 5;

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
            let long = if long.split(' ').count() > MAX_WORDS_OF_NAME { name } else { long };
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
