//! The report of a spectrum: answer, tables, charts and notes.

use crate::analysis::data_sheet::Row;
use crate::analysis::log::figures::per_unit;
use crate::analysis::log::report::{Record, heading, key, text};
use crate::analysis::log::{self, Column, events, figures};
use crate::analysis::requirement::{Decision, Limit, Subject, decide};
use crate::analysis::spectrum::{Analysis, Spectrum, White};
use sagnac_base::quantity::number::{joined, significant};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::{self, Deviation, Unit as Curves};
use sagnac_records::fit::Fit;
use sagnac_records::record::log::Field;
use sagnac_records::spectrum::{Line, Point};
use sagnac_report::answer::{self, Fact, Reading};
use sagnac_report::chart::figure::{self, Axis, Figure, Law, LawLine, Parts, Series, SeriesPoint};
use sagnac_theory::allan::{Part, Term, density};

/// Most events that are named; the page has all.
const MAX_EVENTS: usize = 3;

/// How well a fit describes its curve.
pub(crate) fn of_fit(fit: &Fit) -> Fact {
    Fact::Fit {
        tau_s: fit.tau_range,
        chi_squared: fit.chi_squared,
        degrees_of_freedom: fit.degrees_of_freedom,
        p: fit.p_value(),
    }
}

impl Analysis {
    /// The answer of the log: its coefficients, the minima of its curves, and N of its densities where there are some.
    pub fn decision(&self, limits: &[Limit]) -> Decision {
        let floor = |place: usize| self.spectra.get(place)?.white.from_floor.as_ref();
        let columns = self.noise.columns.iter().enumerate();
        let subjects: Vec<Subject> =
            columns.map(|(place, column)| Subject::of_column(&self.noise, column, floor(place))).collect();
        let mut decision = decide(&subjects, limits, "column");
        let facts = &mut decision.answer.facts;
        if let [column] = &self.noise.columns[..] {
            let fit = column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described());
            facts.extend(fit.map(of_fit));
        }
        facts.extend(self.highest_line());
        facts.extend(self.events());
        facts.extend(sources(&self.noise.columns));
        decision
    }

    /// The line that is the highest above its floor.
    fn highest_line(&self) -> Option<Fact> {
        let lines = |(column, spectrum): (&'_ Column, &'_ Spectrum)| {
            let unit = column.unit.symbol(Deviation::Oadev);
            spectrum.lines.iter().map(|line| (column.name.clone(), unit, line.clone())).collect::<Vec<_>>()
        };
        let all: Vec<_> = self.columns().flat_map(lines).collect();
        let (name, unit, line) = all.iter().max_by(|a, b| a.2.over_floor.total_cmp(&b.2.over_floor))?;
        let of = if self.noise.columns.len() > 1 { format!(" in {name}") } else { String::new() };
        let more = if all.len() > 1 { format!("; {} lines", all.len()) } else { String::new() };
        let (frequency, over) = (significant(line.frequency_hz, 4), significant(line.over_floor, 3));
        Some(Fact::Value {
            name: "Spectral line".to_owned(),
            value: Reading::in_unit("amplitude", line.amplitude, unit, None),
            at: format!("at {frequency} Hz{of}, {over} × floor{more}"),
        })
    }

    /// What the record shows besides noise.
    fn events(&self) -> Option<Fact> {
        let mut names: Vec<String> = Vec::new();
        for row in events::rows(&self.noise) {
            let name = row.brief(self.noise.columns.len() > 1);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let more = names.len().saturating_sub(MAX_EVENTS);
        names.truncate(MAX_EVENTS);
        let more = if more > 0 { format!("; {more} more") } else { String::new() };
        (!names.is_empty()).then(|| Fact::Caveat { text: names.join("; ") + &more })
    }
}

/// The messages from which columns were read, those of each topic as one fact.
fn sources(columns: &[Column]) -> Vec<Fact> {
    let mut sources: Vec<Fact> = Vec::new();
    for column in columns {
        let Some((Field { topic, kind, name }, unit)) = &column.field else { continue };
        let (column, name, unit) = (column.name.clone(), name.clone(), unit.clone());
        let field = answer::Field { column, name, unit };
        let known = sources.iter_mut().find_map(|fact| match fact {
            Fact::Source { topic: other, fields, .. } if other == topic => Some(fields),
            _ => None,
        });
        match known {
            Some(fields) => fields.push(field),
            None => {
                let (topic, kind) = (topic.clone(), kind.clone());
                sources.push(Fact::Source { topic, kind, fields: vec![field] });
            }
        }
    }
    sources
}

