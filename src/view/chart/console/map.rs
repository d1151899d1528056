//! Maps as text: shades for values, letters for winners.

use crate::key::scale::Scale;
use crate::quantity::number::significant;
use crate::view::chart::console::Look;
use crate::view::chart::console::axes::{Frame, legend};
use crate::view::chart::figure::Grouping;
use crate::view::chart::map::{Cells, Map, Won};
use crate::view::chart::scale::Range;

/// Shades from the least to the largest value.
const SHADES: [char; 5] = ['·', '░', '▒', '▓', '█'];
const SHADES_ASCII: [char; 5] = ['.', ':', '+', '*', '#'];

pub(crate) fn text(map: &Map, look: Look) -> String {
    let (columns, rows) = (map.x.scale.edges(&map.columns), map.y.scale.edges(&map.rows));
    let covered = |scale: Scale, edges: &[f64]| match edges {
        [low, .., high] => Range { scale, low: *low, high: *high },
        _ => Range::around(scale, []),
    };
    let (x, y) = (covered(map.x.scale, &columns), covered(map.y.scale, &rows));
    let frame = Frame::new((&map.x, x), (&map.y, y), look);
    let mut page = frame.page();
    let shades = Shades::of(map);
    for row in 0..page.rows {
        for column in 0..page.columns {
            let across = (column as f64 + 0.5) / page.columns as f64;
            let up = 1.0 - (row as f64 + 0.5) / page.rows as f64;
            let cell = at(&x, &columns, across).zip(at(&y, &rows, up));
            let found = cell.and_then(|(i, j)| sign(map, &shades, j * map.columns.len() + i, look));
            if let Some((sign, colour)) = found {
                page.sign((across, up), sign, colour);
            }
        }
    }
    let mut text = format!("{}\n", look.spelled(&map.title));
    text += &frame.drawn(&page);
    text += &legend(&entries(map, &shades, look), look);
    text
}

/// The cell between `edges` that lies at a fraction of the length of an axis.
fn at(range: &Range, edges: &[f64], part: f64) -> Option<usize> {
    let place = edges.iter().position(|&edge| range.fraction(edge) > part)?;
    place.checked_sub(1)
}

fn sign(map: &Map, shades: &Shades, cell: usize, look: Look) -> Option<(char, Option<usize>)> {
    match &map.cells {
        Cells::Values(values) => Some((shades.sign(values[cell]?, look), None)),
        Cells::Winners { won, .. } => {
            let won = won[cell]?;
            let over = map.limit.as_ref().is_some_and(|limit| won.value > limit.value);
            Some((letter(won, over), Some(won.style)))
        }
    }
}

/// A capital for a certain winner, a small letter for an uncertain one, and a dot where no competitor is within the
/// limit.
fn letter(won: Won, over: bool) -> char {
    let letter = (b'A' + (won.style % 26) as u8) as char;
    match (over, won.certain) {
        (true, _) => '.',
        (false, true) => letter,
        (false, false) => letter.to_ascii_lowercase(),
    }
}

/// The boundaries between shades, ascending; a limit is one of them.
struct Shades {
    ends: Vec<f64>,
}

impl Shades {
    fn of(map: &Map) -> Shades {
        let Cells::Values(values) = &map.cells else { return Shades { ends: vec![] } };
        let known = || values.iter().flatten().copied();
        let low = known().fold(f64::INFINITY, f64::min);
        let high = known().fold(f64::NEG_INFINITY, f64::max);
        let part = |low: f64, high: f64, part: f64| match map.z.scale {
            Scale::Log => libm::pow(10.0, libm::log10(low) + part * (libm::log10(high) - libm::log10(low))),
            Scale::Linear => low + part * (high - low),
        };
        let limit = map.limit.as_ref().map(|limit| limit.value).filter(|limit| (low..high).contains(limit));
        let ends = match limit {
            // Two shades within the limit, three beyond it.
            Some(limit) => {
                vec![part(low, limit, 0.5), limit, part(limit, high, 1.0 / 3.0), part(limit, high, 2.0 / 3.0)]
            }
            None => (1..5).map(|end| part(low, high, f64::from(end) / 5.0)).collect(),
        };
        Shades { ends }
    }

    fn sign(&self, value: f64, look: Look) -> char {
        let shades = if look.unicode { SHADES } else { SHADES_ASCII };
        shades[self.ends.iter().filter(|&&end| value > end).count()]
    }
}

fn entries(map: &Map, shades: &Shades, look: Look) -> Vec<String> {
    let mut entries = match &map.cells {
        Cells::Values(_) => of_values(map, shades, look),
        Cells::Winners { of, banded, .. } => of_winners(map, of, *banded, look),
    };
    entries.extend(map.chosen.iter().map(|chosen| look.spelled(chosen)));
    entries
}

fn of_values(map: &Map, shades: &Shades, look: Look) -> Vec<String> {
    let signs = if look.unicode { SHADES } else { SHADES_ASCII };
    let mut entries = vec![look.spelled(&map.z.title())];
    for (at, sign) in signs.iter().enumerate() {
        let end = |at: usize| shades.ends.get(at).map(|end| significant(*end, 3));
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
    let letter = |style: usize| (b'A' + (style % 26) as u8) as char;
    entries.extend(
        of.entries.iter().map(|entry| format!("{} {}", letter(entry.style), look.spelled(&entry.name))),
    );
    if banded {
        entries.push("small letters: bands overlap".to_owned());
    }
    entries.extend(map.limit.iter().map(|limit| look.spelled(&format!(". over the {}", limit.label))));
    entries
}
