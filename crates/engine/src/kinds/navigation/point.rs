//! Points of a study of navigation, each checked as a whole.

use crate::key::document::Places;
use crate::key::sweep::{self, Sweep, Swept, selected};
use crate::kinds::allan::lower::MAX_SAMPLES;
use crate::kinds::navigation::keys::{FILTER, SETTINGS, Solution};
use crate::kinds::navigation::parts::Lack;
use crate::noise::{FILE, Noise, SETTINGS as NOISE_SETTINGS};
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::Fault;
use sagnac_theory::allan::terms::Term;
use sagnac_theory::navigation::equations::{ARCSEC, EARTH_RATE, Leg};
use sagnac_theory::navigation::filter::{Model, filtered};
use sagnac_theory::navigation::weights::{Gyro, MAX_SAMPLE, Task, Times, Weights, weights};

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
    pub swept: Vec<(&'static str, Swept)>,
    /// Inputs of the point.
    pub inputs: Inputs,
    /// The part of the noise that it lacks, in an error budget.
    pub lack: Option<Lack>,
}

/// The inputs common to all points, with their places in the text.
pub(crate) struct Base<'a> {
    pub(crate) inputs: Inputs,
    /// The noise of each file of a sweep over files, combined with the keys of the study.
    pub(crate) files: Vec<Noise>,
    /// The noise model of each file of a sweep over filters.
    pub(crate) filters: Vec<Model>,
    pub(crate) places: &'a Places,
    pub(crate) sweeps: &'a [Sweep],
}

impl Base<'_> {
    /// The noise of the study, or that of each file of a sweep over files.
    pub(crate) fn noises(&self) -> &[Noise] {
        if self.files.is_empty() { std::slice::from_ref(&self.inputs.noise) } else { &self.files }
    }

    /// Refuses sweeps over absent parts of the noise.
    ///
    /// # Errors
    /// The first such sweep.
    pub(crate) fn check_sweeps(&self) -> Result<(), Fault> {
        for sweep in self.sweeps {
            for noise in self.noises() {
                sweep::check_applies(sweep, noise, &NOISE_SETTINGS, "[noise]")?;
            }
        }
        Ok(())
    }

    /// All points, in order.
    ///
    /// # Errors
    /// The first point that is invalid.
    pub(crate) fn points(&self) -> Result<Vec<Point>, Fault> {
        sweep::points(self.sweeps).map(|swept| self.point(swept)).collect()
    }

    fn point(&self, swept: Vec<(&'static str, Swept)>) -> Result<Point, Fault> {
        let mut inputs = self.inputs.clone();
        if let Some(noise) = selected(&self.files, &FILE, self.sweeps, &swept) {
            inputs.noise = noise.clone();
        }
        if let Some(model) = selected(&self.filters, &FILTER, self.sweeps, &swept) {
            inputs.filter = Some(model.clone());
        }
        sweep::set(&mut inputs, &SETTINGS, &swept);
        sweep::set(&mut inputs.noise, &NOISE_SETTINGS, &swept);
        self.check(&inputs)?;
        Ok(Point { swept, inputs, lack: None })
    }

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
