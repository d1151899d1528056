//! The noise of each of three units that ran together: the three-cornered hat of their records.
//!
//! What the units measure in common, such as the motion of their table, cancels in their differences; see
//! [`sagnac_records::allan::hat`].

use std::path::{Path, PathBuf};

use crate::analysis::batch::labels;
use crate::analysis::log::Treatment;
use crate::analysis::log::report::text;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_records::allan::hat::{Hat, UnitVariance, hat};
use sagnac_records::allan::{Deviation, Taus, Unit as Curves};
use sagnac_records::record::log::Log;
use sagnac_report::answer::reading::number;
use sagnac_report::answer::{Answer, AnswerCell, AnswerTable, Fact, Kind, Reading};
use sagnac_report::chart::figure::{Axis, Figure, Grouping, Mark, Series, SeriesPoint, Shape};

/// Relative difference of sampling steps that the clock of one logger has.
const SAME_STEP: f64 = 1e-6;
/// Averaging times near which the answer gives the deviations, s; at the first, the N of a unit shows.
const SHOWN_S: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];
/// Probability of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Why some logs have no three-cornered hat.
#[derive(Debug, thiserror::Error)]
pub enum HatError {
    /// There are more or fewer than three units.
    #[error(
        "a three-cornered hat needs three units that ran together, found {0}\ngive three logs, or three columns of a log, as in \
         `column = g1,g2,g3`"
    )]
    Count(usize),
    /// The units have different quantities.
    #[error("{first} has {}, {other} has {}: they have no common noise\nselect columns of one kind with `column = NAME`", units[0].content(), units[1].content())]
    Units {
        /// Label of the first unit.
        first: String,
        /// Label of a unit that differs.
        other: String,
        /// Units of their curves.
        units: [Curves; 2],
    },
    /// The samples of the units are not the same times.
    #[error(
        "{first} has {} samples of {} s, {other} {} of {} s: they were not sampled together\ngive records of the same time and rate, \
         cut by `skip = TIME` and `until = TIME`",
        samples[0], significant(steps[0], 9), samples[1], significant(steps[1], 9)
    )]
    Sampling {
        /// Label of the first unit.
        first: String,
        /// Label of a unit that differs.
        other: String,
        /// Numbers of their samples.
        samples: [usize; 2],
        /// Times from sample to sample, s.
        steps: [f64; 2],
    },
    /// The records are too short.
    #[error("the records have {0} samples, too few for an averaging time\ngive longer records")]
    Short(usize),
}

/// The noise of three units.
#[derive(Debug)]
pub struct Analysis {
    /// Labels of the units.
    pub labels: [String; 3],
    /// The log of each unit.
    pub paths: [PathBuf; 3],
    /// Unit of the curves.
    pub unit: Curves,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Number of samples, or of differences of angles.
    pub samples: usize,
    /// Treatment of the logs.
    pub treatment: Treatment,
    /// What was inferred about the files.
    pub reading: Vec<String>,
    /// The variances by rising τ.
    pub hats: Vec<Hat>,
}

/// The increments of a unit, in ″ or µg·s.
struct Record<'a> {
    path: &'a Path,
    name: &'a str,
    unit: Curves,
    step_s: f64,
    increments: Vec<f64>,
}

impl Analysis {
    /// The noise of the units that are the columns of these logs, which were read from these paths with this treatment.
    ///
    /// # Errors
    /// There are not three units, or they were not sampled together.
    pub fn of(logs: &[(&Path, &Log)], treatment: &Treatment) -> Result<Analysis, HatError> {
        let treated: Vec<Log> = logs.iter().map(|(_, log)| treatment.applied((*log).clone())).collect();
        let units = logs.iter().zip(&treated).flat_map(|((path, _), log)| {
            log.channels.iter().map(|channel| {
                let samples = channel.view(log.data, log.step_s);
                let scale = samples.scale();
                let increments = samples.increments().iter().map(|x| scale * x).collect();
                let (name, unit, step_s) = (&*channel.name, channel.unit.curves, log.step_s);
                Record { path, name, unit, step_s, increments }
            })
        });
        let units: Vec<Record> = units.collect();
        let count = units.len();
        let records: [Record; 3] = units.try_into().map_err(|_| HatError::Count(count))?;
        let named = records.each_ref().map(|one| (one.path, one.name));
        let found: Option<[String; 3]> = labels(&named, logs.len()).and_then(|all| all.try_into().ok());
        let labels = found.unwrap_or_else(|| [1, 2, 3].map(|place| format!("unit {place}")));
        check(&records, &labels)?;
        let [first, ..] = &records;
        let (unit, step_s, samples) = (first.unit, first.step_s, first.increments.len());
        let factors = Taus::Octave.factors(samples + 1, step_s, Deviation::Oadev).unwrap_or_default();
        let increments = records.each_ref().map(|one| one.increments.as_slice());
        let hats = hat(increments, 1.0, step_s, &factors, CONFIDENCE).unwrap_or_default();
        if hats.is_empty() {
            return Err(HatError::Short(samples));
        }
        let reading = logs
            .iter()
            .flat_map(|(path, log)| log.notes.iter().map(move |note| format!("{}: {note}", path.display())));
        let paths = records.each_ref().map(|one| one.path.to_owned());
        Ok(Analysis {
            labels,
            paths,
            unit,
            step_s,
            samples,
            treatment: *treatment,
            reading: reading.collect(),
            hats,
        })
    }

