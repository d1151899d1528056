//! `noise.toml`: the identified coefficients of a column, in the form that studies read.

use std::path::Path;

use sagnac_base::quantity::number::significant;
use sagnac_engine::noise::Noise;
use sagnac_records::allan::Unit;
use sagnac_records::fit::Coefficient;
use sagnac_theory::allan::terms::Shape;
use sagnac_theory::allan::{Part, Term};

use crate::analysis::data_sheet::DataSheet;
use crate::analysis::log::report::one_line;
use crate::analysis::log::{Analysis, Column};

/// Most bytes of the name of a column in the name of a file, which file systems limit to 255.
const MAX_BYTES: usize = 200;

/// Beginning of the first line; with its end, it identifies our files.
const START: &str = "# Noise of column ";
const FITTED: &str = ", fitted by sagnac allan";
/// Beginnings of the comments that [`intervals_of`] reads.
const INTERVAL: &str = "# 95 % interval of ";
const UNKNOWN: &str = "# Not identified: ";

/// Name and text of a file for each column whose curve is described by its coefficients, or whose coefficients were taken all the
/// same.
pub fn files(analysis: &Analysis) -> Vec<(String, String)> {
    let named = analysis.columns.iter().zip(names(&analysis.columns));
    named.filter_map(|(column, name)| Some((name, text(analysis, column)?))).collect()
}

/// Notes on columns whose noise no study can take, for the user.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    notes_of(&analysis.columns)
}

/// Notes on some columns; see [`notes`].
pub(crate) fn notes_of(columns: &[Column]) -> Vec<String> {
    let without = |(unit, why): (Unit, &str)| {
        let fitted = columns.iter().filter(|column| column.unit == unit && column.noise().is_some());
        let names: Vec<&str> = fitted.map(|column| column.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("{}: no noise.toml: {why}", names.join(", ")))
    };
    let units = [
        (Unit::Acceleration, "studies are of gyros"),
        (Unit::Plain, "plain numbers are not the noise of a gyro"),
    ];
    units.into_iter().filter_map(without).collect()
}

/// `noise.toml`, or with several columns `noise_<column>.toml`.
pub(crate) fn names(columns: &[Column]) -> Vec<String> {
    if let [_] = columns {
        return vec!["noise.toml".to_owned()];
    }
    let mut names: Vec<String> = Vec::new();
    for (column, number) in columns.iter().zip(1..) {
        let kept = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let mut bytes = 0;
        let is_within = |c: &char| (bytes += c.len_utf8(), bytes <= MAX_BYTES).1;
        let name: String = column.name.chars().map(kept).take_while(is_within).collect();
        let name = format!("noise_{name}.toml");
        // Names may differ only in punctuation, or a column may be taken twice.
        let is_taken = names.iter().any(|other| other.eq_ignore_ascii_case(&name));
        names.push(if is_taken { format!("noise_{number}_{}", &name["noise_".len()..]) } else { name });
    }
    names
}

/// The text for a column of a log.
fn text(analysis: &Analysis, column: &Column) -> Option<String> {
    let (samples, step) = (analysis.samples, significant(analysis.step_s, 9));
    text_of(column, &analysis.path, &format!("{samples} samples of {step} s"), &analysis.treatment.summary())
}

/// The text for a column of a file, with what it was fitted to and how; `None` without coefficients, or if it is not of rotation.
pub(crate) fn text_of(column: &Column, path: &Path, data: &str, treatment: &str) -> Option<String> {
    let is_taken =
        |noise: &&DataSheet| noise.fit.is_described() || noise.rows.iter().any(|row| row.value.is_some());
    let noise = column.noise().filter(|_| column.unit == Unit::Angular).filter(is_taken)?;
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let (name, file) = (one_line(&column.name), one_line(&file));
    let mut text = format!("{START}{name} of {file}: {data}{FITTED}; {treatment}.\n");
    text += &format!("# 95 % intervals {}.\n", noise.intervals.words());
    if !noise.fit.is_described() {
        text += "# Not described: no range of the curve follows these coefficients, which were forced.\n";
    }
    let coefficients = &noise.fit.coefficients;
    for line in coefficients.iter().flat_map(intervals) {
        text += &format!("{INTERVAL}{line}\n");
    }
    let unknown: Vec<String> = coefficients.iter().filter(|c| c.value.is_none()).map(bound).collect();
    if !unknown.is_empty() {
        text += &format!("{UNKNOWN}{}.\n", unknown.join("; "));
    }
    coefficients.iter().filter_map(entry).for_each(|line| text += &format!("{line}\n"));
    Some(text)
}

