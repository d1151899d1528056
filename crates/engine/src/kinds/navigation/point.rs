//! Points of a study of navigation, each checked as a whole, with the filter of each.

use std::ops::Range;
use std::sync::Arc;

use miette::NamedSource;
use serde::de::{Deserialize, Deserializer, Error};
use serde_json::value::RawValue;

use crate::key::ParseContext;
use crate::key::document::SpanMap;
use crate::key::sweep::{Sweep, Sweepable, SweepValue, of_name};
use crate::kinds::allan::lower::MAX_SAMPLES;
use crate::kinds::navigation::{FILTER, Lack, SETTINGS, Solution};
use crate::noise::{self, FILE, Noise, NoiseFiles};
use sagnac_base::diagnostics::{Fault, Text, Wrong};
use sagnac_base::quantity::number::significant;
use sagnac_base::text_file::{InputFiles, MAX_TOML};
use sagnac_theory::allan::terms::Term;
use sagnac_theory::navigation::filter::{Model, filtered};
use sagnac_theory::navigation::{ARCSEC, EARTH_RATE, Gyro, Leg, MAX_SAMPLE, Task, Times, Weights, weights};

/// Samples that a record has at least where the study gives no sampling time.
const USUAL_SAMPLES: f64 = 2000.0;
/// Fewest samples of a record.
const MIN_SAMPLES: u64 = 16;
/// Most samples of the alignment of a filter, whose gains are in memory.
const MAX_READINGS: usize = 1 << 22;
/// Largest latitude that a leg may reach, ″: 88°.
const MAX_LATITUDE: f64 = 316_800.0;

/// The inputs of a navigator, in ″, m and s. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// The task.
    pub solution: Solution,
    /// Requested time from the start to the end, s; 0 for gyrocompassing.
    pub duration_s: f64,
    /// Requested time at rest before the start, s; 0 for none.
    pub alignment_s: f64,
    /// Whether the alignment calibrates the other gyros.
    pub calibrates: bool,
    /// Noise model of the filter that keeps the heading; `None` without a filter.
    pub filter: Option<Model>,
    /// Latitude at the start, ″.
    pub latitude_arcsec: f64,
    /// Speed on the leg, m/s.
    pub speed_m_per_s: f64,
    /// Course of the leg from north over east, ″.
    pub course_arcsec: f64,
    /// Sampling time of the study, s; `None` where it is chosen.
    pub sample_s: Option<f64>,
    /// Noise of each gyro.
    pub noise: Noise,
}

impl Inputs {
    /// Time from one sample to the next, s.
    pub fn sample(&self) -> f64 {
        self.sample_s.unwrap_or_else(|| {
            let whole = self.duration_s + self.alignment_s;
            let longest = (whole / USUAL_SAMPLES).min(MAX_SAMPLE);
            // The longest of 1, 2, 5, 10, … that is not above it, so that usual times have whole samples.
            let power = libm::pow(10.0, libm::floor(libm::log10(longest)));
            let steps = [5.0, 2.0, 1.0].into_iter().find(|step| step * power <= longest * (1.0 + 1e-9));
            let round = steps.unwrap_or(1.0) * power;
            match self.noise.switching {
                Some(switching) => {
                    switching.interval_s / libm::ceil(switching.interval_s / round * (1.0 - 1e-9))
                }
                None => round,
            }
        })
    }

    /// The times in samples.
    pub fn times(&self) -> Times {
        let sample_s = self.sample();
        let samples = |time_s: f64| libm::round(time_s / sample_s) as usize;
        Times {
            sample_s,
            alignment: samples(self.alignment_s),
            duration: samples(self.duration_s),
            calibrates: self.calibrates,
        }
    }

    /// Number of samples of a record.
    pub fn samples(&self) -> u64 {
        let Times { alignment, duration, .. } = self.times();
        (alignment + duration) as u64
    }

