//! Notes and phrases on the spectra of a log.

use crate::analysis::log::{self, Column};
use crate::analysis::spectrum::{Analysis, Spectrum};
use sagnac_base::quantity::number::significant;
use sagnac_records::allan::Unit;
use sagnac_theory::allan::Term;

/// Part of the samples that may be unused without a note.
const FEW: f64 = 0.05;
/// Number of segments below which a note says that intervals are wide.
const SEVERAL: usize = 4;

/// All notes on the log and its results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    analysis.noise.reading.iter().cloned().chain(of_columns(analysis)).collect()
}

/// The notes on the fits and the spectra.
pub(crate) fn of_columns(analysis: &Analysis) -> Vec<String> {
    let of_column = |(column, spectrum): (&Column, &Spectrum)| {
        let notes = of_spectrum(column, spectrum, &analysis.noise).into_iter().flatten();
        notes.map(|note| format!("{}: {note}", column.name)).collect::<Vec<_>>()
    };
    log::notes::of_columns(&analysis.noise)
        .into_iter()
        .chain(analysis.columns().flat_map(of_column))
        .collect()
}

fn of_spectrum(column: &Column, spectrum: &Spectrum, noise: &log::Analysis) -> [Option<String>; 5] {
    let (density, samples) = (&spectrum.density, noise.samples);
    let keeps_outliers = !column.outliers.samples.is_empty() && !noise.treatment.outliers_removed;
    let has = |term: Term| {
        spectrum.model.as_ref().is_some_and(|model| model.process.parts.iter().any(|part| part.term == term))
    };
    let unused = density.unused as f64 > FEW * samples as f64;
    [
        (column.spread.most() > 0.0)
            .then(|| "intervals of the density, its lines and its floor are those of steady Gaussian noise".to_owned()),
        unused.then(|| {
            format!(
                "{} of {samples} samples are in no segment of the density: a shorter segment takes more of the stretches \
                 between gaps",
                density.unused
            )
        }),
        (density.segments < SEVERAL).then(|| {
            format!("the density is from {} segments only: a shorter segment has narrower intervals", density.segments)
        }),
        has(Term::Sine).then(|| "the sine of the fit is a line, and not part of the density of the model".to_owned()),
        (spectrum.white.is_told_apart() == Some(true)).then(|| {
            let why = match keeps_outliers {
                true => "outliers, which were kept, weigh differently in the two",
                false => "the fit does not describe the noise at these frequencies",
            };
            format!("the floor of the density and the fit differ significantly: {why}")
        }),
    ]
}

/// How the densities were estimated, in a few words.
pub fn method(spectrum: &Spectrum) -> String {
    let density = &spectrum.density;
    format!(
        "one-sided, Hann window, {} segments of {} s that overlap by half, {} degrees of freedom",
        density.segments,
        significant(density.segment as f64 * density.step_s, 6),
        significant(density.freedom, 3)
    )
}

/// Unit of densities for the user; plain numbers have none that is known.
pub fn symbol(unit: Unit) -> &'static str {
    match unit {
        Unit::Angular => "(°/h)²/Hz",
        Unit::Acceleration => "µg²/Hz",
        Unit::Plain => "",
    }
}
