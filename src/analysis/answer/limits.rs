//! Answers against a limit: up to where each curve of options is good enough, and which part of a map is.

use crate::analysis::answer::{Line, Named, Outline, at, headline, options, sampled, table};
use crate::analysis::question::{Question, Rank, sort_best_first};
use sagnac_base::table::{Column, Window, windows};
use sagnac_engine::chart::Limit;
use sagnac_report::answer::reading::{Reading, joined, number, range, span, symbol};
use sagnac_report::answer::{AnswerCell, AnswerTable, Kind, MAX_COLUMNS, MAX_ROWS, Relation};
use sagnac_report::chart::figure::{Axis, Entry, Shape};
use sagnac_report::chart::map::{Cells, Map, Won};

/// The stretches of a curve that are within the limit.
struct Extent {
    windows: Vec<Window>,
    /// Number of points within the limit.
    within: usize,
    /// Number of points with a value.
    known: usize,
    /// The row with the largest value.
    largest: Option<usize>,
}

pub(super) fn outline(question: &Question, x: &Column, limit: Limit) -> Outline {
    let choices = question.choices();
    let extents: Vec<Vec<Extent>> = choices
        .iter()
        .map(|choice| choice.rows.iter().map(|rows| extent(question, x, rows, limit)).collect())
        .collect();
    let crosses = |extent: &Extent| !extent.windows.is_empty() && extent.windows != [[None, None]];
    if !extents.iter().flatten().any(crosses) {
        return options::outline_of_values(question);
    }
    let mut order: Vec<usize> = (0..choices.len()).collect();
    let within = |at: usize| extents[at].iter().map(|extent| extent.within).sum::<usize>();
    let largest = |at: usize| {
        let sizes = extents[at].iter().filter_map(|extent| Some(question.size(extent.largest?)));
        sizes.fold(0.0, f64::max)
    };
    // Conditions have no best one, and keep their order.
    let is_chosen = !question.options.is_empty();
    if is_chosen {
        sort_best_first(&mut order, |&at| Rank {
            is_usable: choices[at].is_usable,
            met: within(at),
            cost: largest(at),
        });
    }
    let conditions = question.columns();
    let is_single = conditions.len() == 1;
    let cell = |extent: &Extent| cell(x, &extent.windows);
    let line = |&at: &usize| {
        let mut cells: Vec<AnswerCell> = extents[at].iter().take(MAX_COLUMNS - 1).map(cell).collect();
        if is_single {
            let interval = interval(question, x, &choices[at].rows[0], limit, &extents[at][0]);
            let end = extents[at][0].windows.first().and_then(|window| window[1].or(window[0]));
            let interval = interval
                .zip(end)
                .and_then(|([low, high], end)| Reading::new(x, end, Some((low, high))).interval_text());
            let interval = interval.unwrap_or_default();
            let largest = extents[at][0].largest.map(|row| question.reading(row).into());
            cells.extend([AnswerCell::from(interval), largest.unwrap_or_default()]);
        }
        Line { name: choices[at].name.clone(), is_usable: choices[at].is_usable, cells }
    };
    let lines: Vec<Line> = order.iter().map(line).collect();
    let mut columns = vec![question.heading()];
    match is_single {
        true => {
            columns.push(format!("good for {}", x.label));
            columns.extend(["95 % interval".to_owned(), format!("largest {}", question.label())]);
        }
        false => columns.extend(conditions.iter().take(MAX_COLUMNS - 1).cloned()),
    }
    // The condition under which the best option is within the limit for the least part.
    let are_crossing = |&at: &usize| extents[at].iter().any(crosses);
    let hardest = order.iter().copied().filter(are_crossing).min_by_key(|&at| within(at));
    let best = if is_chosen { order[0] } else { hardest.unwrap_or(0) };
    let crossing = (0..extents[best].len()).filter(|&at| crosses(&extents[best][at]));
    let hardest = crossing.min_by_key(|&at| extents[best][at].within);
    let (headline, value) = match hardest {
        Some(condition) => {
            let extent = &extents[best][condition];
            let interval = interval(question, x, &choices[best].rows[condition], limit, extent);
            let under = match conditions[condition].as_str() {
                "" => String::new(),
                name => format!(" at {name}"),
            };
            let place = place(x, extent.windows[0]);
            let value = extent.windows[0][1]
                .or(extent.windows[0][0])
                .map(|place| Reading::new(x, place, interval.map(|[low, high]| (low, high))));
            let bracket = value.as_ref().map(Reading::in_brackets).unwrap_or_default();
            (headline(&choices[best].long, &format!("good {place}{under}{bracket}")), value)
        }
        None => {
            let row = question.largest(&choices[best].rows.concat());
            let value = row.map(|row| question.reading(row));
            let text = value.as_ref().map_or_else(String::new, Reading::with_interval);
            let verb = if within(best) > 0 { "meets" } else { "misses" };
            (options::requirement(question, &choices[best].long, verb, limit, &text), value)
        }
    };
    let shown = order.iter().take(MAX_ROWS).flat_map(|&at| {
        let extents = choices[at].rows.iter().zip(&extents[at]).take(MAX_COLUMNS - 1);
        extents.flat_map(|(rows, extent)| ends(x, rows, &extent.windows))
    });
    let marks = shown.collect();
    let mut table = table(columns, lines);
    table.are_places = !is_single;
    if !is_chosen && table.best.is_some() {
        table.best = table.rows.iter().position(|row| row[0].text == choices[best].name);
    }
    // Of options the best one counts, of conditions all.
    let counted = if is_chosen { &extents[best..=best] } else { &extents[..] };
    let of = |count: fn(&Extent) -> usize| counted.iter().flatten().map(count).sum();
    let met = Some([of(|extent| extent.within), of(|extent| extent.known)]);
    Outline { kind: Kind::Threshold, headline, value, table, marks, met, row: None }
}

