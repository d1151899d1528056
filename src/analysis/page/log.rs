//! The page of a log, with the sections that only some have, and that of a curve that was read from a file.

use rayon::prelude::*;

use crate::analysis::compare::answer::duration;
use crate::analysis::compare::equality_test::expected;
use crate::analysis::data_sheet::{Row, each_once};
use crate::analysis::dynamic::{self, Dynamic};
use crate::analysis::given_curve;
use crate::analysis::log::{Analysis as Noise, Column, events, figures, noise_file, report};
use crate::analysis::page::record::{self, Source, by_name};
use crate::analysis::page::{
    chart, grid, grid_where, in_unit, interval, minimum, range, shown, side_by_side, texts,
};
use crate::analysis::spectrum::report::{method, symbol};
use crate::analysis::spectrum::{Analysis, NoSpectrum, Spectrum, report as of_spectra};
use crate::analysis::temperature::{self, Temperature};
use sagnac_base::quantity::number::{probability, significant, with_unit};
use sagnac_base::table::titled;
use sagnac_records::allan::{Deviation, Overdispersion, Unit};
use sagnac_records::fit::{Fit, Terms, Verdict};
use sagnac_records::record::log::Log;
use sagnac_records::spectrum::{FALSE_ALARM, Line, Point};
use sagnac_report::answer::Answer;
use sagnac_report::chart::Picture;
use sagnac_report::chart::figure::Figure;
use sagnac_report::page::{Block, Grid, Page, Section};
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
        ("ranking.csv", report::ranking(&noise.columns)),
        ("records.csv", of_spectra::records(analysis)),
    ];
    let columns = log.channels.iter().zip(&noise.columns);
    let sources =
        columns.map(|(channel, column)| Source { name: &column.name, log, channel, analysis: noise, column });
    let sources: Vec<Source> = sources.collect();
    let sections = [
        deviations(noise),
        coefficients(noise),
        spectra(analysis, without),
        shown("What this record shows", &events::rows(noise)),
        record::section("Record", &sources, "columns", noise.treatment.lines(noise.length_s())),
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
    let table = report::table(noise);
    let [names, deviations] = ["column", "deviation"].map(|name| texts(&table, name));
    let of_unit = |unit: Unit| {
        let columns: Vec<&Column> = noise.of_unit(unit).collect();
        let of_deviation = |deviation: Deviation| {
            let title = titled(deviation.title(), unit.symbol(deviation));
            let is_meant = |row: usize| {
                deviations[row] == deviation.name() && columns.iter().any(|column| column.name == names[row])
            };
            let omitted = ["column", "deviation", "m", "unit", "alpha_from", "treatment", "edf", "edf_from"];
            let grid = match columns.len() {
                1 => grid_where(&table, &omitted, is_meant),
                _ => side_by_side(&table, &["tau"], is_meant),
            };
            Block::More(format!("{title}, with {} intervals", noise.percent()), grid)
        };
        let curves = columns.first().map_or(&[][..], |column| &column.curves);
        curves.iter().map(|curve| of_deviation(curve.deviation)).collect::<Vec<_>>()
    };
    noise.units().flat_map(of_unit).collect()
}

