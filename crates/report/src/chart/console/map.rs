//! Maps as text: shades for values, letters for winners.

use crate::chart::console::Look;
use crate::chart::console::axes::Frame;
use crate::chart::figure::Grouping;
use crate::chart::map::{Cells, Map};
use crate::chart::scale::edges;
use crate::chart::scale::{Range, extent};
use sagnac_base::quantity::number::significant;

/// Shades from the least to the largest value.
const SHADES: [char; 5] = ['·', '░', '▒', '▓', '█'];
const SHADES_ASCII: [char; 5] = ['.', ':', '+', '*', '#'];

/// The map as text.
pub fn text(map: &Map, look: Look) -> String {
    let (columns, rows) = (edges(map.x.scale, &map.columns), edges(map.y.scale, &map.rows));
    let (x, y) = (Range::between(map.x.scale, &columns), Range::between(map.y.scale, &rows));
    let frame = Frame::new((&map.x, x), (&map.y, y), look);
    let mut page = frame.page();
    let ends = ends(map);
    for row in 0..page.rows {
        for column in 0..page.columns {
            let across = (column as f64 + 0.5) / page.columns as f64;
            let up = 1.0 - (row as f64 + 0.5) / page.rows as f64;
            let cell = at(&x, &columns, across).zip(at(&y, &rows, up));
            let found = cell.and_then(|(i, j)| sign(map, &ends, j * map.columns.len() + i, look));
            if let Some((sign, colour)) = found {
                page.sign((across, up), sign, colour);
            }
        }
    }
    let entries = match &map.cells {
        Cells::Values(_) => of_values(map, &ends, look),
        Cells::Winners { of, banded, .. } => of_winners(map, of, *banded, look),
    };
    frame.text(&map.title, &page, entries, &map.chosen)
}

/// The cell between `edges` that lies at a fraction of the length of an axis.
fn at(range: &Range, edges: &[f64], part: f64) -> Option<usize> {
    let place = edges.iter().position(|&edge| range.fraction(edge) > part)?;
    place.checked_sub(1)
}

/// The character of a cell with its colour. A winner has a capital if it is certain, else a small letter, and a dot
/// where no competitor is within the limit.
fn sign(map: &Map, ends: &[f64], cell: usize, look: Look) -> Option<(char, Option<usize>)> {
    match &map.cells {
        Cells::Values(values) => {
            let value = values[cell]?;
            Some((look.either(SHADES, SHADES_ASCII)[ends.iter().filter(|&&end| value > end).count()], None))
        }
        Cells::Winners { won, .. } => {
            let won = won[cell]?;
            let over = map.limit.as_ref().is_some_and(|limit| won.value > limit.value);
            let sign = match (over, won.certain) {
                (true, _) => '.',
                (false, true) => letter(won.style),
                (false, false) => letter(won.style).to_ascii_lowercase(),
            };
            Some((sign, Some(won.style)))
        }
    }
}

fn letter(style: usize) -> char {
    (b'A' + (style % 26) as u8) as char
}

/// The boundaries between shades, ascending; a limit is one of them.
fn ends(map: &Map) -> Vec<f64> {
    let Cells::Values(values) = &map.cells else { return vec![] };
    let known = values.iter().flatten().copied();
    let (low, high) = extent(known).unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
    let scale = map.z.scale;
    let part = |low: f64, high: f64, part: f64| {
        let [low, high] = [low, high].map(|end| scale.coordinate(end));
        scale.value(low + part * (high - low))
    };
    let limit = map.limit.as_ref().map(|limit| limit.value).filter(|limit| (low..high).contains(limit));
    match limit {
        // Two shades within the limit, three beyond it.
        Some(limit) => {
            vec![part(low, limit, 0.5), limit, part(limit, high, 1.0 / 3.0), part(limit, high, 2.0 / 3.0)]
        }
        None => (1..5).map(|end| part(low, high, f64::from(end) / 5.0)).collect(),
    }
}

fn of_values(map: &Map, ends: &[f64], look: Look) -> Vec<String> {
    let mut entries = vec![look.spelled(&map.z.title())];
    for (at, sign) in look.either(SHADES, SHADES_ASCII).iter().enumerate() {
        let end = |at: usize| ends.get(at).map(|end| significant(*end, 3));
        let stretch = match (at.checked_sub(1).and_then(end), end(at)) {
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (None, Some(high)) => format!("up to {high}"),
            (Some(low), None) => format!("above {low}"),
            (None, None) => continue,
        };
        entries.push(format!("{sign} {stretch}"));
    }
    entries.extend(map.limit.iter().map(|limit| look.spelled(&limit.label)));
    entries
}

fn of_winners(map: &Map, of: &Grouping, banded: bool, look: Look) -> Vec<String> {
    let mut entries = vec![look.spelled(&format!("least {}", map.z.title()))];
    entries.extend(
        of.entries.iter().map(|entry| format!("{} {}", letter(entry.style), look.spelled(&entry.name))),
    );
    if banded {
        entries.push("small letters: bands overlap".to_owned());
    }
    entries.extend(map.limit.iter().map(|limit| look.spelled(&format!(". over the {}", limit.label))));
    entries
}