fn extent(question: &Question, x: &Column, rows: &[usize], limit: Limit) -> Extent {
    let known = question.known(rows);
    let mut windows = windows(question.table, x, &known, limit.value, |row| question.y.value(row));
    // Beyond values that are missing, nothing is known.
    let [first, last] = [known.first(), known.last()].map(|row| row.map(|&row| x.value(row)));
    let is_missing = |is_beyond: &dyn Fn(f64) -> bool| rows.iter().any(|&row| is_beyond(x.value(row)));
    if let Some((window, first)) = windows.first_mut().zip(first)
        && window[0].is_none()
        && is_missing(&|place| place < first)
    {
        window[0] = Some(first);
    }
    if let Some((window, last)) = windows.last_mut().zip(last)
        && window[1].is_none()
        && is_missing(&|place| place > last)
    {
        window[1] = Some(last);
    }
    let within = known.iter().filter(|&&row| question.size(row) <= limit.value).count();
    Extent { windows, within, known: known.len(), largest: question.largest(&known) }
}

/// The range of the end of the first window of a curve between the places where both ends of its 95 % band cross the limit;
/// `None` for a window with two ends, and where a band does not cross it alike.
fn interval(
    question: &Question,
    x: &Column,
    rows: &[usize],
    limit: Limit,
    extent: &Extent,
) -> Option<[f64; 2]> {
    let known = question.known(rows);
    let end = |window: &Window| match window {
        [None, Some(end)] | [Some(end), None] => Some(*end),
        _ => None,
    };
    let place = end(extent.windows.first()?)?;
    let of_band = |pick: fn((f64, f64)) -> f64| {
        let value = |row: usize| question.y.interval_of_magnitude(row).map_or(f64::NAN, pick);
        let found = windows(question.table, x, &known, limit.value, value);
        (found.len() == extent.windows.len()).then(|| end(&found[0])).flatten()
    };
    let [one, other] = [of_band(|(low, _)| low)?, of_band(|(_, high)| high)?];
    let (low, high) = (one.min(other), one.max(other));
    let is_known = known.iter().all(|&row| question.y.interval(row).is_some());
    (is_known && low < high && low <= place && place <= high).then_some([low, high])
}

