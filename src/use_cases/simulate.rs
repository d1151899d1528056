//! Simulated records of a gyro at rest, from the kernels and the random numbers of studies.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::analysis::firmware::{find, swept, value_of};
use sagnac_base::diagnostics::{StudyError, listed};
use sagnac_base::text_file::{MAX_TOML, read_text};
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::kinds::allan::Allan;
use sagnac_engine::kinds::allan::lower::MAX_SAMPLES;
use sagnac_engine::kinds::allan::lower::theory::LoweredCurve;
use sagnac_engine::study::Study;
use sagnac_records::record::write::{Column, Form, Head, write};

/// Fewest samples of a record.
const MIN_SAMPLES: f64 = 16.0;

/// Records that can be made of a point of a study of Allan curves.
#[derive(Debug)]
pub struct Simulation {
    study: Study,
    lowered: LoweredCurve,
    sample_s: f64,
    samples: u64,
}

/// Why nothing can be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The study or the noise is not valid, or cannot be represented in the kernel's fixed point.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The file cannot be read, the study is of another kind or does not have the point that is asked for, a setting is missing or
    /// out of place, or a record is too short or too long.
    #[error("{0}")]
    Request(String),
}

/// The records that are asked for.
#[derive(Debug, Clone, Default)]
pub struct SimulateRequest {
    /// Time from one sample to the next, s, for a noise.
    pub sample_s: Option<f64>,
    /// Length, s, for a noise.
    pub length_s: Option<f64>,
    /// Values of swept keys, each as `key=value`, for a study with sweeps.
    pub at: Vec<String>,
    /// Seed; by default that of the study, or 1 for a noise.
    pub seed: Option<u64>,
}

/// The meaning of the numbers of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Mean rate of each sample, °/h.
    Rate,
    /// Angle of each sample, ″.
    Increment,
    /// Angle from the start of the record to the end of each sample, ″.
    Angle,
}

impl Numbers {
    /// Every meaning, by its name.
    pub const NAMED: [(&str, Numbers); 3] =
        [("rate", Numbers::Rate), ("increment", Numbers::Increment), ("angle", Numbers::Angle)];

    /// The name, with the unit.
    pub fn title(self) -> &'static str {
        match self {
            Numbers::Rate => "rates in °/h",
            Numbers::Increment => "angles of each sample in ″",
            Numbers::Angle => "angles from the start in ″",
        }
    }
}

impl Simulation {
    /// Records of the noise file or of the study at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or the request does not fit it.
    pub fn read(path: &Path, request: &SimulateRequest) -> Result<Simulation, SimulateError> {
        let text = read_text(path, MAX_TOML)
            .map_err(|error| SimulateError::Request(format!("cannot read {}: {error}", path.display())))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Simulation::build(&name, &text, || Study::read(path), request)
    }

    /// Records of the text of a noise file or of a study, which is called `name` in errors.
    ///
    /// # Errors
    /// The text is invalid, or the request does not fit it.
    pub fn parse(name: &str, text: &str, request: &SimulateRequest) -> Result<Simulation, SimulateError> {
        Simulation::build(name, text, || Study::parse(name, text), request)
    }

    fn build(
        name: &str,
        text: &str,
        study: impl FnOnce() -> Result<Study, StudyError>,
        request: &SimulateRequest,
    ) -> Result<Simulation, SimulateError> {
        let refused = |message: &str| Err(SimulateError::Request(message.to_owned()));
        // What is no TOML is refused with its place.
        let is_study = text.parse::<toml::Table>().map_or(true, |table| table.contains_key("kind"));
        if is_study {
            let mut study = study()?;
            if request.sample_s.or(request.length_s).is_some() {
                return refused(
                    "`rate = HZ` and `length = TIME` are for noise files; a study has `record.sample` and `record.length`\nleave them out",
                );
            }
            study.seed = request.seed.unwrap_or(study.seed);
            return Simulation::of_study(&study, &request.at);
        }
        let (Some(sample_s), Some(length_s)) = (request.sample_s, request.length_s) else {
            return refused(
                "a noise file does not say at which rate its records are sampled, and how long they are\ngive `rate = HZ` and `length = TIME`",
            );
        };
        if let Some(at) = request.at.first() {
            return refused(&format!("`at = {at}` selects from a study, but none is given\nleave it out"));
        }
        Simulation::of_noise(name, text, sample_s, length_s, request.seed.unwrap_or(1))
    }

