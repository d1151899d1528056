//! The rows among which a study compares options: which conditions they have, and which of them count.

use crate::analysis::notch::Notches;
use sagnac_base::table::{Column, grouped};
use sagnac_report::answer::reading::naming;

/// Rows with an estimate, by option and condition.
pub(crate) struct Compared<'t> {
    /// The estimate.
    pub(crate) column: &'t Column,
    /// The conditions that vary.
    pub(crate) given: Vec<&'t Column>,
    /// The averaging time where a condition has a whole curve over it.
    pub(crate) abscissa: Option<&'t Column>,
    pub(crate) notches: Notches,
    condition_of: Box<dyn Fn(usize) -> String + 't>,
    option_of: Box<dyn Fn(usize) -> String + 't>,
}

impl<'t> Compared<'t> {
    /// The rows by the columns of conditions and those of choices.
    pub(crate) fn of(
        column: &'t Column,
        [given, chosen]: [Vec<&'t Column>; 2],
        abscissa: Option<&'t Column>,
        rows: &[usize],
    ) -> Compared<'t> {
        let (condition_of, option_of) = (naming(&given), naming(&chosen));
        let notches = abscissa.map_or_else(Notches::default, |x| {
            let curves = grouped(rows.iter().copied(), |row| (option_of(row), condition_of(row)));
            Notches::of(x, column, curves.iter().map(|(_, rows)| &rows[..]))
        });
        let (condition_of, option_of) = (Box::new(condition_of), Box::new(option_of));
        Compared { column, given, abscissa, notches, condition_of, option_of }
    }

    /// The magnitude of a row; a coefficient that records do not show has no error, and meets no limit.
    pub(crate) fn value(&self, row: usize) -> f64 {
        self.column.magnitude(row)
    }

    /// The row with the least magnitude.
    pub(crate) fn least(&self, rows: impl IntoIterator<Item = usize>) -> Option<usize> {
        rows.into_iter().min_by(|a, b| self.value(*a).total_cmp(&self.value(*b)))
    }

    /// The row with the largest magnitude.
    pub(crate) fn worst(&self, rows: &[usize]) -> Option<usize> {
        rows.iter().copied().max_by(|a, b| self.value(*a).total_cmp(&self.value(*b)))
    }

    /// The name of the option of a row.
    pub(crate) fn option(&self, row: usize) -> String {
        (self.option_of)(row)
    }

    /// A row for each condition among those of an option: a curve over the averaging time counts at its minimum, notches left
    /// out.
    pub(crate) fn conditions(&self, rows: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let is_notch = |row: usize| self.abscissa.is_some_and(|x| self.notches.are_at(x.value(row)));
        let of_condition =
            |(_, rows): (String, Vec<usize>)| self.least(rows.into_iter().filter(|&row| !is_notch(row)));
        grouped(rows, &self.condition_of).into_iter().filter_map(of_condition).collect()
    }
}