/// The ends of the windows that a cell names, as marks; the first of two has the label of both.
fn ends(x: &Column, rows: &[usize], windows: &[Window]) -> Vec<Named> {
    let mark = |x: f64, label: String| Named::at(rows, x, Shape::Crossing, label);
    let of_window = |window: &Window| match *window {
        [None, None] => vec![],
        [None, Some(end)] | [Some(end), None] => vec![mark(end, Reading::new(x, end, None).text())],
        [Some(from), Some(to)] => vec![mark(from, span(x, from, to)), mark(to, String::new())],
    };
    windows.iter().take(if windows.len() > 2 { 1 } else { 2 }).flat_map(of_window).collect()
}

/// A window as a cell.
fn cell(x: &Column, windows: &[Window]) -> AnswerCell {
    let text = |window: &Window| match window {
        [None, None] => "everywhere".to_owned(),
        [None, Some(end)] => format!("≤ {}", Reading::new(x, *end, None).text()),
        [Some(end), None] => format!("≥ {}", Reading::new(x, *end, None).text()),
        [Some(from), Some(to)] => span(x, *from, *to),
    };
    match windows {
        [] => "nowhere".to_owned().into(),
        [[None, Some(end)]] => AnswerCell::bounded(Relation::AtMost, Reading::new(x, *end, None)),
        [[Some(end), None]] => AnswerCell::bounded(Relation::AtLeast, Reading::new(x, *end, None)),
        [window] => text(window).into(),
        [first, second] => format!("{}, {}", text(first), text(second)).into(),
        [first, ..] => format!("{}, …", text(first)).into(),
    }
}

/// A window in a headline.
fn place(x: &Column, window: Window) -> String {
    match window {
        [None, None] => "everywhere".to_owned(),
        [None, Some(end)] => format!("up to {}", at(x, end)),
        [Some(end), None] => format!("from {}", at(x, end)),
        [Some(from), Some(to)] => {
            let to = Reading::new(x, to, None);
            let factor = if to.value == 0.0 { 1.0 } else { to.value / window[1].unwrap_or(to.value) };
            format!("from {} to {}", number(from * factor), joined(&number(to.value), &to.unit))
        }
    }
}

pub(super) fn of_map(map: &Map) -> Option<Outline> {
    match &map.cells {
        Cells::Winners { of, won, .. } => winners(map, &of.entries, won),
        Cells::Values(values) => of_values(map, values),
    }
}