    /// The task with its place on the Earth.
    pub fn task(&self) -> Task {
        let latitude = self.latitude_arcsec * ARCSEC;
        match self.solution {
            Solution::Heading => Task::Heading,
            Solution::Gyrocompass => Task::Gyrocompass { earth_rate: EARTH_RATE, latitude },
            Solution::Inertial => {
                let course = self.course_arcsec * ARCSEC;
                // A course of 90° has no velocity to the north.
                let part = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x * self.speed_m_per_s };
                let velocity = [part(libm::cos(course)), part(libm::sin(course))];
                Task::Inertial(Leg { earth_rate: EARTH_RATE, latitude, velocity })
            }
        }
    }

    /// The weights of the gyros in the errors.
    pub(crate) fn weights(&self) -> Vec<Weights> {
        match &self.filter {
            Some(model) => {
                vec![Weights { gyro: Gyro::Down, of_errors: vec![filtered(model, &self.times()).weights] }]
            }
            None => weights(&self.task(), &self.times()),
        }
    }

    /// Standard deviation of the heading as claimed by the filter, ″.
    pub fn claimed(&self) -> Option<f64> {
        self.filter.as_ref().map(|model| libm::sqrt(filtered(model, &self.times()).variance))
    }

    /// The inputs that determine the draws, as lines of text.
    pub(crate) fn canonical(&self) -> String {
        let Times { sample_s, alignment, duration, .. } = self.times();
        format!("sample_s={sample_s:.11e}\nsamples={}\n{}", alignment + duration, self.noise.canonical())
    }
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Inputs of the point.
    pub inputs: Inputs,
    /// The part of the noise that it lacks, in an error budget.
    pub lack: Option<Lack>,
}

/// The inputs common to all points.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    pub(crate) inputs: Inputs,
    /// The noise of each file of a sweep over files, combined with the keys of the study.
    pub(crate) files: NoiseFiles,
    /// The noise model of each file of a sweep over filters.
    pub(crate) filters: Arc<[(String, Model)]>,
}

/// The keys that can be swept.
pub(crate) fn sweepable() -> Sweepable<Base> {
    Sweepable::new()
        .part(&SETTINGS, |base: &mut Base| Some(&mut base.inputs))
        .part(&noise::SETTINGS, |base| Some(&mut base.inputs.noise))
        .name(&FILE, |base: &mut Base, name| {
            base.inputs.noise = of_name(&base.files, name).unwrap_or_default();
        })
        .name(&FILTER, |base: &mut Base, name| base.inputs.filter = of_name(&base.filters, name))
}

impl Base {
    /// All points of some sweeps, in order.
    ///
    /// # Errors
    /// A sweep over an absent part of the noise, or the first point that is invalid.
    pub(crate) fn points(&self, sweeps: &[Sweep], places: &SpanMap) -> Result<Vec<Point>, Fault> {
        noise::check_sweeps(&noise::all(&self.inputs.noise, &self.files), places, sweeps)?;
        let point = |(swept, Base { inputs, .. }): (Vec<_>, Base)| {
            Check { places }.check(&inputs)?;
            Ok(Point { swept, inputs, lack: None })
        };
        sweepable().points(self, sweeps).map(point).collect()
    }
}

/// The checks of a point, with the places of the keys of its study.
struct Check<'a> {
    places: &'a SpanMap,
}

