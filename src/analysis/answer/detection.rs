//! From which value on at least half of the records show a coefficient.

use crate::analysis::answer::{Line, Named, Outline, Question, at, headline, table};
use sagnac_base::table::Column;
use sagnac_base::table::crossing::between;
use sagnac_engine::kinds::allan::columns::is_absent;
use sagnac_report::answer::reading::percent_of;
use sagnac_report::answer::{AnswerCell, Kind, Reading};
use sagnac_report::chart::figure::Shape;

/// The part of records from which on a coefficient counts as shown.
const HALF: f64 = 0.5;

pub(super) fn outline(question: &Question, x: &Column) -> Outline {
    let (mut lines, mut marks) = (Vec::new(), Vec::new());
    let mut told: Option<(String, f64, bool)> = None;
    for choice in question.choices() {
        let rows: Vec<usize> = choice
            .rows
            .concat()
            .into_iter()
            .filter(|&row| question.y.cells[row].number().is_some())
            .collect();
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
                marks.push(Named {
                    rows: rows.clone(),
                    x: place,
                    y: Some(HALF),
                    shape: Shape::Crossing,
                    label,
                    range: None,
                });
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
    Outline { kind: Kind::Threshold, headline, value, table, marks, met: None }
}
