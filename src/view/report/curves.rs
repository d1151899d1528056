//! Sentences on whole curves: the place of the minimum, or the largest value.

use crate::quantity::number::significant;
use crate::table::{Column, ColumnError, Table};
use crate::view::report::sentences::{measured, named};

/// A value of x and one of y.
type Place = (f64, f64);

/// The curves of a table.
pub(crate) struct Curves<'t> {
    x: &'t Column,
    y: &'t Column,
    /// Names and places by x, in the order of the table.
    curves: Vec<(String, Vec<Place>)>,
}

impl<'t> Curves<'t> {
    /// The curves of y over x in some rows; `series` are the columns that distinguish curves.
    ///
    /// # Errors
    /// A name selects no single column.
    pub(crate) fn of(
        table: &'t Table,
        (x, y): (&str, &str),
        rows: &[usize],
        series: &[&str],
    ) -> Result<Curves<'t>, ColumnError> {
        let (x, y) = (table.column(x)?, table.column(y)?);
        let series = series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let groups = grouped((x, y), rows, &series).into_iter();
        let strip = |places: Vec<(usize, Place)>| places.into_iter().map(|(_, place)| place).collect();
        let mut curves: Vec<(String, Vec<Place>)> =
            groups.map(|(name, places)| (name, strip(places))).collect();
        curves.iter_mut().for_each(|(_, places)| places.sort_by(|a, b| a.0.total_cmp(&b.0)));
        Ok(Curves { x, y, curves })
    }

    /// The minimum of each curve as a sentence, such as `600 s: 0.153 °/h at switching interval 37.5 s`. A minimum at
    /// an end of the range is marked.
    /// said to be.
    pub(crate) fn least_of_each(&self) -> Vec<String> {
        self.each(|places| places.iter().min_by(|a, b| a.1.total_cmp(&b.1)))
    }

    /// The largest value of each curve, in the same form.
    pub(crate) fn largest_of_each(&self) -> Vec<String> {
        self.each(largest)
    }

    fn each(&self, chosen: fn(&[Place]) -> Option<&Place>) -> Vec<String> {
        let sentence = |(name, places): &(String, Vec<Place>)| {
            let ends = [places.first()?.0, places.last()?.0];
            let (at, value) = *chosen(places)?;
            let name = if name.is_empty() { String::new() } else { format!("{name}: ") };
            let shown = measured(self.y, value);
            if places.len() > 1 && places.iter().all(|place| place.1 == value) {
                return Some(format!("{name}{shown} everywhere"));
            }
            let at_end = if ends.contains(&at) { ", the end of its range" } else { "" };
            Some(format!("{name}{shown} at {}{at_end}", self.place(at)))
        };
        self.curves.iter().filter_map(sentence).collect()
    }

    /// The curve with the least largest value as a sentence, with the next one. `None` where there is no range.
    pub(crate) fn least_at_worst(&self) -> Option<String> {
        let mut worst: Vec<(&str, Place)> = self
            .curves
            .iter()
            .filter(|(_, places)| places.len() > 1)
            .filter_map(|(name, places)| Some((name.as_str(), *largest(places)?)))
            .collect();
        worst.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let (label, shown) = (&self.y.label, |value: f64| measured(self.y, value));
        let ((name, (at, value)), others) = worst.split_first()?;
        let place = self.place(*at);
        Some(match others.first() {
            None => format!("The {label} is at most {}, at {place}.", shown(*value)),
            Some((_, (_, next))) if shown(*next) == shown(*value) => {
                let alike = 1 + others.iter().filter(|other| shown(other.1.1) == shown(*value)).count();
                format!(
                    "The {label} of {alike} of {} curves is at most {}, the least: {name}, …",
                    worst.len(),
                    shown(*value)
                )
            }
            Some((second, (_, next))) => format!(
                "The {label} of {name} is at most {}, at {place}, the least of {} curves; next is {second}, at most {}.",
                shown(*value),
                worst.len(),
                shown(*next)
            ),
        })
    }

    fn place(&self, x: f64) -> String {
        self.x.valued(&significant(x, 4))
    }
}