fn coefficients(noise: &Noise) -> Section {
    let table = report::coefficients(noise);
    let [names, coefficients] = ["column", "coefficient"].map(|name| texts(&table, name));
    let of_unit = |unit: Unit| {
        let columns: Vec<&Column> = noise.of_unit(unit).collect();
        // The minimum of the curve is a line below.
        let is_meant = |row: usize| {
            !coefficients[row].starts_with(report::MINIMUM)
                && columns.iter().any(|one| one.name == names[row])
        };
        let omitted = ["column", "intervals", "fit_from", "fit_to", "fitted"];
        match columns.len() {
            1 => grid_where(&table, &omitted, is_meant),
            _ => side_by_side(&table, &["coefficient", "unit"], is_meant),
        }
    };
    let grids = noise.units().map(of_unit).filter(|grid| !grid.rows.is_empty()).map(Block::Grid);
    let of = |text: &dyn Fn(&Column) -> Option<String>| {
        by_name(noise.columns.iter().filter_map(|column| Some((&*column.name, text(column)?))).collect())
    };
    let facts = [
        ("Fit", of(&fit)),
        ("95 % intervals", of(&|column| Some(column.noise()?.intervals.words()))),
        ("Curve minimum", of(&minimum)),
        ("Record that would show B", by_name(longer_records(noise))),
    ];
    let facts: Vec<_> = facts.into_iter().filter(|(_, lines)| !lines.is_empty()).collect();
    let facts = (!facts.is_empty()).then_some(Block::Facts(facts));
    let ranking = report::ranking(&noise.columns);
    let omitted: &[&str] = if noise.columns.len() == 1 { &["column"] } else { &[] };
    let ranked =
        Block::More("Models ranked by the wavelet information criterion".to_owned(), grid(&ranking, omitted));
    Section::new(
        "coefficients",
        "Coefficients",
        grids.chain(facts).chain((ranking.rows() > 0).then_some(ranked)),
    )
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
fn is_shown(fit: &Fit, b: f64, samples: f64, terms: &Terms, spread: Overdispersion) -> bool {
    let others = fit.process.parts.iter().filter(|part| part.term != Term::BiasInstability);
    let part = Term::BiasInstability.part(b * b, 1.0, 1);
    let process = Process { parts: others.copied().chain([part]).collect(), ..fit.process };
    let fit = expected(&process, samples as u64, spread, fit.tau_range[0], terms);
    let found = fit.as_ref().and_then(|fit| fit.coefficient(Term::BiasInstability));
    found.is_some_and(|found| found.verdict == Verdict::Identified)
}

/// The section on the dependence of a log on temperature, with its analyses before and after compensation.
pub fn of_temperature(found: &Temperature, [before, after]: [&Noise; 2]) -> Section {
    let charts = temperature::report::figures(found, [before, after]).into_iter();
    let charts = charts.map(|(stem, figure)| chart(&stem, Picture::Curves(figure)));
    let coefficients = grid(&temperature::report::coefficients(found), &["intervals"]);
    let grids = [coefficients, compensated(found, [before, after])].into_iter();
    let grids = grids.filter(|grid| !grid.rows.is_empty()).map(Block::Grid);
    let range = found.columns.iter().filter_map(|column| {
        let [low, high] = column.found.as_ref().ok()?.averages.range_c.map(|end| significant(end, 4));
        Some((&*column.name, format!("{low} to {high} °C")))
    });
    let range = by_name(range.collect());
    let range = (!range.is_empty()).then(|| Block::Facts(vec![("Range", range)]));
    let notes = temperature::report::notes(found).into_iter().map(Block::Note);
    Section::new("temperature", "Temperature", charts.chain(grids).chain(range).chain(notes))
}

/// The coefficients of the noise before and after compensation, in the order before.
fn compensated(found: &Temperature, sides: [&Noise; 2]) -> Grid {
    let of_column = |place: usize| {
        let [before, after] = sides.map(|side| side.columns[place].coefficients());
        let value = |rows: &[Row], name: &str| {
            let value = rows.iter().find(|row| row.name == name).and_then(|row| row.value);
            value.map_or_else(|| "–".to_owned(), |value| significant(value, 4))
        };
        let name = &*sides[0].columns[place].name;
        let rows = each_once(before.iter().chain(after)).into_iter().map(move |row| {
            let [before, after] = [before, after].map(|rows| value(rows, row.name));
            [name.to_owned(), row.name.to_owned(), before, after, row.symbol.to_owned()]
        });
        rows.collect::<Vec<_>>()
    };
    let known = (0..found.columns.len()).filter(|&place| found.columns[place].found.is_ok());
    let head = ["column", "noise", "before compensation", "after", "unit"];
    Grid::new(head, known.flat_map(of_column))
}

/// The section on navigators with the gyros of a log, beside another answer.
pub fn of_navigators(found: &Answer) -> Section {
    let headline = Block::Text(format!("{}.", found.headline));
    Section::new("navigators", "Navigators", [headline, Block::Options(found.table.clone())])
}

/// The section on the noise of a log over time.
pub fn of_dynamic(found: &Dynamic) -> Section {
    let said =
        found.columns.iter().map(|column| (&*column.name, dynamic::report::sentence(column))).collect();
    let said = by_name(said).into_iter().map(Block::Text);
    let maps = dynamic::report::figures(found).into_iter();
    let maps = maps.map(|(stem, map)| chart(&stem, Picture::Map(map)));
    Section::new("dynamic", "Over time", said.chain(maps))
}

/// The page of a curve from its fit and its answer.
pub fn of_curve(analysis: &given_curve::Analysis, answer: Answer) -> Page {
    let [coefficients, curve] = analysis.tables();
    let file = analysis.path.file_name().unwrap_or(analysis.path.as_os_str()).to_string_lossy();
    let charts =
        [Some(("chart", analysis.figure())), analysis.residuals().map(|figure| ("residuals", figure))];
    let charts = charts.into_iter().flatten().map(|(stem, figure)| chart(stem, Picture::Curves(figure)));
    let omitted = ["column", "deviation", "unit", "treatment"];
    let symbol = analysis.file.unit.symbol(analysis.file.deviation);
    let title = format!("{}, with 95 % intervals", titled("Allan deviation", symbol));
    let points = Block::More(title, grid(&curve.1, &omitted));
    let names = texts(&coefficients.1, "coefficient");
    let values =
        grid_where(&coefficients.1, &["column", "intervals", "fit_from", "fit_to", "fitted"], |row| {
            !names[row].starts_with(report::MINIMUM)
        });
    let fit = analysis.column.noise().map(|noise| {
        let (fit, described) = (&noise.fit, if noise.fit.is_described() { "" } else { "; model rejected" });
        let p = fit.p_value().map_or_else(String::new, |p| format!(", p = {}", significant(p, 2)));
        let (chi_squared, freedom) = (significant(fit.chi_squared, 3), fit.degrees_of_freedom);
        format!("{}, χ² = {chi_squared} of {freedom} degrees of freedom{p}{described}", range(fit))
    });
    let facts = [
        ("Fit", fit),
        ("Errors of the points", Some(analysis.file.errors.clone())),
        ("Curve minimum", minimum(&analysis.column)),
    ];
    let facts = facts.into_iter().filter_map(|(name, text)| Some((name, vec![text?]))).collect();
    Page {
        title: format!("Noise of {file}"),
        scope: String::new(),
        subtitle: format!("Which noise does this curve show? {}", analysis.heading()),
        answer,
        notes: analysis.notes(),
        sections: vec![
            Section::new("deviations", "Deviations", charts.chain([points])),
            Section::new("coefficients", "Coefficients", [Block::Grid(values), Block::Facts(facts)]),
        ],
        tables: vec![coefficients, curve],
    }
}

/// Rows of a density per octave.
const PER_OCTAVE: f64 = 2.0;

/// Most lines in the small table; `lines.csv` has all.
const MAX_LINES: usize = 20;

/// The section on the spectra of a log.
fn spectra(analysis: &Analysis, without: Option<&NoSpectrum>) -> Section {
    let why = without
        .map(|why| Block::Text(format!("There is no spectrum. {}", why.to_string().replace('\n', "; "))));
    let charts = of_spectra::figures(analysis).into_iter().map(|(stem, mut figure)| {
        // Under several columns, each frequency of all of them hides the others.
        if figure.series.len() > 1 {
            figure.laws.clear();
        }
        chart(&stem, Picture::Curves(figure))
    });
    let methods = analysis.columns().map(|(column, spectrum)| (&*column.name, method(spectrum))).collect();
    let method = by_name(methods).into_iter().map(Block::Note);
    let white = of_spectra::white_noise(analysis);
    let white = (white.rows() > 0).then(|| Block::Grid(grid(&white, &["n_verdict"])));
    let blocks = why.into_iter().chain(charts).chain(method).chain(lines(analysis)).chain(white);
    let means = analysis.columns().map(|column| means(analysis, column));
    Section::new("spectrum", "Spectrum", blocks.chain(means))
}

/// The means of the density of a column beside the fitted model.
fn means(analysis: &Analysis, (column, spectrum): (&Column, &Spectrum)) -> Block {
    let row = |point: Point| {
        let fit = spectrum.model_at(point.frequency_hz).map_or_else(String::new, |fit| significant(fit, 4));
        let ends = point.interval.map_or_else(String::new, |ends| interval(ends.into()));
        let [frequency, value] =
            [(point.frequency_hz, 5), (point.value, 4)].map(|(x, digits)| significant(x, digits));
        [frequency, value, ends, fit]
    };
    let ends = format!("{} interval", analysis.noise.percent());
    let head = ["frequency, Hz", "density", &ends, "fit"];
    let title = titled(&format!("{}: density, means over half an octave", column.name), symbol(column.unit));
    Block::More(title, Grid::new(head, spectrum.means(PER_OCTAVE).into_iter().map(row)))
}

/// The highest lines of all columns.
fn lines(analysis: &Analysis) -> Vec<Block> {
    let percent = significant(100.0 * FALSE_ALARM, 2);
    let mut all: Vec<(&Column, &Line)> = analysis
        .columns()
        .flat_map(|(column, spectrum)| spectrum.lines.iter().map(move |line| (column, line)))
        .collect();
    let count = all.len();
    all.sort_by(|a, b| b.1.over_floor.total_cmp(&a.1.over_floor));
    all.truncate(MAX_LINES);
    let row = |(column, line): &(&Column, &Line)| {
        let amplitude = in_unit(line.amplitude, column.unit.symbol(Deviation::Oadev));
        let (frequency, over) = (significant(line.frequency_hz, 6), significant(line.over_floor, 3));
        [column.name.clone(), frequency, amplitude, over, probability(line.p)]
    };
    let head = ["line in", "frequency, Hz", "amplitude", "over floor", "by noise alone"];
    let said = match (count, analysis.spectra.len()) {
        (_, 0) => return vec![],
        (0, _) => {
            return vec![Block::Text(format!(
                "There is no line; noise alone shows one in {percent} % of records."
            ))];
        }
        (count, _) if count > MAX_LINES => {
            format!("These are the {MAX_LINES} highest of {count} lines; lines.csv has all.")
        }
        _ => format!("Noise alone shows a line in {percent} % of records."),
    };
    vec![Block::Text(said), Block::Grid(Grid::new(head, all.iter().map(row)))]
}
