//! Errors of three fillers over the frequency, as a table and its chart.

use sagnac::table::{Cell, Column, Role, Table, Unit};
use sagnac_engine::chart::{Chart, Limit, Shows};

pub fn column(name: &str, unit: Unit, cells: Vec<Cell>) -> Column {
    Column { name: name.to_owned(), label: name.to_owned(), unit, cells: cells.into(), ..Column::default() }
}

fn of(role: Role, column: Column) -> Column {
    Column { role, ..column }
}

/// A value for each of so many points and each of the three fillers.
pub fn cells(points: usize, of: impl Fn(usize, usize) -> Option<f64>) -> Vec<Cell> {
    rows(points).map(|(point, filler)| Cell::from(of(point, filler))).collect()
}

fn rows(points: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..points).flat_map(|point| (0..3).map(move |filler| (point, filler)))
}

/// So many points of three fillers, whose errors are `error(point, filler)`.
pub fn table(points: usize, error: impl Fn(usize, usize) -> Option<f64>) -> Table {
    let names =
        rows(points).map(|row| Cell::Text(["const", "linear", "quadratic"][row.1].to_owned())).collect();
    let mut rms = column("rms", Unit::ARCSEC, cells(points, &error));
    let band = |(point, filler)| error(point, filler).map(|rms| (0.99 * rms, 1.01 * rms));
    rms.role = Role::Error;
    rms.band = Some(rows(points).map(band).collect());
    Table {
        columns: vec![
            of(
                Role::Key,
                column(
                    "motion.frequency",
                    Unit::HZ,
                    cells(points, |point, _| Some(1.0 + 0.01 * point as f64)),
                ),
            ),
            of(Role::Key, column("filler", Unit::NONE, names)),
            of(
                Role::Trials,
                column("trials", Unit::NONE, rows(points).map(|_| Cell::Integer(1000)).collect()),
            ),
            rms,
        ],
    }
}

pub fn chart(title: &str) -> Chart {
    Chart {
        title: title.to_owned(),
        x: "frequency".into(),
        y: "rms".into(),
        shows: Shows::Curves { series: vec!["filler".into()], laws: vec![] },
        limit: Some(Limit { value: 10.0, unit: Unit::ARCSEC }),
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
        ..Chart::default()
    }
}
