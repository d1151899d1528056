//! The series with the least value in each cell.

use crate::chart::coincidence::{merge_entries, names_of, near};
use crate::chart::figure::Entry;
use crate::chart::map::{Estimate, Won};

/// Finds the winner of each cell in which every entry has a value: the entry with the least one.
///
/// Entries that agree in all cells become one, named `const = linear`; the names of such entries are returned. Several
/// winners of single cells, which no merging of their entries explains, get an entry of their own. Values are equal if
/// they agree to the nine digits that files show.
pub fn winners(
    entries: &mut Vec<Entry>,
    values: &[Vec<Option<Estimate>>],
) -> (Vec<Option<Won>>, Vec<String>) {
    let styles = entries.len();
    let merged = merge_entries(entries, |a, b| same_series(&values[a.style], &values[b.style]));
    let merged = names_of(entries, &merged);
    let cells = values.first().map_or(0, Vec::len);
    let mut ties: Vec<Entry> = vec![];
    let won = (0..cells).map(|cell| {
        // Merged entries stand for others, so all of them must have a value.
        let here: Vec<Estimate> = values.iter().map(|series| series[cell]).collect::<Option<_>>()?;
        let value = here.iter().map(|estimate| estimate.0).fold(f64::INFINITY, f64::min);
        let (first, others): (Vec<&Entry>, Vec<&Entry>) =
            entries.iter().partition(|entry| near(here[entry.style].0, value));
        let style = match first[..] {
            [] => return None,
            [only] => only.style,
            _ => tie(&mut ties, styles, &first),
        };
        // Equal winners share their interval, whatever its width.
        let top = first.iter().filter_map(|entry| here[entry.style].1).map(|band| band.1);
        let top = top.fold(f64::NEG_INFINITY, f64::max);
        let certain = others.iter().filter_map(|entry| here[entry.style].1).all(|(low, _)| top < low);
        Some(Won { style, value, certain })
    });
    let won = won.collect();
    entries.extend(ties);
    (won, merged)
}

/// The style of an entry for several winners, which is created if it does not exist yet.
fn tie(ties: &mut Vec<Entry>, styles: usize, winners: &[&Entry]) -> usize {
    let names: Vec<&str> = winners.iter().map(|entry| entry.name.as_str()).collect();
    let name = names.join(" = ");
    let place = ties.iter().position(|entry| entry.name == name).unwrap_or_else(|| {
        ties.push(Entry { style: styles + ties.len(), name });
        ties.len() - 1
    });
    ties[place].style
}

/// Series without values are not compared.
fn same_series(a: &[Option<Estimate>], b: &[Option<Estimate>]) -> bool {
    let alike = |(a, b): (&Option<Estimate>, &Option<Estimate>)| match (a, b) {
        (Some(a), Some(b)) => near(a.0, b.0),
        (a, b) => a.is_none() && b.is_none(),
    };
    a.iter().any(Option::is_some) && a.iter().zip(b).all(alike)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(names: &[&str]) -> Vec<Entry> {
        names.iter().enumerate().map(|(style, name)| Entry { style, name: (*name).to_owned() }).collect()
    }

    fn exact(values: &[f64]) -> Vec<Option<Estimate>> {
        values.iter().map(|&value| Some((value, None))).collect()
    }

    fn styles(won: &[Option<Won>]) -> Vec<Option<usize>> {
        won.iter().map(|won| won.map(|won| won.style)).collect()
    }

    #[test]
    fn the_least_value_wins_and_series_that_agree_everywhere_win_as_one() {
        let mut names = entries(&["const", "linear", "quadratic"]);
        let values = [exact(&[1.0, 5.0]), exact(&[1.0, 5.0 + 1e-12]), exact(&[2.0, 3.0])];
        let (won, merged) = winners(&mut names, &values);
        assert_eq!(styles(&won), [Some(0), Some(2)]);
        assert_eq!(merged, ["const = linear"]);
        assert_eq!(names.iter().map(|entry| entry.style).collect::<Vec<_>>(), [0, 2]);
    }

    #[test]
    fn equal_values_in_single_cells_are_no_win_of_either() {
        let mut names = entries(&["const", "linear", "quadratic"]);
        let values = [exact(&[1.0, 1.0, 4.0]), exact(&[1.0, 2.0, 4.0]), exact(&[3.0, 3.0, 4.0])];
        let (won, merged) = winners(&mut names, &values);
        assert_eq!(styles(&won), [Some(3), Some(0), Some(4)]);
        assert!(merged.is_empty());
        let ties: Vec<&str> = names[3..].iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(ties, ["const = linear", "const = linear = quadratic"]);
    }

    #[test]
    fn a_cell_has_no_winner_while_a_value_is_missing() {
        let mut names = entries(&["const", "quadratic"]);
        let values = [exact(&[1.0, 1.0]), vec![None, Some((2.0, None))]];
        assert_eq!(styles(&winners(&mut names, &values).0), [None, Some(0)]);
    }

    #[test]
    fn a_lead_is_certain_where_the_bands_are_apart() {
        let mut names = entries(&["const", "quadratic"]);
        let with = |value: f64, low: f64, high: f64| Some((value, Some((low, high))));
        let values = [
            vec![with(1.0, 0.9, 1.1), with(1.0, 0.9, 1.3), with(1.0, 0.9, 1.3)],
            vec![with(1.5, 1.2, 1.8), with(1.5, 1.2, 1.8), Some((1.5, None))],
        ];
        let (won, _) = winners(&mut names, &values);
        let certain: Vec<bool> = won.iter().flatten().map(|won| won.certain).collect();
        assert_eq!(certain, [true, false, true]);
    }
}
