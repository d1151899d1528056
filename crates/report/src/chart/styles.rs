//! The styles of names that look the same in every chart.

use crate::chart::figure::Entry;
use crate::chart::palette::COLOURS;
use sagnac_base::table::{Cell, Column};

/// The styles of the values of a column. Of a column with fixed names, these have the first styles, and every other name has one that
/// follows from the name; names of one column that would share a colour take the next that is free, as long as there is one.
pub fn styles(column: Option<&Column>, entries: &[Entry]) -> Vec<usize> {
    let Some(column) = column.filter(|column| !column.styled.is_empty()) else {
        return (0..entries.len()).collect();
    };
    // Of the whole column, so that all charts of a table agree.
    let mut names: Vec<String> =
        column.cells.iter().filter(|cell| **cell != Cell::Blank).map(Cell::text).collect();
    names.sort_unstable();
    names.dedup();
    let styles = of_names(column.styled, &names);
    let style =
        |entry: &Entry| names.iter().position(|name| *name == entry.name).map_or(0, |place| styles[place]);
    entries.iter().map(style).collect()
}

/// The styles of names in alphabetical order, of which the `fixed` ones have the first.
pub fn of_names(fixed: &[&str], names: &[String]) -> Vec<usize> {
    let others = COLOURS.len() - fixed.len();
    let mut taken: Vec<usize> = Vec::new();
    let mut free = |name: &String| {
        // Once all colours are taken they repeat, with other dashes and markers.
        let round = taken.len() / others;
        let style = |step: usize| round * COLOURS.len() + fixed.len() + (hash(name) + step) % others;
        let style = (0..others).map(style).find(|style| !taken.contains(style)).unwrap_or_default();
        taken.push(style);
        style
    };
    let style = |name: &String| fixed.iter().position(|known| known == name).unwrap_or_else(|| free(name));
    names.iter().map(style).collect()
}

/// FNV-1a in 32 bits, which gives short names different numbers.
fn hash(name: &str) -> usize {
    name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
        as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> Vec<usize> {
        of_names(&["const", "linear"], &names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn a_name_has_its_style_whatever_stands_beside_it() {
        let [alone, beside] = [of(&["mv8+2"]), of(&["const", "linear", "mv8+2"])];
        assert_eq!((beside[0], beside[1], beside[2]), (0, 1, alone[0]));
        assert!((2..8).contains(&alone[0]), "{alone:?}");
    }

    #[test]
    fn names_of_one_column_have_different_colours_while_there_are_any() {
        let names: Vec<String> = (10..22).map(|k| format!("own {k}")).collect();
        let styles = of(&names.iter().map(String::as_str).collect::<Vec<_>>());
        let mut first = styles[..6].to_vec();
        first.sort_unstable();
        assert_eq!(first, [2, 3, 4, 5, 6, 7]);
        let mut all = styles.clone();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 12, "{styles:?}");
    }
}
