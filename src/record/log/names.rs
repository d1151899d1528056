//! The names of a log's columns, and the lookup of columns by the user's names.

use crate::quantity::units::{Dimension, parse_unit};
use crate::source::diagnose::choices;

/// Longest unit after an underscore, in bytes including it.
const LONGEST_UNIT: usize = 64;

/// A column of the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Name {
    /// Name as in the file.
    pub whole: String,
    /// Name without the unit.
    pub bare: String,
    pub unit: Option<String>,
}

impl Name {
    /// Reads `gz [deg/s]`, `gz (deg/s)`, or `gz_deg_per_s` where the end is a unit of a rate, an angle or a time.
    pub(crate) fn read(cell: &str) -> Name {
        let whole = cell.trim();
        let with = |bare: &str, unit: &str| Name {
            whole: whole.to_owned(),
            bare: bare.trim().to_owned(),
            unit: Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty()),
        };
        for (open, close) in [('[', ']'), ('(', ')')] {
            let inner = whole.strip_suffix(close).and_then(|rest| rest.split_once(open));
            if let Some((bare, unit)) = inner.filter(|(bare, _)| !bare.trim().is_empty()) {
                return with(bare, unit);
            }
        }
        // Without a bound, a long cell of underscores would take time in proportion to the square of its length.
        let is_short = |at: usize| whole.len() - at <= LONGEST_UNIT;
        for (at, _) in whole.match_indices('_').filter(|(at, _)| *at > 0 && is_short(*at)) {
            let unit = whole[at + 1..].replace("_per_", "/");
            if parse_unit(&unit, &[Dimension::Rate, Dimension::Angle, Dimension::Time]).is_ok() {
                return with(&whole[..at], &unit);
            }
        }
        Name { whole: whole.to_owned(), bare: whole.to_owned(), unit: None }
    }
}

/// Why a word names no column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NoColumn {
    pub message: String,
    pub help: String,
}

/// Finds the column that a user means by `word`: its name with or without unit, in upper or lower case, or its number
/// from 1.
///
/// # Errors
/// No column matches, or several do; the error lists the columns and the nearest name.
pub(crate) fn find(word: &str, names: Option<&[Name]>, columns: usize) -> Result<usize, NoColumn> {
    let list = listed(names, columns);
    let word = word.trim();
    let named = names.unwrap_or_default();
    let exact = |same: &dyn Fn(&str) -> bool| -> Vec<usize> {
        let each = named.iter().enumerate();
        each.filter(|(_, name)| same(&name.whole) || same(&name.bare)).map(|(i, _)| i).collect()
    };
    let found = Some(exact(&|name| name == word)).filter(|found| !found.is_empty());
    match found.unwrap_or_else(|| exact(&|name| name.eq_ignore_ascii_case(word)))[..] {
        [only] => return Ok(only),
        [] => {}
        ref several => {
            let numbers: Vec<String> = several.iter().map(|i| (i + 1).to_string()).collect();
            let message = format!("columns {} are both called `{word}`", numbers.join(" and "));
            return Err(NoColumn { message, help: "give the number of the one you mean".to_owned() });
        }
    }
    if let Ok(number) = word.parse::<usize>() {
        if (1..=columns).contains(&number) {
            return Ok(number - 1);
        }
        let message = format!("there is no column {number}, the file has {columns}");
        return Err(NoColumn { message, help: format!("columns are numbered from 1: {list}") });
    }
    if names.is_none() {
        let message = format!("no column can be called `{word}`: the file has no header");
        return Err(NoColumn { message, help: format!("give numbers, counted from 1: {list}") });
    }
    let bare: Vec<&str> = named.iter().map(|name| name.bare.as_str()).collect();
    let help = format!("{}; numbers from 1 are accepted too", choices(word, &bare));
    Err(NoColumn { message: format!("no column is called `{word}`"), help })
}

/// All columns as part of a sentence, such as `1 time, 2 gx` or `columns 1 … 4`.
pub(crate) fn listed(names: Option<&[Name]>, columns: usize) -> String {
    const MOST: usize = 20;
    match names {
        Some(names) => {
            let shown: Vec<String> = names
                .iter()
                .take(MOST)
                .enumerate()
                .map(|(i, name)| format!("{} {}", i + 1, name.whole))
                .collect();
            let more = if names.len() > MOST { ", …" } else { "" };
            format!("{}{more}", shown.join(", "))
        }
        None if columns == 1 => "column 1".to_owned(),
        None => format!("columns 1 … {columns}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<Name> {
        ["time_ms", "gx [deg/s]", "gz (deg/s)", "Temp", "x_y"].map(Name::read).to_vec()
    }

    #[test]
    fn units_stand_in_brackets_or_after_an_underscore() {
        let read = |cell| {
            let name = Name::read(cell);
            (name.bare, name.unit.unwrap_or_default())
        };
        for (cell, bare, unit) in [
            ("gz [deg/s]", "gz", "deg/s"),
            (" gz(rad/s) ", "gz", "rad/s"),
            ("gz_deg_per_s", "gz", "deg/s"),
            ("gyro_z_deg/h", "gyro_z", "deg/h"),
            ("time_ns", "time", "ns"),
            ("gyro_x", "gyro_x", ""),
            (&"_".repeat(1 << 20), &"_".repeat(1 << 20), ""),
            ("[s]", "[s]", ""),
            ("t []", "t", ""),
            ("", "", ""),
        ] {
            assert_eq!(read(cell), (bare.to_owned(), unit.to_owned()), "{cell}");
        }
    }

    #[test]
    fn a_column_is_found_by_name_with_or_without_unit_or_by_its_number() {
        let names = names();
        for (word, column) in [("time", 0), ("time_ms", 0), ("gx", 1), ("GZ", 2), ("gz (deg/s)", 2), ("4", 3)]
        {
            assert_eq!(find(word, Some(&names), 5), Ok(column), "{word}");
        }
        assert_eq!(find("2", None, 3), Ok(1));
    }

    #[test]
    fn a_wrong_column_is_told_with_the_nearest_and_all_that_there_are() {
        let names = names();
        let error = find("gzz", Some(&names), 5).unwrap_err();
        assert!(error.message.contains("`gzz`") && error.help.contains("did you mean `gz`"), "{error:?}");
        assert!(error.help.contains("Temp"), "{error:?}");
        assert!(find("9", Some(&names), 5).unwrap_err().help.contains("2 gx [deg/s]"));
        assert!(find("0", None, 3).unwrap_err().help.contains("columns 1 … 3"));
        assert!(find("gz", None, 3).unwrap_err().message.contains("no header"));
        let doubled = [Name::read("a"), Name::read("a")];
        assert!(find("a", Some(&doubled), 2).unwrap_err().message.contains("1 and 2"));
    }
}