    /// The number of samples, their spacing, and the labels.
    pub fn heading(&self) -> String {
        let (step, samples) = (significant(self.step_s, 9), self.samples);
        format!("{} together: {samples} samples of {step} s", self.labels.join(", "))
    }

    /// What was inferred about the files, and what is supposed.
    pub(crate) fn notes(&self) -> Vec<String> {
        let supposed = "the first samples of all records are taken as those of one time".to_owned();
        self.reading.iter().cloned().chain([supposed]).collect()
    }

    /// The averaging times that the answer shows, each once.
    fn shown(&self) -> Vec<&Hat> {
        let mut shown: Vec<&Hat> = vec![];
        for at_s in SHOWN_S {
            let distance = |hat: &&Hat| libm::fabs(libm::log(hat.tau_s / at_s));
            let nearest = self.hats.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            shown.extend(nearest.filter(|hat| shown.iter().all(|other| other.m != hat.m)));
        }
        shown
    }

    /// The deviation of a unit with its interval; `None` where its variance is negative.
    fn reading(&self, unit: &UnitVariance) -> Option<Reading> {
        let ends = unit.deviation_interval().map(<[f64; 2]>::from);
        Some(Reading::in_unit("deviation", unit.deviation()?, self.symbol(), ends))
    }

    fn symbol(&self) -> &'static str {
        self.unit.symbol(Deviation::Oadev)
    }

    /// The deviations of all units near 1 s, those at longer times, and what speaks against independent noise.
    pub fn answer(&self) -> Answer {
        let shown = self.shown();
        let Some(first) = shown.first() else { return Answer::default() };
        let at = |hat: &Hat| format!("σ({} s)", significant(hat.tau_s, 4));
        let value = |unit: &UnitVariance| unit.deviation().map_or_else(|| "–".to_owned(), number);
        let each =
            self.labels.iter().zip(&first.units).map(|(label, unit)| format!("{label} {}", value(unit)));
        let headline = format!("{}: {} {}", at(first), each.collect::<Vec<_>>().join(", "), self.symbol());
        let row = |(place, label): (usize, &String)| -> Vec<AnswerCell> {
            let cells = shown.iter().map(|hat| self.cell(&hat.units[place]));
            std::iter::once(label.as_str().into()).chain(cells).collect()
        };
        let heads = std::iter::once("unit".to_owned()).chain(shown.iter().map(|hat| at(hat) + " (95 %)"));
        let facts = self.labels.iter().enumerate().flat_map(|(place, label)| self.caveats(place, label));
        Answer {
            kind: Kind::Estimate,
            headline,
            table: AnswerTable::new(heads, self.labels.iter().enumerate().map(row)),
            facts: facts.collect(),
            ..Answer::default()
        }
    }

    fn cell(&self, unit: &UnitVariance) -> AnswerCell {
        match self.reading(unit) {
            Some(reading) => AnswerCell {
                text: reading.text() + &reading.in_brackets(),
                value: Some(reading),
                ..AnswerCell::default()
            },
            None => match unit.deviation_interval() {
                Some((_, upper)) => format!("≤ {} {}", number(upper), self.symbol()).into(),
                None => "negative".into(),
            },
        }
    }

    /// The averaging times at which the variance of a unit is negative, and those at which even its interval is.
    fn caveats(&self, place: usize, label: &str) -> Vec<Fact> {
        let of = self.hats.len();
        let negative = self.hats.iter().filter(|hat| hat.units[place].variance < 0.0).count();
        let below = |hat: &&Hat| hat.units[place].interval.is_some_and(|(_, upper)| upper < 0.0);
        let below: Vec<String> =
            self.hats.iter().filter(below).map(|hat| format!("{} s", significant(hat.tau_s, 4))).collect();
        let is_dependent = (!below.is_empty()).then(|| {
            Fact::caveat(format!(
                "{label}: negative at τ = {}: the noises are not independent",
                below.join(", ")
            ))
        });
        let is_negative = (negative > 0 && below.is_empty()).then(|| {
            Fact::caveat(format!(
                "{label}: the variance is negative at {negative} of {of} τ, within its interval"
            ))
        });
        is_dependent.into_iter().chain(is_negative).collect()
    }

    /// The variances as a table, `hat.csv`.
    pub fn table(&self) -> Table {
        let rows: Vec<Row> = (0..3)
            .flat_map(|place| {
                self.hats.iter().map(move |hat| Row {
                    label: &self.labels[place],
                    hat,
                    found: hat.units[place],
                    unit: self.unit.in_files(Deviation::Oadev),
                })
            })
            .collect();
        Table { columns: columns_of(&columns(), &rows) }
    }

    /// The chart of the deviations of all units. Where a variance is negative, a mark at the upper end of its interval stands for it.
    pub fn figure(&self) -> Figure {
        let series = |place: usize| {
            let points = self.hats.iter().filter_map(|hat| {
                let unit = hat.units[place];
                Some(SeriesPoint {
                    band: unit.deviation_interval(),
                    ..SeriesPoint::new(hat.tau_s, unit.deviation()?)
                })
            });
            Series { colour: place, dash: 0, points: points.collect(), law: vec![] }
        };
        let marks = (0..3).flat_map(|place| {
            self.hats.iter().filter_map(move |hat| {
                let (_, upper) =
                    hat.units[place].deviation_interval().filter(|_| hat.units[place].variance < 0.0)?;
                let label = format!("{} negative", self.labels[place]);
                Some(Mark { shape: Shape::Crossing, place: (hat.tau_s, upper), range: None, label })
            })
        });
        Figure {
            title: format!("Allan deviation of each of {}", self.labels.join(", ")),
            subtitle: Some(self.heading()),
            x: Axis::new("averaging time τ", "s"),
            y: Axis::new("deviation σ(τ)", self.symbol()),
            colours: Grouping::new("units", self.labels.clone()),
            bands: "95 % intervals".to_owned(),
            series: (0..3).map(series).collect(),
            marks: marks.collect(),
            slopes: true,
            ..Figure::default()
        }
    }
}