impl Check<'_> {
    /// Checks limits that involve more than one value.
    fn check(&self, inputs: &Inputs) -> Result<(), Fault> {
        self.check_samples(inputs)?;
        self.check_noise(inputs)?;
        if let Task::Inertial(leg) = inputs.task() {
            let end = leg.latitude_at(inputs.duration_s) / ARCSEC;
            if end.abs() > MAX_LATITUDE {
                let degrees = significant(end / 3600.0, 4);
                let message =
                    format!("the leg ends at a latitude of {degrees} deg, near a pole or beyond it");
                let help = "accepted: up to 88 deg; take a shorter leg, or another course";
                let names = ["navigation.speed", "navigation.duration", "navigation.course", "navigation"];
                return self.places.refuse(&names, message, "too far", help);
            }
        }
        Ok(())
    }

    fn check_samples(&self, inputs: &Inputs) -> Result<(), Fault> {
        let Times { sample_s, alignment, .. } = inputs.times();
        let (samples, shown) = (inputs.samples(), significant(sample_s, 6));
        if !(MIN_SAMPLES..=MAX_SAMPLES).contains(&samples) {
            let label = if samples < MIN_SAMPLES { "too short" } else { "too long" };
            let message = format!("a record has {samples} samples of {shown} s");
            let help =
                format!("accepted: {MIN_SAMPLES} to {MAX_SAMPLES}; change navigation.sample or the times");
            let names = ["navigation.sample", "navigation.duration", "navigation.alignment"];
            return self.places.refuse(&names, message, label, help);
        }
        if inputs.alignment_s > 0.0 && alignment == 0 {
            let message = format!("navigation.alignment is less than half a sample of {shown} s");
            let names = ["navigation.alignment", "navigation.sample"];
            return self.places.refuse(
                &names,
                message,
                "too short",
                "give a longer alignment, or a shorter sample",
            );
        }
        if inputs.filter.is_some() && alignment > MAX_READINGS {
            let message = format!("the filter reads {alignment} samples of {shown} s in the alignment");
            let help =
                format!("accepted: up to {MAX_READINGS}; give a shorter alignment, or a longer sample");
            let names = ["navigation.alignment", "navigation.sample"];
            return self.places.refuse(&names, message, "too many", help);
        }
        Ok(())
    }

    fn check_noise(&self, inputs: &Inputs) -> Result<(), Fault> {
        let (sample_s, samples, noise) = (inputs.sample(), inputs.samples(), &inputs.noise);
        let shown = significant(sample_s, 6);
        if noise.readout_lsb > 0.0 {
            let message = "noise.readout_lsb has no closed form in the errors of a navigator, which do not resolve pulses";
            let help = "write quantization = the pulse over √12 instead, which is its rms error";
            let names = ["noise.readout_lsb", "noise.file", "noise"];
            return self.places.refuse(&names, message, "whole pulses", help);
        }
        noise.lock_in.map_or(Ok(()), |lock_in| lock_in.check(self.places))?;
        let [_, sine_hz] = noise.of(Term::Sine);
        if sine_hz * sample_s > 0.5 {
            let (sine, nyquist) = (significant(sine_hz, 6), significant(0.5 / sample_s, 6));
            let message = format!(
                "noise.sine.frequency = {sine} Hz is above the Nyquist frequency of samples of {shown} s"
            );
            let help = format!("accepted: up to {nyquist} Hz, or a shorter navigation.sample");
            let names = ["noise.sine.frequency", "noise.sine", "noise.file", "navigation.sample"];
            return self.places.refuse(&names, message, "too high for the samples", help);
        }
        if let Some(switching) = noise.switching
            && !(1..samples).contains(&switching.interval(sample_s))
        {
            let interval_s = significant(switching.interval_s, 6);
            let message = format!(
                "noise.switching.interval = {interval_s} s is not from one sample of {shown} s to the length of the record, \
                 {} s",
                significant(samples as f64 * sample_s, 6)
            );
            let help = "give an interval within the record, or leave [noise.switching] out";
            let names =
                ["noise.switching.interval", "noise.file", "navigation.sample", "navigation.duration"];
            return self.places.refuse(&names, message, "no switch in the record", help);
        }
        if noise.process(sample_s, samples).parts.is_empty() && noise.switched(sample_s).is_none() {
            let message = "[noise] is empty: the navigator would have no errors";
            let help = "add a coefficient as in angle_random_walk = \"0.00048 deg/sqrt(h)\", or file = \"noise.toml\"";
            return self.places.refuse(&["noise"], message, "no noise", help);
        }
        Ok(())
    }
}

/// Most Markov states of a filter.
const MAX_STATES: usize = 16;

const HELP: &str = "accepted: a document with one gyro, as of `sagnac model noise.toml --from \"1 s\" --to \"10000 s\" --overbound --json`";

/// The parts of the document that a filter needs.
#[derive(serde::Deserialize)]
struct Document {
    #[serde(deserialize_with = "size")]
    white_deg_per_rt_h: f64,
    #[serde(deserialize_with = "size")]
    random_walk_deg_per_h_per_rt_h: f64,
    #[serde(default, alias = "quantisation_arcsec", deserialize_with = "size")]
    quantization_arcsec: f64,
    markov: Vec<State>,
}

#[derive(serde::Deserialize)]
struct State {
    #[serde(deserialize_with = "size")]
    sigma_deg_per_h: f64,
    #[serde(deserialize_with = "time")]
    correlation_time_s: f64,
}

fn within<'de, D: Deserializer<'de>>(from: D, [least, most]: [f64; 2]) -> Result<f64, D::Error> {
    let value = f64::deserialize(from)?;
    match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(Error::custom(format!("{value} is not from {least} to {most}"))),
    }
}

fn size<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    within(from, [0.0, 1e9])
}

fn time<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    within(from, [1e-6, 1e9])
}

/// The model that the study writes.
pub(crate) fn written(reading: &ParseContext) -> Result<Option<Model>, Wrong> {
    reading.get(&FILTER).map(|file| read(file.text(), file.span(), reading.files)).transpose()
}

