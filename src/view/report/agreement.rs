//! The agreement of simulated values with their closed forms.

use statrs::function::erf::erfc_inv;

use crate::answer::reading::capitalized;
use crate::quantity::number::significant;
use crate::table::{Cell, Column, Role, Table};

/// The deviations of one estimate from its closed form, in standard errors of the simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// Column of the deviations, `z`.
    pub column: String,
    /// Quantity that deviates, such as `rms error`.
    pub of: String,
    /// Number of rows with a closed form.
    pub rows: usize,
    /// Root mean square of the deviations, which is near 1 if they are due to chance only.
    pub rms: f64,
    /// The largest magnitude.
    pub largest: f64,
    /// Index of its row.
    pub at: usize,
    /// The 2.5 % and 97.5 % quantiles of the largest of equally many independent standard normal magnitudes.
    pub expected: (f64, f64),
    /// Level below which the largest of equally many stays in 999 of 1000 cases.
    pub most: f64,
}

/// The agreement of every estimate of a table that has closed forms.
pub fn agreements(table: &Table) -> Vec<Agreement> {
    let deviations = table.columns.iter().filter(|column| column.role == Role::Z);
    deviations.filter_map(|column| of_column(table, column)).collect()
}

/// How nearly the integers that are sampled stand for the inputs: the number of rows of which it is known, and the largest
/// relative difference of the two closed forms.
pub(crate) fn representation(table: &Table) -> Option<(usize, f64)> {
    let columns = table.columns.iter().filter(|column| column.role == Role::Representation);
    let known: Vec<f64> = columns.flat_map(|column| column.cells.iter()).filter_map(Cell::number).collect();
    let largest = known.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
    (!known.is_empty()).then_some((known.len(), largest))
}

fn of_column(table: &Table, column: &Column) -> Option<Agreement> {
    let known: Vec<(usize, f64)> =
        column.cells.iter().enumerate().filter_map(|(row, cell)| Some((row, cell.number()?))).collect();
    let (at, largest) = *known.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let rows = known.len();
    let squares: f64 = known.iter().map(|(_, z)| z * z).sum();
    Some(Agreement {
        column: column.name.clone(),
        of: table.referred(column).unwrap_or(column).label.clone(),
        rows,
        rms: libm::sqrt(squares / rows as f64),
        largest: largest.abs(),
        at,
        expected: (largest_normal(rows, 0.025), largest_normal(rows, 0.975)),
        most: largest_normal(rows, 0.999),
    })
}

/// The p quantile of the largest of n independent standard normal magnitudes, below which all n lie with probability p.
fn largest_normal(n: usize, p: f64) -> f64 {
    // 1 − p^(1/n), accurate even where it is tiny.
    let beyond = -libm::expm1(libm::log(p) / n as f64);
    std::f64::consts::SQRT_2 * erfc_inv(beyond)
}

impl Agreement {
    /// Whether chance explains the largest deviation, which would be as large in more than one of 1000 cases.
    pub fn holds(&self) -> bool {
        self.largest <= self.most
    }

    /// The agreement as a sentence; `table` is the table to which it belongs.
    pub fn sentence(&self, table: &Table) -> String {
        let [rms, largest, low, high] =
            [self.rms, self.largest, self.expected.0, self.expected.1].map(|z| significant(z, 3));
        let rows = match self.rows {
            1 => "one row has a closed form".to_owned(),
            rows => format!("{rows} rows have a closed form"),
        };
        let place = place(table, self.at);
        let place = if place.is_empty() { String::new() } else { format!(" ({place})") };
        let judged =
            if self.holds() { "" } else { " Chance makes it as large in less than one of 1000 cases." };
        format!(
            "{}: {rows}. The simulation is off by {rms} standard errors rms and at most {largest}{place}; of as many independent \
             normal numbers the largest would be {low} to {high} in 95 of 100 cases.{judged}",
            capitalized(&self.of)
        )
    }
}

/// Description that distinguishes a row: its texts, and the values before them.
fn place(table: &Table, row: usize) -> String {
    let told = table.columns.iter().take_while(|column| column.role != Role::Trials);
    let unlike = told.filter(|column| column.cells.iter().any(|cell| *cell != column.cells[row]));
    let value = |column: &Column| match &column.cells[row] {
        Cell::Blank => None,
        Cell::Text(text) => Some(text.clone()),
        cell => Some(column.valued(&cell.number().map_or_else(String::new, |x| significant(x, 4)))),
    };
    unlike.filter_map(value).collect::<Vec<String>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(z: &[Option<f64>]) -> Table {
        let column = |name: &str, role, cells: Vec<Cell>| Column {
            name: name.to_owned(),
            label: format!("the {name}"),
            role,
            of: if role == Role::Z { "rms".to_owned() } else { String::new() },
            cells: cells.into(),
            ..Column::default()
        };
        let fillers = (0..z.len()).map(|row| Cell::Text(format!("filler {row}"))).collect();
        let numbers = |value: f64| vec![Cell::Number(value); z.len()];
        Table {
            columns: vec![
                column("filler", Role::Key, fillers),
                column("trials", Role::Trials, numbers(8.0)),
                column("rms", Role::Error, numbers(1.0)),
                column("z", Role::Z, z.iter().map(|z| Cell::from(*z)).collect()),
            ],
        }
    }

    #[test]
    fn the_largest_of_many_is_where_the_normal_distribution_puts_it() {
        // For one magnitude: the quantiles of |z|.
        assert!((largest_normal(1, 0.95) - 1.959_963_985).abs() < 1e-8);
        // All of 100 within 3.3 with (1 − 2·Φ(−3.3))^100.
        let p = libm::pow(libm::erf(3.3 / std::f64::consts::SQRT_2), 100.0);
        assert!((largest_normal(100, p) - 3.3).abs() < 1e-9);
    }

    #[test]
    fn deviations_are_summed_up_over_the_rows_that_have_a_closed_form() {
        let table = table(&[Some(1.0), None, Some(-3.0), Some(2.0)]);
        let found = agreements(&table);
        assert_eq!((found.len(), found[0].rows, found[0].at, found[0].largest), (1, 3, 2, 3.0));
        assert!((found[0].rms - libm::sqrt(14.0 / 3.0)).abs() < 1e-12 && found[0].holds());
        let sentence = found[0].sentence(&table);
        assert!(sentence.starts_with("The rms: 3 rows have a closed form."), "{sentence}");
        assert!(sentence.contains("at most 3 (filler 2)"), "{sentence}");
    }

    #[test]
    fn what_chance_does_not_explain_is_said_and_without_closed_forms_nothing_is() {
        let table = table(&[Some(0.5), Some(6.0)]);
        let found = agreements(&table);
        assert!(!found[0].holds() && found[0].sentence(&table).ends_with("in less than one of 1000 cases."));
        assert!(agreements(&self::table(&[None, None])).is_empty());
    }
}