/// Checks that the records are of one quantity and of the same samples.
fn check(records: &[Record; 3], labels: &[String; 3]) -> Result<(), HatError> {
    let [first, others @ ..] = records;
    for (other, label) in others.iter().zip(&labels[1..]) {
        let (one, other_label) = (labels[0].clone(), label.clone());
        if other.unit != first.unit {
            return Err(HatError::Units { first: one, other: other_label, units: [first.unit, other.unit] });
        }
        let is_same = libm::fabs(other.step_s / first.step_s - 1.0) < SAME_STEP;
        if other.increments.len() != first.increments.len() || !is_same {
            return Err(HatError::Sampling {
                first: one,
                other: other_label,
                samples: [first.increments.len(), other.increments.len()],
                steps: [first.step_s, other.step_s],
            });
        }
    }
    Ok(())
}

/// A row of `hat.csv`.
pub(crate) struct Row<'a> {
    label: &'a str,
    hat: &'a Hat,
    found: UnitVariance,
    unit: &'a str,
}

/// The columns of `hat.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("label", Unit::NONE, "label", |row| text(row.label))
            .is(Role::Key, "Label of the unit of the batch: the name of its file, of its column, or both."),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.hat.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("differences", Unit::NONE, "differences", |row| Cell::Integer(row.hat.terms as i64))
            .is(Role::Count, "Number of differences behind the value."),
        Of::new("deviation", Unit::NONE, "deviation", |row| row.found.deviation().into())
            .is(Role::Error, "Allan deviation of the unit, in `unit`; blank where `variance` is negative."),
        Of::new("lower", Unit::NONE, "lower", |row| row.found.deviation_interval().map(|ends| ends.0).into())
            .is_of("deviation", Role::Lower, "Lower end of the 95 % interval."),
        Of::new("upper", Unit::NONE, "upper", |row| row.found.deviation_interval().map(|ends| ends.1).into())
            .is_of("deviation", Role::Upper, "Upper end of the 95 % interval; a bound where `deviation` is blank."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of `deviation`."),
        Of::new("variance", Unit::NONE, "variance", |row| Cell::Number(row.found.variance))
            .is(Role::Estimate, "Allan variance in the square of `unit`, which may be negative."),
        Of::new("variance_lower", Unit::NONE, "variance_lower", |row| row.found.interval.map(|ends| ends.0).into())
            .is_of("variance", Role::Lower, "Lower end of the 95 % interval of `variance`."),
        Of::new("variance_upper", Unit::NONE, "variance_upper", |row| row.found.interval.map(|ends| ends.1).into())
            .is_of("variance", Role::Upper, "Upper end of the 95 % interval of `variance`; below 0 the noises are not independent."),
    ]
}