/// Unit of densities in files.
fn in_files(unit: Curves) -> &'static str {
    match unit {
        Curves::Angular => "deg2/h2/Hz",
        Curves::Acceleration => "ug2/Hz",
        Curves::Plain => "",
    }
}

/// A row of `psd.csv`.
pub(crate) struct DensityRow<'a> {
    column: &'a log::Column,
    spectrum: &'a Spectrum,
    point: &'a Point,
    treatment: &'a str,
}

/// The columns of `psd.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn density_columns<'a>() -> Vec<ColumnOf<DensityRow<'a>>> {
    type Of<'a> = ColumnOf<DensityRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("f", Unit::HZ, "frequency", |row| Cell::Number(row.point.frequency_hz))
            .is(Role::Coordinate, "Frequency, Hz."),
        Of::new("density", Unit::NONE, "density", |row| Cell::Number(row.point.value))
            .is(Role::Error, "One-sided power spectral density of the rate or acceleration, in `unit`."),
        Of::new("lower", Unit::NONE, "lower", |row| row.point.interval.map(|ends| ends.0).into())
            .is_of("density", Role::Lower, "Lower end of the interval of `density`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.point.interval.map(|ends| ends.1).into())
            .is_of("density", Role::Upper, "Upper end of the interval of `density`."),
        Of::new("model", Unit::NONE, "model", |row| row.spectrum.model_at(row.point.frequency_hz).into())
            .is_of("density", Role::Theory, "Density of the noise model that was fitted to the Allan curve, in `unit`; blank without a fit and above its frequencies."),
        Of::new("unit", Unit::NONE, "unit", |row| text(in_files(row.column.unit)))
            .is(Role::Note, "Unit of `density`, `lower`, `upper` and `model`."),
        Of::new("treatment", Unit::NONE, "treatment", |row| text(row.treatment))
            .is(Role::Note, "What was done to the record: skipped, cut, a line removed, outliers removed."),
    ]
}

/// The densities of all columns: `psd.csv`.
pub fn table(analysis: &Analysis) -> Table {
    let treatment = &analysis.noise.treatment.summary();
    let rows: Vec<DensityRow> = analysis
        .columns()
        .flat_map(|(column, spectrum)| {
            spectrum.density.points.iter().map(move |point| DensityRow { column, spectrum, point, treatment })
        })
        .collect();
    Table { columns: columns_of(&density_columns(), &rows) }
}

/// A row of `lines.csv`.
pub(crate) struct LineRow<'a> {
    column: &'a log::Column,
    line: &'a Line,
}

/// The columns of `lines.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn line_columns<'a>() -> Vec<ColumnOf<LineRow<'a>>> {
    type Of<'a> = ColumnOf<LineRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("f", Unit::HZ, "frequency", |row| Cell::Number(row.line.frequency_hz))
            .is(Role::Coordinate, "Frequency of the line, interpolated, Hz."),
        Of::new("amplitude", Unit::NONE, "amplitude", |row| Cell::Number(row.line.amplitude))
            .is(Role::Estimate, "Amplitude of the sine of the rate or acceleration, in `unit`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `amplitude`."),
        Of::new("over_floor", Unit::NONE, "over floor", |row| Cell::Number(row.line.over_floor))
            .is(Role::Estimate, "Highest density of the line over that of the noise around it."),
        Of::new("p", Unit::NONE, "p", |row| Cell::Number(row.line.p))
            .is(Role::Estimate, "Probability that noise alone has such a density anywhere in the record; a line has at most 0.01."),
    ]
}

/// The lines of all columns: `lines.csv`.
pub fn lines(analysis: &Analysis) -> Table {
    let lines = analysis
        .columns()
        .flat_map(|(column, spectrum)| spectrum.lines.iter().map(move |line| LineRow { column, line }));
    let rows: Vec<LineRow> = lines.collect();
    Table { columns: columns_of(&line_columns(), &rows) }
}

