//! Output of `sagnac psd` for people.

use sagnac::allan::deviation::Deviation;
use sagnac::analysis::data_sheet::Row;
use sagnac::analysis::log::notes::heading;
use sagnac::analysis::log::{Column, events};
use sagnac::analysis::spectrum::notes::{method, symbol};
use sagnac::analysis::spectrum::{Analysis, Spectrum, White};
use sagnac::quantity::number::significant;
use sagnac::spectrum::lines::{FALSE_ALARM, Line};
use sagnac::table::titled;

use crate::psd::axes;
use crate::shown::{THIS, shown};
use crate::terminal::{WITH_INTERVAL, headed, number, with_interval, with_its_interval};

/// Lines of a density per octave.
const PER_OCTAVE: f64 = 2.0;

/// The spectrum of a column, or tables over several columns, with the treatment of the data.
pub fn report(analysis: &Analysis) -> String {
    let noise = &analysis.noise;
    let mut text = format!("{}{}\n", heading(noise), noise.treatment.left_out());
    text += &shown(THIS, &events::rows(noise));
    if let [_, _, ..] = analysis.spectra[..] {
        return text + &noise.units().map(|unit| axes::report(analysis, unit)).collect::<String>();
    }
    for (column, spectrum) in analysis.columns() {
        text += &format!("\n{}: density, {}\n", column.name, method(spectrum));
        text += &density(analysis, column, spectrum);
        text += &lines(column, spectrum);
        text += &white(column, &spectrum.white);
    }
    text
}

/// Means of the density beside the fitted model.
fn density(analysis: &Analysis, column: &Column, spectrum: &Spectrum) -> String {
    let line = |point: sagnac::spectrum::Point| {
        let [value, lower, upper] = with_its_interval(Some(point.value), point.interval.map(Into::into), 4);
        let fit = number(spectrum.model_at(point.frequency_hz), 4);
        vec![significant(point.frequency_hz, 5), value, lower, upper, fit]
    };
    let title = titled("means over half an octave", symbol(column.unit));
    let table = headed(
        ["f, Hz", "density", "lower", "upper", "fit"],
        spectrum.means(PER_OCTAVE).into_iter().map(line),
    );
    format!(
        "  {title}, with {} intervals; psd.csv has all {} frequencies\n{table}",
        analysis.noise.percent(),
        spectrum.density.points.len()
    )
}

/// The lines that were found.
fn lines(column: &Column, spectrum: &Spectrum) -> String {
    let percent = significant(100.0 * FALSE_ALARM, 2);
    if spectrum.lines.is_empty() {
        return format!("  no line; noise alone shows one in {percent} % of records\n");
    }
    let amplitude = titled("amplitude", column.unit.symbol(Deviation::Oadev));
    let heading = ["f, Hz", &amplitude, "over floor", "p"];
    format!(
        "  lines; noise alone shows one in {percent} % of records\n{}",
        headed(heading, spectrum.lines.iter().map(|line| of_line(line).into()))
    )
}

/// Frequency, amplitude, height over the floor and p of a line.
pub(super) fn of_line(line: &Line) -> [String; 4] {
    [(line.frequency_hz, 6), (line.amplitude, 4), (line.over_floor, 3), (line.p, 2)]
        .map(|(x, digits)| significant(x, digits))
}

/// N by the floor beside N by the fit.
fn white(column: &Column, white: &White) -> String {
    let line =
        |(from, row): (&str, &Row)| with_interval(from, row.value, row.interval, row.symbol, row.verdict);
    let rows = [("N of the floor", &white.from_floor), ("N of the fit", &white.from_fit)];
    let rows = rows.into_iter().filter_map(|(from, row)| Some((from, row.as_ref()?)));
    let range = white.floor.as_ref().map_or_else(String::new, |floor| {
        let [from, to] = floor.range_hz.map(|end| significant(end, 3));
        format!(" from {from} to {to} Hz")
    });
    let others = white.model.map_or_else(String::new, |[_, others]| {
        format!("; {} % of the fitted density there is of other terms", significant(100.0 * others, 2))
    });
    let table = headed(WITH_INTERVAL, rows.map(line));
    format!("{}: white noise{range}: {}{others}\n{table}", column.name, white.verdict())
}
