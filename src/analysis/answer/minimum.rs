//! The least values of curves over the averaging time.

use crate::analysis::answer::{Line, Named, Outline, Question, at, headline, joined_names, table};
use crate::analysis::notch::Notches;
use sagnac_base::table::Column;
use sagnac_report::answer::{AnswerCell, Kind, MAX_ROWS, Reading};
use sagnac_report::chart::figure::Shape;

/// Most words of a name with labels in a headline.
const MAX_WORDS: usize = 5;

pub(super) fn outline(question: &Question, x: &Column) -> Outline {
    let (choices, conditions) = (question.choices(), question.columns());
    let notches =
        Notches::of(x, question.y, choices.iter().flat_map(|choice| choice.rows.iter().map(Vec::as_slice)));
    let mut found: Vec<(String, String, bool, usize, &[usize])> = Vec::new();
    for choice in &choices {
        for (rows, condition) in choice.rows.iter().zip(&conditions) {
            let known = rows
                .iter()
                .copied()
                .filter(|&row| question.y.cells[row].number().is_some() && !notches.are_at(x.value(row)));
            let Some(row) = known.min_by(|&a, &b| question.size(a).total_cmp(&question.size(b))) else {
                continue;
            };
            let named = |name: &str| joined_names(name, condition);
            found.push((named(&choice.name), named(&choice.long), choice.is_usable, row, rows));
        }
    }
    found.sort_by(|a, b| b.2.cmp(&a.2).then(question.size(a.3).total_cmp(&question.size(b.3))));
    let line = |(name, _, is_usable, row, _): &(String, String, bool, usize, &[usize])| {
        let least = question.reading(*row);
        let interval = least.interval_text().unwrap_or_default();
        let cells =
            vec![least.into(), AnswerCell::from(interval), Reading::new(x, x.value(*row), None).into()];
        Line { name: name.clone(), is_usable: *is_usable, cells }
    };
    let lines = found.iter().map(line).collect();
    let mark = |(.., row, rows): &(String, String, bool, usize, &[usize])| Named {
        rows: rows.to_vec(),
        x: x.value(*row),
        y: None,
        shape: Shape::Extremum,
        label: question.reading(*row).text(),
        range: None,
    };
    let marks = found.iter().take(MAX_ROWS).map(mark).collect();
    let labels = question.options.iter().chain(&question.conditions).map(|column| column.label.as_str());
    let columns = vec![
        labels.collect::<Vec<_>>().join(", "),
        format!("least {}", question.label()),
        "95 % interval".to_owned(),
        format!("at {}", x.label),
    ];
    let (headline, value) = match found.first() {
        Some((name, long, _, row, _)) => {
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
    Outline { kind: Kind::Choice, headline, value, table: table(columns, lines), marks, met: None }
}