/// For places along x, the values of y at which each option has the least value.
fn winners(map: &Map, options: &[Entry], won: &[Option<Won>]) -> Option<Outline> {
    let (columns, rows) = (map.columns.len(), map.rows.len());
    let wins = |style: usize| move |won: &Option<Won>| won.is_some_and(|won| won.style == style);
    let count = |option: &Entry| won.iter().filter(|won| wins(option.style)(won)).count();
    let mut shown: Vec<&Entry> = options.iter().filter(|option| count(option) > 0).collect();
    // The option that wins less often is told, as the others win everywhere else.
    shown.sort_by_key(|option| count(option));
    let places = sampled(columns, 0);
    let stretch = |style: usize, column: usize| {
        let wins: Vec<usize> = (0..rows).filter(|row| wins(style)(&won[row * columns + column])).collect();
        let (Some(&first), Some(&last)) = (wins.first(), wins.last()) else {
            return ("never".to_owned(), None);
        };
        let is_whole = wins.len() == last - first + 1;
        let y = |row: usize| map.rows[row];
        let border = |low: usize, high: usize| range(&number(y(low)), &number(y(high)));
        match (first, last == rows - 1) {
            _ if !is_whole => ("in part".to_owned(), None),
            (0, true) => ("always".to_owned(), None),
            (0, false) => (format!("below {}", border(last, last + 1)), None),
            (_, true) => (format!("above {}", border(first - 1, first)), Some(first)),
            _ => (range(&number(y(first)), &number(y(last))), None),
        }
    };
    let row = |option: &&Entry| (option.name.clone(), option.style);
    let heading = format!("least {} by {}", map.z.label, map.y.label);
    let table = by_place(map, heading, shown.iter().map(row), |style, column| stretch(style, column).0);
    let &Entry { style, ref name } = *shown.first()?;
    // Where it begins to win at the lowest y, of the places in the table.
    let begins = places.iter().filter_map(|&column| Some((column, stretch(style, column).1?)));
    let (headline, value) = match begins.min_by_key(|&(_, row)| row) {
        Some((column, row)) if row > 0 => {
            let y = range(&number(map.rows[row - 1]), &number(map.rows[row]));
            let x = valued(&map.x, map.columns[column]);
            let text = format!("{name} wins above {} {} at {x}", short(&map.y), joined(&y, &map.y.unit));
            let value = Reading {
                quantity: map.y.label.clone(),
                value: map.rows[row],
                unit: map.y.unit.clone(),
                interval: Some([map.rows[row - 1], map.rows[row]]),
            };
            (headline("", &text), Some(value))
        }
        _ => {
            (headline("", &format!("{} has the least {} most often", shown.last()?.name, map.z.label)), None)
        }
    };
    Some(Outline { kind: Kind::Map, headline, value, table, met: met(map), ..Outline::default() })
}

/// A table with columns for some places along x, and rows with a name each.
fn by_place(
    map: &Map,
    heading: String,
    rows: impl Iterator<Item = (String, usize)>,
    cell: impl Fn(usize, usize) -> String,
) -> AnswerTable {
    let places = sampled(map.columns.len(), 0);
    let headings = places.iter().map(|&column| valued(&map.x, map.columns[column]));
    let row = |(name, of): (String, usize)| {
        let cells = places.iter().map(|&column| cell(of, column).into());
        std::iter::once(AnswerCell::from(name)).chain(cells).collect()
    };
    AnswerTable {
        columns: std::iter::once(heading).chain(headings).collect(),
        rows: rows.map(row).collect(),
        are_places: true,
        ..AnswerTable::default()
    }
}

/// The cells whose winner is within the limit, and all with a winner.
fn met(map: &Map) -> Option<[usize; 2]> {
    Some([map.within_limit()?, map.known()])
}

/// Values at places along both axes.
fn of_values(map: &Map, values: &[Option<f64>]) -> Option<Outline> {
    let columns = map.columns.len();
    let known = values.iter().enumerate().filter_map(|(at, value)| Some((at, (*value)?)));
    let (cell, value) = known.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let rows = sampled(map.rows.len(), 0).into_iter().map(|row| (valued(&map.y, map.rows[row]), row));
    let shown = |value: f64| joined(&number(value), &map.z.unit);
    let table = by_place(map, map.z.label.clone(), rows, |row, column| {
        values[row * columns + column].map_or_else(String::new, shown)
    });
    let value = Reading { quantity: map.z.label.clone(), value, unit: map.z.unit.clone(), interval: None };
    let at = [(&map.x, map.columns[cell % columns]), (&map.y, map.rows[cell / columns])]
        .map(|(axis, at)| valued(axis, at));
    let headline = headline("", &format!("{}: at most {} at {}", map.z.label, value.text(), at.join(", ")));
    Some(Outline {
        kind: Kind::Map,
        headline,
        value: Some(value),
        table,
        met: met(map),
        ..Outline::default()
    })
}

/// The part of a label that names it in few words.
fn short(axis: &Axis) -> &str {
    symbol(&axis.label)
}

/// A value of an axis, after its label where it has no unit.
fn valued(axis: &Axis, value: f64) -> String {
    let unit = &axis.unit;
    match unit.is_empty() {
        true => format!("{} = {}", short(axis), number(value)),
        false => joined(&number(value), unit),
    }
}
