//! Output for a study of one point: its fillers side by side, and the best one for each error.

use sagnac::quantity::number::significant;
use sagnac::table::{Cell, Column, Role, Table, Usual};

use crate::terminal::{aligned, distinct, number};

/// A line for each filler with the estimates of a summary for each error; then the filler with the least value of the
/// answer, a 99.73 % level, and the distance of the next one.
pub fn one_point(table: &Table) -> String {
    let keys: Vec<&Column> = table.columns.iter().filter(|column| column.role == Role::Key).collect();
    let estimates: Vec<&Column> = table.columns.iter().filter(|column| column.brief).collect();
    let ([fillers, errors], Some(level)) = (&keys[..], table.usual(Usual::Answer)) else {
        return String::new();
    };
    // The word that all labels share is omitted.
    let name = |column: &Column| column.label.trim_end_matches(" error").to_owned();
    let different = |column: &Column| -> Vec<String> {
        let texts: Vec<String> = column.cells.iter().map(Cell::text).collect();
        distinct(texts.iter()).1.into_iter().map(|first| texts[first].clone()).collect()
    };
    let (names, kinds) = (different(fillers), different(errors));
    let row_of = |filler: &str, error: &str| {
        (0..table.rows())
            .find(|&row| fillers.cells[row].text() == filler && errors.cells[row].text() == error)
    };
    let mut lines = vec![vec![fillers.label.clone()]];
    lines.extend(names.iter().map(|name| vec![name.clone()]));
    for (kind, column) in kinds.iter().flat_map(|kind| estimates.iter().map(move |column| (kind, column))) {
        let values: Vec<Option<f64>> =
            names.iter().map(|name| column.cells[row_of(name, kind)?].number()).collect();
        // What is sampled has a band, and is shown even where it is blank.
        if column.band.is_none() && values.iter().all(Option::is_none) {
            continue;
        }
        lines[0].push(format!("{kind} {}, {}", name(column), column.unit.symbol));
        for (line, value) in lines[1..].iter_mut().zip(values) {
            line.push(number(value, 4));
        }
    }
    let mut text = aligned(&lines);
    for kind in &kinds {
        let levels = names.iter().filter_map(|name| Level::of(name, level, row_of(name, kind)?));
        if let Some(sentence) = least(levels.collect()) {
            text += &format!("\nleast {} {kind}: {sentence}", name(level));
        }
    }
    text + "\n"
}

/// The 99.73 % level of one filler.
struct Level<'n> {
    name: &'n str,
    value: f64,
    /// Its 95 % interval, if there are enough trials to bound it; that of a closed form has no width.
    band: Option<(f64, f64)>,
}

impl<'n> Level<'n> {
    fn of(name: &'n str, column: &Column, row: usize) -> Option<Level<'n>> {
        let value = column.cells[row].number()?;
        let band = column.band.as_ref().map_or(Some((value, value)), |band| band.get(row).copied().flatten());
        Some(Level { name, value, band })
    }
}

/// The filler with the least level, or all of them if several are equal, and the distance of the next one; `None` for a
/// single level.
fn least(mut levels: Vec<Level>) -> Option<String> {
    levels.sort_by(|a, b| a.value.total_cmp(&b.value));
    let (first, others) = levels.split_first().filter(|(_, others)| !others.is_empty())?;
    // Equal to the nine digits that files show.
    let equal = others.iter().take_while(|level| level.value - first.value <= 1e-9 * level.value).count();
    let names: Vec<&str> = levels[..=equal].iter().map(|level| level.name).collect();
    let best = format!("{}, {} arcsec", names.join(" = "), significant(first.value, 4));
    let Some(next) = others.get(equal) else { return Some(best) };
    let ratio = next.value / first.value;
    let more = match ratio {
        r if r < 1.1 => format!("{} % more", significant(100.0 * (r - 1.0), 2)),
        r if r.is_finite() => format!("{} times that", significant(r, 3)),
        _ => format!("{} arcsec", significant(next.value, 4)),
    };
    let close = match (first.band, next.band) {
        (Some((_, high)), Some((low, _))) if low > high => "",
        (Some(_), Some(_)) => ", and the 95 % intervals overlap",
        _ => ", and the trials are too few to bound the difference",
    };
    Some(format!("{best}; next {}, {more}{close}", next.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sentence for levels with these half widths of their intervals.
    fn said(levels: &[(&str, f64, f64)]) -> String {
        let level = |&(name, value, width)| Level { name, value, band: Some((value - width, value + width)) };
        least(levels.iter().map(level).collect()).unwrap_or_default()
    }

    #[test]
    fn equal_fillers_share_the_first_place() {
        assert_eq!(
            said(&[("quadratic", 986.7, 1.0), ("mine", 986.7, 1.0)]),
            "quadratic = mine, 986.7 arcsec"
        );
        let three = said(&[("const", 156.0, 1.0), ("mine", 312.0, 1.0), ("linear", 156.0, 1.0)]);
        assert_eq!(three, "const = linear, 156 arcsec; next mine, 2 times that");
    }

    #[test]
    fn a_lead_within_the_uncertainty_is_said_to_be_such() {
        assert_eq!(
            said(&[("a", 100.0, 2.0), ("b", 103.0, 2.0)]),
            "a, 100 arcsec; next b, 3 % more, and the 95 % intervals overlap"
        );
        assert_eq!(said(&[("a", 100.0, 1.0), ("b", 103.0, 1.0)]), "a, 100 arcsec; next b, 3 % more");
        assert_eq!(said(&[("a", 0.0, 0.0), ("b", 103.0, 1.0)]), "a, 0 arcsec; next b, 103 arcsec");
        assert_eq!(said(&[("a", 100.0, 2.0)]), "");
        let unbounded = ["a", "b"].map(|name| Level { name, value: name.len() as f64, band: None });
        assert_eq!(least(unbounded.into()).as_deref(), Some("a = b, 1 arcsec"));
    }
}