/// The model of each file of a sweep.
pub(crate) fn swept(reading: &ParseContext) -> Result<Arc<[(String, Model)]>, Wrong> {
    let files = reading.sweep(&FILTER).into_iter().flat_map(Sweep::named_files);
    files.map(|(name, file)| Ok((name, read(file.get_ref(), file.span(), reading.files)?))).collect()
}

/// Reads the file of this name, which is at `span` of the study.
fn read(name: &str, span: Range<usize>, files: &InputFiles) -> Result<Model, Wrong> {
    let path = files.path(name);
    let text = files.text(name, MAX_TOML).map_err(|error| {
        let message = format!("cannot read the model of a filter {}: {error}", path.display());
        let help =
            "give the path of a document of `sagnac model --json`, relative to the folder of the study";
        Fault::new(span, message, "named here", help)
    })?;
    let text: Text = Arc::new(NamedSource::new(path.display().to_string(), text.to_string()));
    parse(text.inner()).map_err(|fault| Wrong::Elsewhere(fault.within(&text)))
}

/// A document of `sagnac model --json`.
#[derive(serde::Deserialize)]
struct Printed<'a> {
    #[serde(borrow)]
    model: Columns<'a>,
}

#[derive(serde::Deserialize)]
struct Columns<'a> {
    #[serde(borrow)]
    columns: Vec<&'a RawValue>,
}

/// The part of a document that has the model: of `model.json` the whole, of what `--json` prints that of its only column.
fn of_column(text: &str) -> &str {
    match serde_json::from_str(text) {
        Ok(Printed { model: Columns { columns } }) if columns.len() == 1 => columns[0].get(),
        _ => text,
    }
}

fn parse(whole: &str) -> Result<Model, Fault> {
    let text = of_column(whole);
    let start = whole.find(text).unwrap_or(0);
    let document: Document = serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let found = message.rsplit_once(" at line").map_or(message.as_str(), |(found, _)| found);
        let message = format!("the model of a filter cannot be read: {found}");
        let at = place(text, error.line(), error.column());
        Fault::new(start + at.start..start + at.end, message, "here", HELP)
    })?;
    if document.markov.len() > MAX_STATES {
        let message = format!("the model of a filter has {} Markov states", document.markov.len());
        return Err(Fault::new(
            0..whole.len(),
            message,
            "in this document",
            format!("accepted: up to {MAX_STATES}"),
        ));
    }
    let state = |state: &State| [state.sigma_deg_per_h, state.correlation_time_s];
    let model = Model {
        // 1 °/√h is 60 ″/√s, and 1 °/h/√h is 1/60 ″/s^1.5.
        white: document.white_deg_per_rt_h * 60.0,
        walk: document.random_walk_deg_per_h_per_rt_h / 60.0,
        markov: document.markov.iter().map(state).collect(),
        quantization: document.quantization_arcsec,
    };
    if model.is_nothing() {
        return Err(Fault::new(
            0..whole.len(),
            "the model of a filter has no noise",
            "in this document",
            HELP,
        ));
    }
    Ok(model)
}

/// The character before a line and a column from 1 on; of the end of the text, the last one.
fn place(text: &str, line: usize, column: usize) -> Range<usize> {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let mut at = (before + column.saturating_sub(1)).min(text.len().saturating_sub(1));
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at..text[at..].chars().next().map_or(at, |c| at + c.len_utf8())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_of_a_document_are_in_arcseconds_and_seconds() {
        let model = parse(
            r#"{"white_deg_per_rt_h": 2.0, "random_walk_deg_per_h_per_rt_h": 3.0, "quantization_arcsec": 0.5,
                "markov": [{"sigma_deg_per_h": 4.0, "correlation_time_s": 7.0}]}"#,
        );
        let model = model.unwrap_or_else(|_| panic!("the document is not read"));
        // Over an hour the angle has 2°, and the rate has walked 3°/h.
        let (hour, degree) = (3600.0, 3600.0);
        assert!((model.white * f64::sqrt(hour) / (2.0 * degree) - 1.0).abs() < 1e-14, "{model:?}");
        assert!((model.walk * f64::sqrt(hour) / (3.0 * degree / hour) - 1.0).abs() < 1e-14, "{model:?}");
        // 4°/h turn 4° in an hour.
        let [sigma, time_s] = model.markov[0];
        assert!((sigma * hour / (4.0 * degree) - 1.0).abs() < 1e-14, "{model:?}");
        assert_eq!((time_s, model.quantization, model.markov.len()), (7.0, 0.5, 1));
    }
}