/// A value with its unit, in the form that studies read.
pub(crate) fn quantity(term: Term, value: f64) -> String {
    let (factor, unit, _) = term.row().unit;
    format!("{} {unit}", significant(factor * value, 6))
}

/// Lines such as `Q: 0.109 to 0.111 arcsec`, with a separate line for a shape.
fn intervals(coefficient: &Coefficient) -> Vec<String> {
    let (Some(_), Some([low, high])) = (coefficient.value, coefficient.interval) else { return vec![] };
    let (term, symbol) = (coefficient.term, coefficient.term.symbol());
    let (factor, unit, _) = term.row().unit;
    let line = |name: &str, [low, high]: [f64; 2], unit: &str| {
        format!("{name}: {} to {} {unit}", significant(low, 6), significant(high, 6))
    };
    let shape = coefficient.shape.zip(term.shape());
    let of_shape = shape.map(|(found, shape)| line(shape.name, found.interval, shape.unit));
    std::iter::once(line(symbol, [low, high].map(|end| factor * end), unit)).chain(of_shape).collect()
}

/// The bound of a coefficient without value.
fn bound(coefficient: &Coefficient) -> String {
    let symbol = coefficient.term.symbol();
    let most = coefficient.interval.map(|[_, most]| quantity(coefficient.term, most));
    most.map_or_else(|| symbol.to_owned(), |most| format!("{symbol} at most {most}"))
}

/// The line of an identified coefficient.
pub(crate) fn entry(coefficient: &Coefficient) -> Option<String> {
    let value = quantity(coefficient.term, coefficient.value?);
    if coefficient.term == Term::BandLimit {
        return Some(format!("# Band limit of the sensor, which no study has: {value}"));
    }
    let key = coefficient.term.row().key.trim_start_matches("noise.");
    Some(match coefficient.shape.zip(coefficient.term.shape()) {
        Some((found, Shape { key: shape, unit, .. })) => {
            let found = significant(found.value, 6);
            format!("{key} = {{ amplitude = \"{value}\", {shape} = \"{found} {unit}\" }}")
        }
        None => format!("{key} = \"{value}\""),
    })
}

/// What the comments of such a file say of the record behind it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Intervals {
    /// Intervals of identified coefficients, in ″ and s.
    pub known: Vec<(Term, [f64; 2])>,
    /// Symbols of the coefficients that were not identified.
    pub unknown: Vec<&'static str>,
}

/// The noise of a noise.toml at rest, with that of its readout and of its switches.
pub(crate) fn parts_of(noise: &Noise) -> Vec<Part> {
    let mut parts = noise.process(1.0, 1 << 20).parts;
    let lsb = noise.readout_lsb / libm::sqrt(12.0);
    parts.extend((lsb > 0.0).then(|| Part::quantization(lsb)));
    let residual = noise.switching.map_or(0.0, |switching| switching.residual_density());
    parts.extend((residual > 0.0).then(|| Part::angle_random_walk(libm::sqrt(residual))));
    parts
}

/// The intervals in the comments of a noise.toml; none where others wrote it.
pub(crate) fn intervals_of(text: &str) -> Intervals {
    let term = |symbol: &str| Term::EVERY.into_iter().find(|term| term.symbol() == symbol);
    let known = |line: &str| {
        let (symbol, ends) = line.strip_prefix(INTERVAL)?.split_once(": ")?;
        let (low, rest) = ends.split_once(" to ")?;
        let (high, _) = rest.split_once(' ')?;
        let term = term(symbol)?;
        let (factor, _, _) = term.row().unit;
        Some((term, [low.parse::<f64>().ok()? / factor, high.parse::<f64>().ok()? / factor]))
    };
    let unknown = text.lines().filter_map(|line| line.strip_prefix(UNKNOWN)).flat_map(|all| all.split("; "));
    let symbol = |one: &str| Some(term(one.split(' ').next()?.trim_end_matches('.'))?.symbol());
    Intervals {
        known: text.lines().filter_map(known).collect(),
        unknown: unknown.filter_map(symbol).collect(),
    }
}
