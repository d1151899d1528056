//! The section on the spectrum of a log.

use crate::analysis::log::Column;
use crate::analysis::page::record::by_name;
use crate::analysis::page::{chart, grid, in_unit, interval};
use crate::analysis::spectrum::report::{method, symbol};
use crate::analysis::spectrum::{Analysis, NoSpectrum, Spectrum, report};
use sagnac_base::quantity::number::{probability, significant};
use sagnac_base::table::titled;
use sagnac_records::allan::Deviation;
use sagnac_records::spectrum::{FALSE_ALARM, Line, Point};
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Grid, Section};

/// Rows of a density per octave.
const PER_OCTAVE: f64 = 2.0;

/// Most lines in the small table; `lines.csv` has all.
const MAX_LINES: usize = 20;

pub(crate) fn section(analysis: &Analysis, without: Option<&NoSpectrum>) -> Section {
    let why = without
        .map(|why| Block::Text(format!("There is no spectrum. {}", why.to_string().replace('\n', "; "))));
    let charts = report::figures(analysis).into_iter().map(|(stem, mut figure)| {
        // Under several columns, each frequency of all of them hides the others.
        if figure.series.len() > 1 {
            figure.laws.clear();
        }
        chart(&stem, Picture::Curves(figure))
    });
    let methods = analysis.columns().map(|(column, spectrum)| (&*column.name, method(spectrum))).collect();
    let method = by_name(methods).into_iter().map(Block::Note);
    let white = report::white_noise(analysis);
    let white = (white.rows() > 0).then(|| Block::Grid(grid(&white, &["n_verdict"])));
    let blocks = why.into_iter().chain(charts).chain(method).chain(lines(analysis)).chain(white);
    let means = analysis.columns().map(|column| means(analysis, column));
    Section::new("spectrum", "Spectrum", blocks.chain(means))
}

/// Means of the density of a column beside the fitted model.
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
