//! Sentences on whole curves: where each is least, or how large it gets.

use super::sentences::{measured, named};
use crate::table::{Column, ColumnError, Table, significant};

/// A value of x and one of y.
type Place = (f64, f64);

/// The curves of a table.
pub(super) struct Curves<'t> {
    x: &'t Column,
    y: &'t Column,
    /// Name and places by x, in the order of the table.
    curves: Vec<(String, Vec<Place>)>,
}

impl<'t> Curves<'t> {
    /// The values of y over x in some rows; `series` are the columns that tell curves apart.
    ///
    /// # Errors
    /// A name selects no single column.
    pub(super) fn of(
        table: &'t Table,
        (x, y): (&str, &str),
        rows: &[usize],
        series: &[&str],
    ) -> Result<Curves<'t>, ColumnError> {
        let (x, y) = (table.column(x)?, table.column(y)?);
        let series = series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let mut curves: Vec<(String, Vec<Place>)> = Vec::new();
        for &row in rows {
            let Some(place) = x.cells[row].number().zip(y.cells[row].number()) else { continue };
            let names: Vec<String> =
                series.iter().filter_map(|column| named(column, &column.cells[row])).collect();
            let name = names.join(", ");
            match curves.iter_mut().find(|(known, _)| *known == name) {
                Some((_, places)) => places.push(place),
                None => curves.push((name, vec![place])),
            }
        }
        curves.iter_mut().for_each(|(_, places)| places.sort_by(|a, b| a.0.total_cmp(&b.0)));
        Ok(Curves { x, y, curves })
    }

    pub(super) fn len(&self) -> usize {
        self.curves.len()
    }

    /// Where each is least, a sentence each: `600 s: 0.153 °/h at switching interval 37.5 s`. A curve that is least at one of its ends is
    /// said to be.
    pub(super) fn least_of_each(&self) -> Vec<String> {
        self.each(|places| places.iter().min_by(|a, b| a.1.total_cmp(&b.1)))
    }

    /// How large each gets, in the same way.
    pub(super) fn largest_of_each(&self) -> Vec<String> {
        self.each(largest)
    }

    /// At which x each is least, and how little that is, in one sentence; nothing where a curve has no range or all values of one are
    /// alike.
    pub(super) fn least_by_curve(&self) -> Option<String> {
        let told = |(name, places): &(String, Vec<Place>)| {
            let ends = [places.first()?.0, places.last()?.0];
            let (at, value) = *places.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
            let is_told = places.len() > 1 && places.iter().any(|place| place.1 != value);
            let at_end = if ends.contains(&at) { ", the end of its range" } else { "" };
            let at = format!("{}{at_end}", measured(self.x, at));
            is_told.then(|| format!("{at} ({name}: {})", measured(self.y, value)))
        };
        let told: Vec<String> = self.curves.iter().map(told).collect::<Option<_>>()?;
        let (last, others) = told.split_last()?;
        let (y, x) = (&self.y.label, &self.x.label);
        Some(match others {
            [] => format!("The {y} is least at {x} {last}."),
            others => format!("The {y} is least at {x} {} and {last}.", others.join(", ")),
        })
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

    /// Which curve is the least where it is largest, and how large, as a sentence; the next one is told too. Nothing where there is no
    /// range to look over.
    pub(super) fn least_at_worst(&self) -> Option<String> {
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

fn largest(places: &[Place]) -> Option<&Place> {
    places.iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::super::sentences::tests::table;
    use super::*;

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
    fn one_sentence_tells_where_each_curve_is_least() {
        let table = table("rms", &[("a", [3.0, 2.0, 5.0]), ("b", [4.0, 2.0, 1.5])]);
        let least = |rows: &[usize]| {
            Curves::of(&table, ("frequency", "rms"), rows, &["filler"]).unwrap().least_by_curve()
        };
        let expected =
            "The rms is least at frequency 2 Hz (a: 2 ″) and 4 Hz, the end of its range (b: 1.5 ″).";
        assert_eq!(least(&[0, 1, 2, 3, 4, 5]).as_deref(), Some(expected));
        assert_eq!(least(&[0]), None);
        assert_eq!(least(&[]), None);
    }
}
