//! The dependence on temperature: its files, and its part of the report.

use sagnac::allan::TauError;
use sagnac::analysis::data_sheet;
use sagnac::analysis::log::{self, Analysis};
use sagnac::analysis::page::of_temperature;
use sagnac::analysis::temperature::tables::{self, Row, rows};
use sagnac::analysis::temperature::{Column, Temperature, figures};
use sagnac::quantity::number::significant;
use sagnac::record::log::channel::Log;
use sagnac::store::folder::Folder;
use sagnac::view::report::sections::Section;
use serde_json::Value;

use crate::charts::write_figures;
use crate::failure::Failure;
use crate::output::write_or_remove;
use crate::terminal::{WITH_INTERVAL, headed, number, with_interval};

/// A dependence with the analysis that is not the main one: that of the compensated log, or of the log as it is.
pub struct Thermal {
    temperature: Temperature,
    other: Analysis,
}

impl Thermal {
    /// The dependence with both analyses. If it is `to_compensate`, log and analysis are exchanged for those without it.
    pub fn of(
        temperature: Temperature,
        to_compensate: bool,
        log: &mut Log,
        analysis: &mut Analysis,
        of: impl Fn(&Log) -> Result<Analysis, TauError>,
    ) -> Result<Thermal, TauError> {
        let mut compensated = temperature.compensated(log);
        let mut other = of(&compensated)?;
        if to_compensate {
            std::mem::swap(log, &mut compensated);
            std::mem::swap(analysis, &mut other);
        }
        Ok(Thermal { temperature, other })
    }

    /// The analyses before and after compensation.
    fn sides<'a>(&'a self, analysis: &'a Analysis) -> [&'a Analysis; 2] {
        if analysis.treatment.is_compensated { [&self.other, analysis] } else { [analysis, &self.other] }
    }

    /// The dependence as JSON.
    pub fn document(&self, analysis: &Analysis) -> Value {
        let [_, after] = self.sides(analysis);
        tables::document(&self.temperature, after, analysis.treatment.is_compensated)
    }

    /// The section of the page.
    pub fn section(&self, analysis: &Analysis) -> Section {
        let [before, after] = self.sides(analysis);
        of_temperature(&self.temperature, before, after)
    }

    /// The coefficients of all columns, and those of their noise before and after.
    pub fn report(&self, analysis: &Analysis) -> String {
        let [before, after] = self.sides(analysis);
        let of = |(column, (before, after)): (&Column, (&log::Column, &log::Column))| {
            let noises = [before, after].map(|column| column.coefficients());
            coefficients(column) + &noise(column, noises)
        };
        self.temperature.columns.iter().zip(before.columns.iter().zip(&after.columns)).map(of).collect()
    }
}

/// Writes tables and charts, and removes those of an earlier run that this one lacks.
pub fn save(thermal: Option<&Thermal>, analysis: &Analysis, folder: &Folder) -> Result<(), Failure> {
    let temperature = thermal.map(|thermal| &thermal.temperature);
    write_or_remove(folder, "temperature.csv", temperature.map(tables::coefficients))?;
    write_or_remove(folder, "compensation.csv", temperature.map(tables::compensation))?;
    let sides = thermal.map_or([analysis; 2], |thermal| thermal.sides(analysis));
    write_figures(folder, &figures::figures(temperature, sides))
}

fn coefficients(column: &Column) -> String {
    let Ok(found) = &column.found else { return String::new() };
    let line = |row: &Row| with_interval(row.name, row.value, row.interval, &row.unit[1], &row.verdict);
    let [low, high] = found.averages.range_c.map(|end| significant(end, 4));
    format!(
        "\n{}: dependence on temperature from {low} to {high} °C, with 95 % intervals\n{}",
        column.name,
        headed(WITH_INTERVAL, rows(column).iter().map(line))
    )
}

/// The coefficients of the noise before and after, where they are the same ones.
fn noise(column: &Column, [before, after]: [&[data_sheet::Row]; 2]) -> String {
    if column.found.is_err() || before.is_empty() && after.is_empty() {
        return String::new();
    }
    let of = |rows: &[data_sheet::Row], name: &str| {
        let value = rows.iter().find(|row| row.name == name).and_then(|row| row.value);
        number(value, 4)
    };
    let others = after.iter().filter(|row| before.iter().all(|other| other.name != row.name));
    let line = |row: &data_sheet::Row| {
        vec![row.name.to_owned(), of(before, row.name), of(after, row.name), row.symbol.to_owned()]
    };
    format!(
        "{}: coefficients of the noise before and after compensation\n{}",
        column.name,
        headed(["", "before", "after", ""], before.iter().chain(others).map(line))
    )
}
