//! The page of a log.

use rayon::prelude::*;

use crate::analysis::compare::answer::duration;
use crate::analysis::compare::power_analysis::expected;
use crate::analysis::data_sheet::{Row, each_once};
use crate::analysis::log::{Analysis as Noise, Column, Curve, events, figures, noise_file, report};
use crate::analysis::page::record::{self, by_name};
use crate::analysis::page::{chart, interval, range, shown, spectrum, stability};
use crate::analysis::spectrum::{Analysis, NoSpectrum, report as of_spectra};
use sagnac_base::quantity::number::{significant, with_unit};
use sagnac_base::table::titled;
use sagnac_records::allan::noise::MIN_GROUPS;
use sagnac_records::allan::{Point, Spread, Unit};
use sagnac_records::fit::{Fit, Terms, Verdict};
use sagnac_records::record::log::Log;
use sagnac_report::answer::Answer;
use sagnac_report::chart::Picture;
use sagnac_report::chart::figure::Figure;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};
use sagnac_theory::allan::{Process, Term};

/// How many times longer records are tried.
const LONGER: [f64; 3] = [4.0, 16.0, 64.0];
/// Most samples of a tried record, for which there is flicker.
const MAX_SAMPLES: f64 = 6e7;

/// The page of a log from its analysis and its answer. If it has no spectra, `without` says why.
pub fn of_log(log: &Log, analysis: &Analysis, answer: Answer, without: Option<&NoSpectrum>) -> Page {
    let noise = &analysis.noise;
    let file = noise.path.file_name().unwrap_or(noise.path.as_os_str()).to_string_lossy();
    let has_spectra = !analysis.spectra.is_empty();
    let of_spectra = has_spectra.then(|| {
        [("lines.csv", of_spectra::lines(analysis)), ("white_noise.csv", of_spectra::white_noise(analysis))]
    });
    let of_noise = [
        ("coefficients.csv", report::coefficients(noise)),
        ("curve.csv", report::table(noise)),
        ("events.csv", events::table(noise)),
        ("records.csv", of_spectra::records(analysis)),
    ];
    let sections = [
        deviations(noise),
        coefficients(noise),
        spectrum::section(analysis, without),
        shown("What this record shows", &events::rows(noise)),
        record::section(log, noise),
    ];
    Page {
        title: format!("Noise of {file}"),
        scope: String::new(),
        subtitle: format!(
            "Which noise does this log show? {}; {}",
            report::heading(noise),
            noise.treatment.summary()
        ),
        answer,
        notes: of_spectra::notes(analysis).into_iter().chain(noise_file::notes(noise)).collect(),
        sections: sections.into(),
        tables: of_noise.into_iter().chain(of_spectra.into_iter().flatten()).collect(),
    }
}

/// The section on the curves, with the range of the fit if there is a single column.
fn deviations(noise: &Noise) -> Section {
    let fit = match &noise.columns[..] {
        [column] => column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described()),
        _ => None,
    };
    let of_figure = |(stem, mut figure): (String, Figure)| {
        if let Some(fit) = fit {
            figure.lines = format!("{}, {}", figure.lines, range(fit));
        }
        chart(&stem, Picture::Curves(figure))
    };
    let residuals = figures::residuals(noise).map(|figure| chart("residuals", Picture::Curves(figure)));
    let mut blocks: Vec<Block> = figures::figures(noise).into_iter().map(of_figure).collect();
    // Right below the curve.
    if let Some(residuals) = residuals {
        blocks.insert(blocks.len().min(1), residuals);
    }
    blocks.extend(curve_tables(noise));
    Section::new("deviations", "Deviations", blocks)
}