/// The x at which some rows have the least y, for each value of the columns `given`, and the values of the columns
/// `chosen` there. For more than `most` values only the range is stated. `None` where a group has no range of x or
/// equal values, or where there is only one group.
///
/// # Errors
/// A name selects no single column.
pub(crate) fn least_for_each(
    table: &Table,
    (x, y): (&str, &str),
    rows: &[usize],
    [given, chosen]: [&[&Column]; 2],
    most: usize,
) -> Result<Option<String>, ColumnError> {
    let (x, y) = (table.column(x)?, table.column(y)?);
    let groups = grouped((x, y), rows, given);
    let least = |(name, places): &(String, Vec<(usize, Place)>)| {
        let (row, (at, value)) = *places.iter().min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        let has_range = places.iter().any(|one| one.1.0 != at) && places.iter().any(|one| one.1.1 != value);
        let at_end = !places.iter().any(|one| one.1.0 < at) || !places.iter().any(|one| one.1.0 > at);
        has_range.then(|| (name.clone(), row, at, value, at_end))
    };
    let Some(found) = groups.iter().map(least).collect::<Option<Vec<_>>>().filter(|found| found.len() > 1)
    else {
        return Ok(None);
    };
    let (y_label, x_label) = (&y.label, &x.label);
    if found.len() > most {
        let ends = |values: Vec<f64>, column: &Column| {
            let [low, high] =
                [f64::min, f64::max].map(|end: fn(f64, f64) -> f64| values.iter().copied().reduce(end));
            format!("{} to {}", measured(column, low.unwrap_or(0.0)), measured(column, high.unwrap_or(0.0)))
        };
        let depends = given.iter().map(|column| column.label.as_str()).collect::<Vec<_>>().join(" and ");
        return Ok(Some(format!(
            "The {y_label} is least at {x_label} {}, which depends on the {depends}: {}.",
            ends(found.iter().map(|one| one.2).collect(), x),
            ends(found.iter().map(|one| one.3).collect(), y)
        )));
    }
    let told = |(name, row, at, value, at_end): &(String, usize, f64, f64, bool)| {
        let with = name_of(chosen, *row);
        let with = if with.is_empty() { with } else { format!(" with {with}") };
        let end = if *at_end { ", the end of its range" } else { "" };
        format!("{}{with}{end} ({name}: {})", measured(x, *at), measured(y, *value))
    };
    let told: Vec<String> = found.iter().map(told).collect();
    let (last, others) = (&told[told.len() - 1], &told[..told.len() - 1]);
    Ok(Some(format!("The {y_label} is least at {x_label} {} and {last}.", others.join(", "))))
}

/// The places of some rows that have one, with their rows, grouped by the names that distinguish curves.
fn grouped((x, y): (&Column, &Column), rows: &[usize], by: &[&Column]) -> Vec<(String, Vec<(usize, Place)>)> {
    let mut groups: Vec<(String, Vec<(usize, Place)>)> = Vec::new();
    for &row in rows {
        let Some(place) = x.cells[row].number().zip(y.cells[row].number()) else { continue };
        let name = name_of(by, row);
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, places)) => places.push((row, place)),
            None => groups.push((name, vec![(row, place)])),
        }
    }
    groups
}

fn name_of(columns: &[&Column], row: usize) -> String {
    columns.iter().filter_map(|column| named(column, &column.cells[row])).collect::<Vec<_>>().join(", ")
}

fn largest(places: &[Place]) -> Option<&Place> {
    places.iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::report::sentences::tests::table;

    fn said(curves: &[(&str, [f64; 3])]) -> (Vec<String>, Vec<String>, Option<String>) {
        let table = table("rms", curves);
        let rows: Vec<usize> = (0..table.rows()).collect();
        let curves = Curves::of(&table, ("frequency", "rms"), &rows, &["filler"]).unwrap();
        (curves.least_of_each(), curves.largest_of_each(), curves.least_at_worst())
    }

    #[test]
    fn each_curve_is_told_where_it_is_least_and_largest() {
        let (least, largest, worst) = said(&[("a", [3.0, 2.0, 5.0]), ("b", [4.0, 4.0, 4.0])]);
        assert_eq!(least, ["a: 2 ″ at frequency 2 Hz", "b: 4 ″ everywhere"]);
        assert_eq!(largest, ["a: 5 ″ at frequency 4 Hz, the end of its range", "b: 4 ″ everywhere"]);
        let expected =
            "The rms of b is at most 4 ″, at frequency 4 Hz, the least of 2 curves; next is a, at most 5 ″.";
        assert_eq!(worst.as_deref(), Some(expected));
    }

    #[test]
    fn one_curve_has_no_next_and_equal_ones_are_counted() {
        assert_eq!(said(&[("a", [1.0, 3.0, 2.0])]).2.unwrap(), "The rms is at most 3 ″, at frequency 2 Hz.");
        let equal =
            said(&[("a", [1.0, 3.0, 2.0]), ("b", [1.0, 3.0, 2.0]), ("c", [9.0, 9.0, 9.0])]).2.unwrap();
        assert_eq!(equal, "The rms of 2 of 3 curves is at most 3 ″, the least: a, …");
        assert_eq!(said(&[]).2, None);
    }

    #[test]
    fn one_sentence_tells_where_it_is_least_for_each_of_what_is_given() {
        let table = table("rms", &[("a", [3.0, 2.0, 5.0]), ("b", [4.0, 2.0, 1.5])]);
        let filler = table.column("filler").unwrap();
        let least = |rows: &[usize], columns: [&[&Column]; 2], most: usize| {
            least_for_each(&table, ("frequency", "rms"), rows, columns, most).unwrap()
        };
        let all = [0, 1, 2, 3, 4, 5];
        let expected =
            "The rms is least at frequency 2 Hz (a: 2 ″) and 4 Hz, the end of its range (b: 1.5 ″).";
        assert_eq!(least(&all, [&[filler], &[]], 4).as_deref(), Some(expected));
        let expected =
            "The rms is least at frequency 2 Hz to 4 Hz, which depends on the filler: 1.5 ″ to 2 ″.";
        assert_eq!(least(&all, [&[filler], &[]], 1).as_deref(), Some(expected));
        // A chosen column is stated with the place; a single one, or one without a range, is stated elsewhere.
        assert_eq!(least(&all, [&[], &[filler]], 4), None);
        assert_eq!(least(&[0, 3], [&[filler], &[]], 4), None);
        assert_eq!(least(&[], [&[filler], &[]], 4), None);
    }
}
