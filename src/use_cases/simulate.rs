//! Simulated records of a gyro at rest, from the kernels and the random numbers of studies.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use crate::analysis::firmware::choice::{find, swept, value_of};
use sagnac_base::diagnostics::{StudyError, listed};
use sagnac_base::quantity::number::significant;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::kinds::allan::Allan;
use sagnac_engine::kinds::allan::lower::MAX_SAMPLES;
use sagnac_engine::kinds::allan::lower::theory::LoweredCurve;
use sagnac_engine::study::Study;

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
    /// The noise is not valid, or cannot be represented in the kernel's fixed point.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The study is of another kind, does not have the point that is asked for, or a record is too short or too long.
    #[error("{0}")]
    Point(String),
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

/// The form of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Times, s, and numbers as text, each with as many digits as tell it apart.
    Csv,
    /// Numbers as an array of NumPy.
    Npy,
    /// Numbers of 8 bytes, little-endian, without a header.
    Raw,
}

impl Form {
    /// The ending of a file's name.
    pub fn ending(self) -> &'static str {
        match self {
            Form::Csv => "csv",
            Form::Npy => "npy",
            Form::Raw => "raw",
        }
    }
}

impl Simulation {
    /// Records of a study of Allan curves: those of its trials, which have the same numbers. A study with sweeps has them at the point
    /// with the values `at`, each given as `key=value`.
    ///
    /// # Errors
    /// The study is of another kind, has no such point or several, or its noise cannot be represented.
    pub fn of_study(study: &Study, at: &[String]) -> Result<Simulation, SimulateError> {
        let allan = study.asked::<Allan>().ok_or_else(|| {
            SimulateError::Point(format!(
                "`kind = \"{}\"` has no records of a gyro at rest\ngive a study of kind \"allan\", or a noise file",
                study.kind().name
            ))
        })?;
        let mut chosen = vec![None; study.sweeps.len()];
        for asked in at {
            let refused = |why: String| SimulateError::Point(format!("`at = {asked}`: {why}"));
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
            return Err(SimulateError::Point(message));
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
    pub fn of_noise(
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
            return Err(SimulateError::Point(message));
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

    /// Hands out the numbers of the record `number`, sample by sample.
    pub fn each(&self, number: u64, numbers: Numbers, mut each: impl FnMut(f64)) {
        let mut sum = 0.0;
        self.lowered.records.increments(number, |increment| {
            sum += increment;
            each(match numbers {
                // 1 ″/s is 1 °/h.
                Numbers::Rate => increment / self.sample_s,
                Numbers::Increment => increment,
                Numbers::Angle => sum,
            });
        });
    }

    /// Writes the record `number`; it need not fit into memory.
    ///
    /// # Errors
    /// `to` fails.
    pub fn write(&self, number: u64, numbers: Numbers, form: Form, to: &mut dyn Write) -> io::Result<()> {
        let mut to = BufWriter::new(to);
        match form {
            Form::Csv => {
                let column = match numbers {
                    Numbers::Rate => "rate [deg/h]",
                    Numbers::Increment => "increment [arcsec]",
                    Numbers::Angle => "angle [arcsec]",
                };
                writeln!(to, "time [s],{column}")?;
            }
            Form::Npy => to.write_all(&npy_header(self.samples))?,
            Form::Raw => {}
        }
        let (mut sample, mut written) = (0_u64, Ok(()));
        self.each(number, numbers, |value| {
            sample += 1;
            if written.is_ok() {
                // A sample has the time of its end.
                let time = || significant(sample as f64 * self.sample_s, 15);
                written = match form {
                    Form::Csv => writeln!(to, "{},{value}", time()),
                    Form::Npy | Form::Raw => to.write_all(&value.to_le_bytes()),
                };
            }
        });
        written.and_then(|()| to.flush())
    }
}

/// The header of a file of NumPy, version 1.0, with so many numbers of 8 bytes.
fn npy_header(count: u64) -> Vec<u8> {
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}");
    // Magic, version, length, text and a line feed fill whole lines of 64 bytes.
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).into_bytes());
    bytes
}
