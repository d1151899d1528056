//! The agreement of simulated values with their closed forms.

use statrs::function::erf::erfc_inv;

use sagnac_base::quantity::number::significant;
use sagnac_base::table::{Column, Role, Table};
use sagnac_report::answer::Check;
use sagnac_report::answer::reading::{capitalized, place};
use sagnac_report::page::{Block, Cell as GridCell, Grid, Section};

/// The deviations of an estimate from its closed form, in standard errors of the simulation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Agreement {
    /// Quantity that deviates, such as `rms error`.
    of: String,
    /// Number of rows with a closed form.
    rows: usize,
    /// Root mean square of the deviations, which is near 1 if they are due to chance only.
    rms: f64,
    /// The largest magnitude.
    largest: f64,
    /// Index of its row.
    at: usize,
}

/// The agreement of every estimate of a table that has closed forms.
fn agreements(table: &Table) -> Vec<Agreement> {
    let deviations = table.columns.iter().filter(|column| column.role == Role::Z);
    let of_column = |column: &Column| {
        Agreement::new(table.referred(column).unwrap_or(column).label.clone(), [column].into_iter())
    };
    deviations.filter_map(of_column).collect()
}

/// The agreement of all estimates as a check.
pub(crate) fn check(table: &Table) -> Option<Check> {
    let all = agreements(table);
    (!all.is_empty()).then(|| Check::Theory {
        values: all.iter().map(|one| one.rows).sum(),
        max_abs_z: all.iter().map(|one| one.largest).fold(0.0, f64::max),
        holds: all.iter().all(Agreement::holds),
    })
}

/// The section on closed forms, with a row for each estimate and one for the representation of the inputs by integers; without
/// blocks where nothing has a closed form.
pub(crate) fn section(table: &Table) -> Section {
    let row = |one: &Agreement, number: &dyn Fn(f64) -> String, below: &str, expected: String| {
        let largest = GridCell { text: number(one.largest), below: below.to_owned() };
        let first = [capitalized(&one.of), one.rows.to_string(), number(one.rms)].map(GridCell::from);
        first.into_iter().chain([largest, expected.into(), place_of(table, one.at).into()]).collect()
    };
    let of_estimate = |one: &Agreement| {
        let number = |z| significant(z, 3);
        let below = if one.holds() { "" } else { "by chance in less than 0.1 % of cases" };
        row(one, &number, below, [0.025, 0.975].map(|p| number(largest_normal(one.rows, p))).join(" … "))
    };
    let mut rows: Vec<Vec<GridCell>> = agreements(table).iter().map(of_estimate).collect();
    let mut text = "z is the difference from the closed form in standard errors; the largest of as many normal numbers is in the \
                    expected range in 95 of 100 cases."
        .to_owned();
    let columns = table.columns.iter().filter(|column| column.role == Role::Representation);
    if let Some(one) = Agreement::new("representation".to_owned(), columns).filter(|_| !rows.is_empty()) {
        let percent = |part: f64| format!("{} %", significant(100.0 * part, 2));
        rows.push(row(&one, &percent, "", "within rounding".to_owned()));
        text += " Representation is the relative difference of the closed forms for the sampled integers and for the inputs.";
    }
    let head = ["quantity", "values", "rms z", "max |z|", "expected", "at"];
    let blocks = (!rows.is_empty()).then(|| [Block::Text(text), Block::Grid(Grid::new(head, rows))]);
    Section::new("closed-forms", "Closed forms", blocks.into_iter().flatten())
}

/// The p quantile of the largest of n independent standard normal magnitudes, below which all n lie with probability p.
fn largest_normal(n: usize, p: f64) -> f64 {
    // 1 − p^(1/n), accurate even where it is tiny.
    let beyond = -libm::expm1(libm::log(p) / n as f64);
    std::f64::consts::SQRT_2 * erfc_inv(beyond)
}

impl Agreement {
    /// The sum of what is known of some columns; `None` without any.
    fn new<'t>(of: String, columns: impl Iterator<Item = &'t Column> + Clone) -> Option<Agreement> {
        let cells = || columns.clone().flat_map(|column| column.cells.iter().enumerate());
        let known = || cells().filter_map(|(row, cell)| Some((row, cell.number()?.abs())));
        let (at, largest) = known().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let rows = known().count();
        let squares: f64 = known().map(|(_, z)| z * z).sum();
        Some(Agreement { of, rows, rms: libm::sqrt(squares / rows as f64), largest, at })
    }

    /// Whether chance explains the largest deviation, which would be as large in more than one of 1000 cases.
    fn holds(&self) -> bool {
        self.largest <= largest_normal(self.rows, 0.999)
    }
}

/// The cells that distinguish a row; of a key and what follows from it, only the key.
fn place_of(table: &Table, row: usize) -> String {
    let told = table.columns.iter().take_while(|column| column.role != Role::Trials);
    let told = told.filter(|column| column.role != Role::Coordinate || column.of.is_empty());
    let unlike = told.filter(|column| column.cells.iter().any(|cell| *cell != column.cells[row]));
    place(&unlike.collect::<Vec<_>>(), row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_base::table::Cell;

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

    /// The texts of the first row of the section.
    fn row(table: &Table) -> Vec<String> {
        let [_, Block::Grid(grid)] = &section(table).blocks[..] else { panic!("no grid") };
        let cell = |cell: &GridCell| format!("{} {}", cell.text, cell.below).trim_end().to_owned();
        grid.rows[0].iter().map(cell).collect()
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
        assert_eq!(row(&table), ["The rms", "3", "2.16", "3", "0.375 … 2.64", "filler 2"]);
    }

    #[test]
    fn what_chance_does_not_explain_is_said_and_without_closed_forms_nothing_is() {
        let table = table(&[Some(0.5), Some(6.0)]);
        assert!(
            !agreements(&table)[0].holds() && row(&table)[3] == "6 by chance in less than 0.1 % of cases"
        );
        assert!(section(&self::table(&[None, None])).blocks.is_empty());
    }
}
