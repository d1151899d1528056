//! The chart of a spectrum.

use crate::analysis::data_sheet::Row;
use crate::analysis::log::Column;
use crate::analysis::log::figures::{of_columns, per_unit};
use crate::analysis::log::notes::heading;
use crate::analysis::spectrum::notes::symbol;
use crate::analysis::spectrum::{Analysis, Spectrum};
use sagnac_base::quantity::number::{joined, significant};
use sagnac_records::allan::Unit;
use sagnac_records::spectrum::Point;
use sagnac_report::chart::figure::{self, Axis, Figure, Law, LawLine, Parts, Series, SeriesPoint};
use sagnac_theory::allan::spectrum::density;
use sagnac_theory::allan::{Part, Term};

/// Points per octave.
const PER_OCTAVE: f64 = 12.0;

/// The figures with the stems of their file names, one for each unit.
pub fn figures(analysis: &Analysis) -> Vec<(String, Figure)> {
    per_unit(&analysis.noise, "psd", |unit| figure(analysis, unit))
}

/// The densities of the columns of a unit with the fitted models over them; `None` without columns.
fn figure(analysis: &Analysis, unit: Unit) -> Option<Figure> {
    let all: Vec<(&Column, &Spectrum)> =
        analysis.columns().filter(|(column, _)| column.unit == unit).collect();
    let &(first, spectrum) = all.first()?;
    let several = all.len() > 1;
    let names = all.iter().map(|(column, _)| column.name.clone());
    let series: Vec<Series> =
        (0..).zip(&all).map(|(colour, (_, spectrum))| series(colour, spectrum)).collect();
    let full = (0..).zip(&all).map(|(colour, (_, spectrum))| LawLine {
        colours: vec![colour],
        points: spectrum.density.points.iter().map(|point| (point.frequency_hz, point.value)).collect(),
    });
    Some(Figure {
        title: format!("One-sided power spectral density of the {}", unit.measured()),
        subtitle: Some(format!(
            "{}; {} segments of {} s; {}",
            heading(&analysis.noise),
            spectrum.density.segments,
            significant(spectrum.density.segment as f64 * spectrum.density.step_s, 6),
            analysis.noise.treatment.summary()
        )),
        x: Axis::new("frequency", "Hz"),
        y: Axis::new("density", symbol(unit)),
        colours: of_columns(names),
        points: "mean over 1/12 octave".to_owned(),
        bands: format!("{} intervals", analysis.noise.percent()),
        lines: "fit of the Allan curve".to_owned(),
        series,
        laws: vec![Law { label: "each frequency".to_owned(), lines: full.collect(), is_area: false }],
        parts: if several { Parts::default() } else { parts(first, spectrum) },
        ..Figure::default()
    })
}

fn series(colour: usize, spectrum: &Spectrum) -> Series {
    let means = spectrum.means(PER_OCTAVE);
    let point = |point: &Point| SeriesPoint {
        x: point.frequency_hz,
        y: point.value,
        band: point.interval,
        key: None,
    };
    let law =
        means.iter().filter_map(|point| Some((point.frequency_hz, spectrum.model_at(point.frequency_hz)?)));
    Series { colour, dash: 0, law: law.collect(), points: means.iter().map(point).collect() }
}

/// The terms of the fitted model that have a density.
fn parts(column: &Column, spectrum: &Spectrum) -> Parts {
    let means = spectrum.means(PER_OCTAVE);
    let line = |part: &Part| {
        let row = column.coefficients().iter().find(|row| row.name == part.term.symbol())?;
        let at = |point: &Point| {
            let to_hz = spectrum.model.as_ref()?.to_hz;
            let density = density(part, spectrum.density.step_s, point.frequency_hz)?;
            (point.frequency_hz <= to_hz).then_some((point.frequency_hz, density))
        };
        let points: Vec<(f64, f64)> = means.iter().filter_map(at).collect();
        // The first colour is that of the density.
        let colour = 1 + Term::ALL.iter().position(|term| *term == part.term)?;
        (!points.is_empty()).then_some(figure::Part { label: label(row)?, colour, points })
    };
    let lines = spectrum.model.iter().flat_map(|model| &model.process.parts).filter_map(line).collect();
    Parts { title: "parts of the fit".to_owned(), lines }
}

/// A label such as `N = 0.003 °/√h`, with no-break spaces that keep the value with its unit.
fn label(row: &Row) -> Option<String> {
    let label = format!("{} = {}", row.name, joined(&significant(row.fitted?, 3), row.symbol));
    let label = label.trim_end().replace(' ', "\u{a0}");
    Some(if row.value.is_some() { label } else { format!("{label}, not identified") })
}