    /// Records of a study of Allan curves: those of its trials, which have the same numbers. A study with sweeps has them at the point
    /// with the values `at`, each given as `key=value`.
    ///
    /// # Errors
    /// The study is of another kind, has no such point or several, or its noise cannot be represented.
    fn of_study(study: &Study, at: &[String]) -> Result<Simulation, SimulateError> {
        let allan = study.asked::<Allan>().ok_or_else(|| {
            SimulateError::Request(format!(
                "`kind = \"{}\"` has no records of a gyro at rest\ngive a study of kind \"allan\", or a noise file",
                study.kind().name
            ))
        })?;
        let mut chosen = vec![None; study.sweeps.len()];
        for asked in at {
            let refused = |why: String| SimulateError::Request(format!("`at = {asked}`: {why}"));
            let (place, value) = find(study, asked).map_err(refused)?;
            let sweep = &study.sweeps[place];
            let by_name = sweep.values.iter().find(|own| own.to_string() == value.trim_matches('"'));
            let by_size = || match sweep.values[0].quantity() {
                Some(_) => value_of(sweep, value).and_then(|value| swept(sweep, value)),
                None => {
                    let names: Vec<String> = sweep.values.iter().map(SweepValue::to_string).collect();
                    Err(format!("the values of {} are {}", sweep.key.name, listed(&names)))
                }
            };
            if chosen[place].is_some() {
                return Err(refused(format!("{} has a value already", sweep.key.name)));
            }
            chosen[place] = Some(match by_name {
                Some(own) => own.clone(),
                None => SweepValue::Quantity(by_size().map_err(refused)?),
            });
        }
        let mut points = allan.points.iter().filter(|point| {
            let mut values = point.swept.iter().zip(&chosen);
            values.all(|((_, own), chosen)| chosen.as_ref().is_none_or(|chosen| own == chosen))
        });
        let (Some(point), None) = (points.next(), points.next()) else {
            let open = study.sweeps.iter().zip(&chosen).filter(|(_, chosen)| chosen.is_none());
            let open: Vec<&str> = open.map(|(sweep, _)| sweep.key.name).collect();
            let message =
                format!("the study has several points\nchoose one: `at = KEY=VALUE` for {}", open.join(", "));
            return Err(SimulateError::Request(message));
        };
        let lowered = LoweredCurve::new(point, allan.estimator, study.seed, study.streams)
            .map_err(|refusal| study.refused(&point.swept, &refusal))?;
        let (sample_s, samples) = (point.inputs.sample_s, point.inputs.samples());
        Ok(Simulation { study: study.clone(), lowered, sample_s, samples })
    }

    /// Records of the noise in the text of a noise file, which is called `name`.
    ///
    /// # Errors
    /// The text is no noise, or the record or the noise cannot be represented.
    fn of_noise(
        name: &str,
        text: &str,
        sample_s: f64,
        length_s: f64,
        seed: u64,
    ) -> Result<Simulation, SimulateError> {
        let samples = libm::round(length_s / sample_s);
        if !(MIN_SAMPLES..=MAX_SAMPLES as f64).contains(&samples) {
            let message = format!(
                "`length = {length_s} s` has {samples} samples of {sample_s} s\naccepted: {MIN_SAMPLES} to {MAX_SAMPLES} samples"
            );
            return Err(SimulateError::Request(message));
        }
        let quoted = toml::Value::from(name);
        let study = format!(
            "title = \"Simulated records\"\nkind = \"allan\"\ntrials = 1\nseed = {seed}\n\n[record]\nsample = \"{sample_s} s\"\n\
             length = \"{length_s} s\"\n\n[noise]\nfile = {quoted}\n"
        );
        let files = BTreeMap::from([(name.to_owned(), text.as_bytes().to_vec())]);
        Simulation::of_study(&Study::parse_with("simulated.toml", &study, &files)?, &[])
    }

    /// The study whose trials the records are, with the truth about their noise; one with sweeps has other points too.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Number of samples of a record.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Time from one sample to the next, s.
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// The numbers of the record `number`, sample by sample.
    pub fn numbers(&self, number: u64, numbers: Numbers) -> impl Iterator<Item = f64> {
        let mut sum = 0.0;
        self.lowered.records.increments(number).map(move |increment| {
            sum += increment;
            match numbers {
                // 1 ″/s is 1 °/h.
                Numbers::Rate => increment / self.sample_s,
                Numbers::Increment => increment,
                Numbers::Angle => sum,
            }
        })
    }

    /// Whether the form takes such numbers, and so many.
    ///
    /// # Errors
    /// It does not.
    pub fn check(&self, numbers: Numbers, form: Form) -> Result<(), SimulateError> {
        match form.refusal(&self.head(numbers)) {
            Some(refusal) => Err(SimulateError::Request(format!("{refusal}\nchoose another form"))),
            None => Ok(()),
        }
    }

    /// Writes the record `number`; it need not fit into memory.
    ///
    /// # Errors
    /// `to` fails, or the form does not take such numbers, or so many.
    pub fn write(&self, number: u64, numbers: Numbers, form: Form, to: &mut dyn Write) -> io::Result<()> {
        let mut to = BufWriter::new(to);
        write(form, &self.head(numbers), &|_| Box::new(self.numbers(number, numbers)), &mut to)?;
        to.flush()
    }

    fn head(&self, numbers: Numbers) -> Head {
        let (name, unit, rad_per_s) = match numbers {
            Numbers::Rate => ("rate", "deg/h", Some(1_f64.to_radians() / 3600.0)),
            Numbers::Increment => ("increment", "arcsec", None),
            Numbers::Angle => ("angle", "arcsec", None),
        };
        let column = Column { name: name.to_owned(), unit: unit.to_owned(), rad_per_s };
        Head { columns: vec![column], samples: self.samples, step_s: self.sample_s }
    }
}
