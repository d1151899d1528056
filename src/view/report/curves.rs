//! Sentences on whole curves: the place of the minimum, or the largest value.

use crate::quantity::list::listed;
use crate::quantity::number::significant;
use crate::table::{Column, grouped, worded};
use crate::view::report::notch::Notches;
use crate::view::report::sentences::{measured, names};

/// The curves of one column over another.
pub(crate) struct Curves<'t> {
    pub(crate) x: &'t Column,
    pub(crate) y: &'t Column,
    /// Names in the order of the table, with the rows that have a place, by rising x.
    pub(crate) curves: Vec<(String, Vec<usize>)>,
}

impl<'t> Curves<'t> {
    /// The curves of y over x in some rows, distinguished by the columns `by`.
    pub(crate) fn of(x: &'t Column, y: &'t Column, rows: &[usize], by: &[&Column]) -> Curves<'t> {
        let has_place = |row: &usize| x.cells[*row].number().and(y.cells[*row].number()).is_some();
        let mut curves = grouped(rows.iter().copied().filter(has_place), |row| names(by, row));
        curves.iter_mut().for_each(|(_, rows)| rows.sort_by(|&a, &b| x.value(a).total_cmp(&x.value(b))));
        Curves { x, y, curves }
    }

    /// The minimum or the largest value of each curve as a sentence, such as `600 s: 0.153 °/h at switching interval
    /// 37.5 s`. One at an end of the range is marked.
    pub(crate) fn of_each(&self, is_largest: bool) -> Vec<String> {
        let notches = self.notches();
        let sentence = |(name, rows): &(String, Vec<usize>)| {
            let row = if is_largest { self.largest(rows) } else { self.least(rows, &notches) }?;
            let name = if name.is_empty() { String::new() } else { format!("{name}: ") };
            let shown = measured(self.y, self.y.value(row));
            if rows.len() > 1 && rows.iter().all(|&other| self.y.value(other) == self.y.value(row)) {
                return Some(format!("{name}{shown} everywhere"));
            }
            Some(format!("{name}{shown} at {}{}", self.place(row), self.at_end(rows, row)))
        };
        self.curves.iter().filter_map(sentence).collect()
    }

    /// The notches of all curves.
    pub(super) fn notches(&self) -> Notches {
        Notches::of(self.x, self.y, self.curves.iter().map(|(_, rows)| &rows[..]))
    }

    /// The row with the least value, notches left out.
    pub(super) fn least(&self, rows: &[usize], notches: &Notches) -> Option<usize> {
        let rows = rows.iter().copied().filter(|&row| !notches.are_at(self.x.value(row)));
        rows.min_by(|&a, &b| self.y.value(a).total_cmp(&self.y.value(b)))
    }

    /// The curve with the least largest value as a sentence, with the next one. `None` where there is no range.
    pub(crate) fn least_at_worst(&self) -> Option<String> {
        let ranged = self.curves.iter().filter(|(_, rows)| rows.len() > 1);
        let mut worst: Vec<(&str, usize)> =
            ranged.filter_map(|(name, rows)| Some((name.as_str(), self.largest(rows)?))).collect();
        worst.sort_by(|a, b| self.y.value(a.1).total_cmp(&self.y.value(b.1)));
        let ((name, row), others) = worst.split_first()?;
        let (label, shown) = (worded(&self.y.label), |row: usize| measured(self.y, self.y.value(row)));
        let (most, place, count) = (shown(*row), self.place(*row), worst.len());
        let alike = 1 + others.iter().filter(|other| shown(other.1) == most).count();
        Some(match others.first() {
            None => format!("The {label} is at most {most}, at {place}."),
            Some(_) if alike > 1 => {
                format!("The {label} of {alike} of {count} curves is at most {most}, the least: {name}, …")
            }
            Some((second, next)) => format!(
                "The {label} of {name} is at most {most}, at {place}, the least of {count} curves; next is {second}, at most {}.",
                shown(*next)
            ),
        })
    }

    /// The x at which each curve has its least y, and the values of the columns `chosen` there; the curves differ in
    /// the columns `given`. For more than `most` curves only the range is stated. `None` where a curve has no range of
    /// x or equal values, or where there is only one.
    pub(crate) fn least_for_each(&self, [given, chosen]: [&[&Column]; 2], most: usize) -> Option<String> {
        let (x, y) = (self.x, self.y);
        let least = |(name, rows): &'_ (String, Vec<usize>)| {
            // Of equal ones, the first in the table.
            let row = *rows.iter().min_by(|&a, &b| y.value(*a).total_cmp(&y.value(*b)).then(a.cmp(b)))?;
            let differs = |column: &Column| rows.iter().any(|&one| column.value(one) != column.value(row));
            (differs(x) && differs(y)).then(|| (name.clone(), row, self.at_end(rows, row)))
        };
        let found = self.curves.iter().map(least).collect::<Option<Vec<_>>>()?;
        let start = format!("The {} is least at {}", worded(&y.label), x.label);
        if found.len() > most {
            let ends = |column: &Column| {
                let of = |end: fn(f64, f64) -> f64| found.iter().map(|one| column.value(one.1)).reduce(end);
                [of(f64::min), of(f64::max)].map(|end| measured(column, end.unwrap_or(0.0))).join(" to ")
            };
            let depends = given.iter().map(|column| column.label.as_str()).collect::<Vec<_>>();
            return Some(format!(
                "{start} {}, which depends on the {}: {}.",
                ends(x),
                listed(&depends),
                ends(y)
            ));
        }
        let told = found.iter().map(|(name, row, end)| {
            let with = names(chosen, *row);
            let with = if with.is_empty() { with } else { format!(" with {with}") };
            format!("{}{with}{end} ({name}: {})", measured(x, x.value(*row)), measured(y, y.value(*row)))
        });
        let told: Vec<String> = told.collect();
        (told.len() > 1).then(|| format!("{start} {}.", listed(&told)))
    }

    fn largest(&self, rows: &[usize]) -> Option<usize> {
        rows.iter().copied().max_by(|&a, &b| self.y.value(a).total_cmp(&self.y.value(b)))
    }

    fn place(&self, row: usize) -> String {
        self.x.valued(&significant(self.x.value(row), 3))
    }

    /// A remark for a row of a curve that is at an end of its range.
    fn at_end(&self, rows: &[usize], row: usize) -> &'static str {
        let mut ends = [rows.first(), rows.last()].into_iter().flatten();
        let is_end = ends.any(|&end| self.x.value(end) == self.x.value(row));
        if is_end { ", the end of its range" } else { "" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::report::tests::table;

    fn said(curves: &[(&str, [f64; 3])]) -> (Vec<String>, Vec<String>, Option<String>) {
        let table = table("rms", curves);
        let rows: Vec<usize> = (0..table.rows()).collect();
        let [filler, x, y] = [0, 1, 2].map(|at| &table.columns[at]);
        let curves = Curves::of(x, y, &rows, &[filler]);
        (curves.of_each(false), curves.of_each(true), curves.least_at_worst())
    }

    #[test]
    fn each_curve_is_told_where_it_is_least_and_largest() {
        let (least, largest, worst) = said(&[("a", [3.0, 2.0, 5.0]), ("b", [4.0, 4.0, 4.0])]);
        assert_eq!(least, ["a: 2 arcsec at frequency 2 Hz", "b: 4 arcsec everywhere"]);
        assert_eq!(
            largest,
            ["a: 5 arcsec at frequency 4 Hz, the end of its range", "b: 4 arcsec everywhere"]
        );
        let expected = "The rms of b is at most 4 arcsec, at frequency 4 Hz, the least of 2 curves; next is a, at most 5 arcsec.";
        assert_eq!(worst.as_deref(), Some(expected));
    }

    #[test]
    fn one_curve_has_no_next_and_equal_ones_are_counted() {
        assert_eq!(
            said(&[("a", [1.0, 3.0, 2.0])]).2.unwrap(),
            "The rms is at most 3 arcsec, at frequency 2 Hz."
        );
        let equal =
            said(&[("a", [1.0, 3.0, 2.0]), ("b", [1.0, 3.0, 2.0]), ("c", [9.0, 9.0, 9.0])]).2.unwrap();
        assert_eq!(equal, "The rms of 2 of 3 curves is at most 3 arcsec, the least: a, …");
        assert_eq!(said(&[]).2, None);
    }

    #[test]
    fn one_sentence_tells_where_it_is_least_for_each_of_what_is_given() {
        let table = table("rms", &[("a", [3.0, 2.0, 5.0]), ("b", [4.0, 2.0, 1.5])]);
        let [filler, x, y] = [0, 1, 2].map(|at| &table.columns[at]);
        let least = |rows: &[usize], [given, chosen]: [&[&Column]; 2], most: usize| {
            Curves::of(x, y, rows, given).least_for_each([given, chosen], most)
        };
        let all = [0, 1, 2, 3, 4, 5];
        let expected = "The rms is least at frequency 2 Hz (a: 2 arcsec) and 4 Hz, the end of its range (b: 1.5 arcsec).";
        assert_eq!(least(&all, [&[filler], &[]], 4).as_deref(), Some(expected));
        let expected = "The rms is least at frequency 2 Hz to 4 Hz, which depends on the filler: 1.5 arcsec to 2 arcsec.";
        assert_eq!(least(&all, [&[filler], &[]], 1).as_deref(), Some(expected));
        // A chosen column is stated with the place; a single one, or one without a range, is stated elsewhere.
        assert_eq!(least(&all, [&[], &[filler]], 4), None);
        assert_eq!(least(&[0, 3], [&[filler], &[]], 4), None);
        assert_eq!(least(&[], [&[filler], &[]], 4), None);
    }
}