/// A table for each deviation of each unit.
fn curve_tables(noise: &Noise) -> Vec<Block> {
    let of_unit = |unit: Unit| {
        let columns: Vec<&Column> = noise.of_unit(unit).collect();
        let count = columns.first().map_or(0, |column| column.curves.len());
        let of_deviation = |at: usize| {
            let curves: Vec<&Curve> = columns.iter().map(|column| &column.curves[at]).collect();
            let deviation = curves[0].deviation;
            let title = titled(deviation.title(), unit.symbol(deviation));
            let grid = match (&curves[..], &columns[..]) {
                ([curve], _) => of_curve(curve, unit, &noise.percent()),
                (_, columns) => of_curves(&curves, columns),
            };
            Block::More(format!("{title}, with {} intervals", noise.percent()), grid)
        };
        (0..count).map(of_deviation).collect::<Vec<_>>()
    };
    noise.units().flat_map(of_unit).collect()
}

/// A row for each averaging time of a curve.
fn of_curve(curve: &Curve, unit: Unit, percent: &str) -> Grid {
    let row = |point: &Point| {
        let kind = point.noise.map_or_else(String::new, |noise| {
            let carried =
                if noise.carried { format!(", below {MIN_GROUPS} averages") } else { String::new() };
            format!("{} (α = {}){carried}", noise.name(unit), noise.alpha)
        });
        let [tau, terms] = [significant(point.tau_s, 7), point.terms.to_string()];
        let value = point.value.map_or_else(String::new, |value| significant(value, 4));
        let ends = point.interval.map_or_else(String::new, |ends| interval(ends.into()));
        [tau, terms, value, ends, kind]
    };
    let ends = format!("{percent} interval");
    let head = ["τ, s", "number", curve.deviation.name(), &ends, "noise"];
    Grid::new(head, curve.points.iter().map(row))
}

/// A row for each averaging time, with a cell for each column.
fn of_curves(curves: &[&Curve], columns: &[&Column]) -> Grid {
    let row = |at: usize| {
        let cell = |curve: &&Curve| {
            let point = &curve.points[at];
            let below = point.interval.map_or_else(String::new, |ends| interval(ends.into()));
            point.value.map_or_else(Cell::default, |value| Cell { text: significant(value, 4), below })
        };
        let tau = significant(curves[0].points[at].tau_s, 7).into();
        std::iter::once(tau).chain(curves.iter().map(cell)).collect::<Vec<_>>()
    };
    let head = std::iter::once("τ, s").chain(columns.iter().map(|column| &*column.name));
    Grid::new(head, (0..curves[0].points.len()).map(row))
}

fn coefficients(noise: &Noise) -> Section {
    let columns: Vec<&Column> =
        noise.columns.iter().filter(|column| !column.coefficients().is_empty()).collect();
    let is_there = |unit: &Unit| columns.iter().any(|column| column.unit == *unit);
    let grids = Unit::ALL.into_iter().filter(is_there).map(|unit| {
        let columns: Vec<&Column> = columns.iter().copied().filter(|column| column.unit == unit).collect();
        Block::Grid(if let [column] = columns[..] { of_column(column) } else { of_columns(&columns) })
    });
    let of = |said: &dyn Fn(&Column) -> Option<String>| {
        by_name(noise.columns.iter().filter_map(|column| Some((&*column.name, said(column)?))).collect())
    };
    let facts = [
        ("Fit", of(&fit)),
        ("95 % intervals", of(&|column| Some(column.noise()?.intervals.words()))),
        ("In-run bias stability", of(&stability)),
        ("Record that would show B", by_name(longer_records(noise))),
    ];
    let facts: Vec<_> = facts.into_iter().filter(|(_, lines)| !lines.is_empty()).collect();
    let facts = (!facts.is_empty()).then_some(Block::Facts(facts));
    Section::new("coefficients", "Coefficients", grids.chain(facts))
}

/// A row for each coefficient.
fn of_column(column: &Column) -> Grid {
    let row = |row: &Row| {
        let interval = match (row.value, row.interval) {
            (Some(_), Some(ends)) => interval(ends),
            _ => bound(row),
        };
        let value = row.value.map_or_else(String::new, |value| significant(value, 4));
        [row.name.to_owned(), value, interval, row.symbol.to_owned(), row.verdict.to_owned()]
    };
    let head = ["coefficient", "value", "95 % interval", "unit", "status"];
    Grid::new(head, column.coefficients().iter().map(row))
}

