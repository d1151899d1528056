//! The places at which curves peak.

use crate::analysis::answer::{Line, Named, Outline, Question, at, headline, table};
use sagnac_base::table::Column;
use sagnac_report::answer::{AnswerCell, Kind, MAX_COLUMNS, Reading};
use sagnac_report::chart::figure::Shape;

/// The peaks of curves of which each has some; `None` for others.
pub(super) fn outline(question: &Question, x: &Column) -> Option<Outline> {
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
            Named { rows: rows.clone(), x: x.value(row), y: None, shape: Shape::Extremum, label, range: None }
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
        met: None,
    })
}