/// A row of `white_noise.csv`.
pub(crate) struct WhiteRow<'a> {
    column: &'a log::Column,
    white: &'a White,
    from: &'static str,
    row: &'a Row,
}

/// The columns of `white_noise.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn white_columns<'a>() -> Vec<ColumnOf<WhiteRow<'a>>> {
    type Of<'a> = ColumnOf<WhiteRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("from", Unit::NONE, "from", |row| text(row.from))
            .is(Role::Key, "`floor` for N from the flat range of the density, `fit` for N from the Allan curve."),
        Of::new("n", Unit::NONE, "N", |row| row.row.value.into())
            .is(Role::Estimate, "Angle or velocity random walk N, in `unit`; blank where the fit does not identify it."),
        Of::new("lower", Unit::NONE, "lower", |row| row.row.interval.map(|ends| ends[0]).into())
            .is_of("n", Role::Lower, "Lower end of the interval of `n`."),
        Of::new("upper", Unit::NONE, "upper", |row| row.row.interval.map(|ends| ends[1]).into())
            .is_of("n", Role::Upper, "Upper end of the interval of `n`; if `n` is blank, an upper bound."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.row.unit))
            .is(Role::Note, "Unit of `n`, `lower` and `upper`."),
        Of::new("from_f", Unit::HZ, "from", |row| range(row.white).map(|ends| ends[0]).into())
            .is(Role::Estimate, "Lowest frequency of the flat range, Hz."),
        Of::new("to_f", Unit::HZ, "to", |row| range(row.white).map(|ends| ends[1]).into())
            .is(Role::Estimate, "Highest frequency of the flat range, Hz."),
        Of::new("others", Unit::NONE, "others", |row| row.white.model.map(|[_, others]| others).into())
            .is(Role::Estimate, "Part of the fitted density over the flat range that is of other terms than N."),
        Of::new("status", Unit::NONE, "status", |row| text(row.white.verdict()))
            .is(Role::Note, "Whether the floor is told apart from the fitted density over the flat range, as far as the fit reaches, all \
                terms included."),
        Of::new("n_verdict", Unit::NONE, "n_verdict", |row| text(row.row.verdict))
            .is(Role::Note, "Whether the fit identifies N, in words; blank for the floor."),
    ]
}

/// Ends of the flat range, Hz.
fn range(white: &White) -> Option<[f64; 2]> {
    white.floor.as_ref().map(|floor| floor.range_hz)
}

/// N of all columns from floor and fit: `white_noise.csv`.
pub fn white_noise(analysis: &Analysis) -> Table {
    let rows = analysis.columns().flat_map(|(column, Spectrum { white, .. })| {
        let found = [("floor", &white.from_floor), ("fit", &white.from_fit)];
        found
            .into_iter()
            .filter_map(move |(from, row)| Some(WhiteRow { column, white, from, row: row.as_ref()? }))
    });
    let rows: Vec<WhiteRow> = rows.collect();
    Table { columns: columns_of(&white_columns(), &rows) }
}

/// The records with their fits and spectra: `records.csv`.
pub fn records(analysis: &Analysis) -> Table {
    let Analysis { noise, spectra } = analysis;
    let columns = noise.columns.iter().enumerate();
    log::report::records(columns.map(|(place, column)| Record {
        density: spectra.get(place).map(|spectrum| &spectrum.density),
        ..Record::new(noise, column, &column.name)
    }))
}

/// Points per octave.
const PER_OCTAVE: f64 = 12.0;

/// The figures with the stems of their file names, one for each unit.
pub fn figures(analysis: &Analysis) -> Vec<(String, Figure)> {
    per_unit(&analysis.noise, "psd", |unit| figure(analysis, unit))
}

/// The densities of the columns of a unit with the fitted models over them; `None` without columns.
fn figure(analysis: &Analysis, unit: allan::Unit) -> Option<Figure> {
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
        colours: figures::of_columns(names),
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
    log::report::of_columns(&analysis.noise)
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
pub fn symbol(unit: allan::Unit) -> &'static str {
    match unit {
        allan::Unit::Angular => "(°/h)²/Hz",
        allan::Unit::Acceleration => "µg²/Hz",
        allan::Unit::Plain => "",
    }
}