/// A row for each coefficient, with a cell for each column.
fn of_columns(columns: &[&Column]) -> Grid {
    let found = each_once(columns.iter().flat_map(|column| column.coefficients()));
    let row = |first: &&Row| {
        let cell = |column: &&Column| {
            let own = column.coefficients().iter().find(|row| row.name == first.name);
            own.map_or_else(Cell::default, cell)
        };
        let named = [first.name, first.symbol].map(Cell::from);
        named.into_iter().chain(columns.iter().map(cell)).collect::<Vec<_>>()
    };
    let head = ["coefficient", "unit"].into_iter().chain(columns.iter().map(|column| &*column.name));
    Grid::new(head, found.iter().map(row))
}

/// A value over its interval, or a bound over the verdict.
pub(super) fn cell(row: &Row) -> Cell {
    match (row.value, row.interval) {
        (Some(value), Some(ends)) => Cell { text: significant(value, 4), below: interval(ends) },
        (Some(value), None) => significant(value, 4).into(),
        (None, _) => {
            // What the bound says already is left out.
            let verdict = row.verdict.split(',').next().unwrap_or_default();
            Cell { text: bound(row), below: verdict.to_owned() }
        }
    }
}

/// The upper end of the interval of a coefficient without a value.
fn bound(row: &Row) -> String {
    row.interval.map_or_else(|| "–".to_owned(), |[_, most]| format!("≤ {}", significant(most, 3)))
}

/// The range of a fit, and how well it describes the curve.
fn fit(column: &Column) -> Option<String> {
    let fit = &column.noise()?.fit;
    let p = fit.p_value().map_or_else(String::new, |p| format!(", p = {}", significant(p, 2)));
    let described = if fit.is_described() { "" } else { "; model rejected" };
    let freedom = fit.degrees_of_freedom;
    let chi_squared = significant(fit.chi_squared, 3);
    let range = range(fit);
    Some(format!("{range}, χ² = {chi_squared} of {freedom} degrees of freedom{p}{described}"))
}

/// For each column whose B is not identified, the record that would show half of its bound, with the name of the column.
fn longer_records(noise: &Noise) -> Vec<(&str, String)> {
    noise
        .columns
        .par_iter()
        .filter_map(|column| Some((&*column.name, longer_record(noise, column)?)))
        .collect()
}

fn longer_record(noise: &Noise, column: &Column) -> Option<String> {
    let fit = &column.noise()?.fit;
    let found =
        fit.coefficient(Term::BiasInstability).filter(|found| found.verdict != Verdict::Identified)?;
    let [_, most] = found.interval.filter(|_| fit.is_described())?;
    let row = column.coefficients().iter().find(|row| row.name == Term::BiasInstability.symbol())?;
    let half = with_unit(0.5 * row.interval?[1], 2, row.symbol);
    let terms = Terms::of_model(noise.treatment.trend);
    let samples = noise.samples as f64;
    let mut tried = LONGER.into_iter().filter(|factor| factor * samples <= MAX_SAMPLES);
    let shown = tried
        .find(|factor| is_shown(fit, 0.5 * most, factor * samples, &terms, column.spread.over(*factor)))?;
    let length = duration(shown * noise.length_s());
    Some(format!("{length} ({} × as long), if it is {half}", significant(shown, 2)))
}

/// Whether the mean curve of records of this length shows a bias instability b besides the other terms of a fit.
fn is_shown(fit: &Fit, b: f64, samples: f64, terms: &Terms, spread: Spread) -> bool {
    let others = fit.process.parts.iter().filter(|part| part.term != Term::BiasInstability);
    let part = Term::BiasInstability.part(b * b, 1.0, 1);
    let process = Process { parts: others.copied().chain([part]).collect(), ..fit.process };
    let fit = expected(&process, samples as u64, spread, fit.tau_range[0], terms);
    let found = fit.as_ref().and_then(|fit| fit.coefficient(Term::BiasInstability));
    found.is_some_and(|found| found.verdict == Verdict::Identified)
}
