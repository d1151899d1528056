//! Rates of simulated records besides their noise: motions about the axes, which misaligned axes share, scale factors, mode switches,
//! and the dependence of the rate on a temperature.
//!
//! All of it is added in whole numbers of 2^−32 of the unit of the noise, before whole pulses are read.

use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, parse};
use sagnac_engine::kinds::lock_in::lower::Gyros;
use sagnac_engine::motion::Motion;
use sagnac_engine::motion::record::{MOTION_BITS, RecordMotion, Samples};

use super::SimulateError;
use super::switched::Switches;

/// Names of the axes of three.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Largest misalignment, rad, and error of a scale factor.
const MAX_ANGLE: f64 = 0.1;
const MAX_ERROR: f64 = 0.1;

/// Bits of the fractions of what an axis senses.
const FRACTION_BITS: u32 = 32;

/// A motion about an axis.
#[derive(Debug, Clone, Default)]
pub struct MotionText {
    /// Axis, counted from 0.
    pub axis: usize,
    /// Path of its file, beside which the files lie that it names.
    pub name: String,
    /// Text of the file.
    pub text: String,
}

/// A deviation of an axis of the gyro from that of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// Axis, counted from 0.
    pub axis: usize,
    /// The other axis of which it senses a part, or itself for the error of its scale factor.
    pub of: usize,
    /// That part: a small angle in rad, or the error.
    pub part: f64,
}

impl Sensitivity {
    /// Reads misalignments such as `xy=10arcsec`: the axis x senses the rate about y times 10″.
    ///
    /// # Errors
    /// It is no small angle between two axes.
    pub fn parse_misalignment(text: &str) -> Result<Sensitivity, String> {
        const ACCEPTED: &str = "accepted: two of x, y, z and an angle, as in xy=10arcsec";
        let (axes, angle) = text.split_once('=').ok_or(ACCEPTED)?;
        let place = |name: &str| AXES.iter().position(|axis| *axis == name);
        let pair = axes.trim().split_at_checked(1).and_then(|(a, b)| place(a).zip(place(b)));
        let (axis, of) = pair.filter(|(axis, of)| axis != of).ok_or(ACCEPTED)?;
        let angle = parse(angle, &[Dimension::Angle]).map_err(|error| error.to_string())?;
        let part = (angle.value / 3600.0).to_radians();
        match part.abs() <= MAX_ANGLE {
            true => Ok(Sensitivity { axis, of, part }),
            false => Err(format!("a misalignment is at most {MAX_ANGLE} rad")),
        }
    }

    /// Reads errors of scale factors such as `x=10ppm` or, of the only axis, `10ppm`.
    ///
    /// # Errors
    /// It is no such error.
    pub fn parse_scale_factor(text: &str) -> Result<Sensitivity, String> {
        const ACCEPTED: &str =
            "accepted: an error in ppm or %, with the axis if there are three, as in x=10ppm";
        let (axis, error) = text.split_once('=').unwrap_or(("", text));
        let axis = match axis.trim() {
            "" => Some(0),
            name => AXES.iter().position(|axis| *axis == name),
        };
        let error = error.trim();
        let units = [("ppm", 1e-6), ("%", 1e-2)];
        let unit = units.into_iter().find_map(|(unit, size)| Some((error.strip_suffix(unit)?, size)));
        let number = unit.and_then(|(number, size)| Some(number.trim().parse::<f64>().ok()? * size));
        let (axis, part) = axis.zip(number).ok_or(ACCEPTED)?;
        match part.abs() <= MAX_ERROR {
            true => Ok(Sensitivity { axis, of: axis, part }),
            false => Err(format!("an error of a scale factor is at most {} %", 100.0 * MAX_ERROR)),
        }
    }
}

/// A temperature that goes from one value to another in a record, and the rate that it causes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warming {
    /// Temperatures at both ends, °C.
    pub ends: [f64; 2],
    /// Rate per kelvin above the first one, ″/s/K.
    pub coefficient: f64,
}

impl Warming {
    /// Reads the temperatures at both ends, as in `20..60`, °C.
    ///
    /// # Errors
    /// They are no two numbers above absolute zero.
    pub fn parse_ends(text: &str) -> Result<[f64; 2], String> {
        let number = |text: &str| {
            let text = text.trim().trim_end_matches("degC").trim_end_matches("°C");
            text.trim().parse::<f64>().ok().filter(|celsius| (-273.15..=10_000.0).contains(celsius))
        };
        let ends = text.split_once("..").and_then(|(from, to)| number(from).zip(number(to)));
        let (from, to) = ends.ok_or("accepted: the temperatures at both ends in °C, as in 20..60")?;
        Ok([from, to])
    }

    /// Reads the rate per kelvin, ″/s/K, as in `0.02 deg/h/K`.
    ///
    /// # Errors
    /// It is no rate per kelvin.
    pub fn parse_coefficient(text: &str) -> Result<f64, String> {
        const ACCEPTED: &str = "accepted: a rate per kelvin, as in \"0.02 deg/h/K\"";
        let units = ["/K", "/degC", "/°C"];
        let rate = units.into_iter().find_map(|unit| text.trim().strip_suffix(unit)).ok_or(ACCEPTED)?;
        let rate = parse(rate, &[Dimension::DriftRate]).map_err(|error| error.to_string())?;
        Ok(rate.value)
    }
}

/// All that is added to the noise of some axes.
#[derive(Debug)]
pub(crate) struct Added {
    /// The motion about each axis, if there is one.
    pub(crate) motions: Vec<Option<RecordMotion>>,
    /// The part of the motion about each axis that each axis of the gyro senses, in 2^−32.
    parts: Vec<Vec<i128>>,
    temperature: Option<([f64; 2], RecordMotion)>,
    /// The mode switches, all axes at the same time.
    pub(crate) switches: Option<Switches>,
    /// The gyros whose beams lock in.
    pub(crate) lock_in: Option<Gyros>,
    samples: Samples,
    /// A description, line by line, without the tones that are drawn.
    pub(crate) truth: String,
}

impl Added {
    /// Adds motions, sensitivities and a temperature to `axes` axes. Each motion has its axis and the end of the sentence that describes it,
    /// which begins with "The base turns by the motion of".
    ///
    /// # Errors
    /// An axis is not there, has two motions, or there is nothing that would have an effect.
    pub(crate) fn new(
        axes: usize,
        motions: Vec<(usize, RecordMotion, String)>,
        sensitivities: &[Sensitivity],
        warming: Option<Warming>,
        samples: Samples,
    ) -> Result<Added, SimulateError> {
        let refused = |message: String| Err(SimulateError::Request(message));
        let highest = motions.iter().map(|(axis, ..)| *axis);
        let highest = highest.chain(sensitivities.iter().flat_map(|part| [part.axis, part.of])).max();
        if highest.is_some_and(|highest| highest >= axes) {
            return refused(
                "an axis x, y or z is given, but there is one axis only\ngive `axes = 3`".to_owned(),
            );
        }
        if motions.is_empty() && !sensitivities.is_empty() {
            let what =
                "misalignments and scale factors change what a gyro senses of a motion, but there is none";
            return refused(format!("{what}\ngive `motion = FILE`"));
        }
        let mut added = Added {
            motions: (0..axes).map(|_| None).collect(),
            parts: vec![vec![0; axes]; axes],
            temperature: None,
            switches: None,
            lock_in: None,
            samples,
            truth: String::new(),
        };
        for (axis, motion, what) in motions {
            let about = if axes == 1 { String::new() } else { format!(" about {}", AXES[axis]) };
            if added.motions[axis].replace(motion).is_some() {
                return refused(format!("the base has two motions{about}\ngive one, with all of its parts"));
            }
            added.truth += &format!("The base turns{about} by the motion of {what}\n");
        }
        for axis in 0..axes {
            let part = |of: usize| -> f64 {
                let own = sensitivities.iter().filter(|part| part.axis == axis && part.of == of);
                own.map(|part| part.part).sum()
            };
            let scale = 1.0 + part(axis);
            for of in 0..axes {
                let part = if of == axis { scale } else { scale * part(of) };
                added.parts[axis][of] = libm::round(libm::ldexp(part, FRACTION_BITS as i32)) as i128;
                if part != 0.0 && !sensitivities.is_empty() {
                    let [axis, of] = [axis, of].map(|axis| if axes == 1 { "axis" } else { AXES[axis] });
                    added.truth += &format!("The gyro {axis} senses {part:.10} of the rate about {of}.\n");
                }
            }
        }
        if let Some(Warming { ends: [from, to], coefficient }) = warming {
            let length_s = samples.sample_s * samples.count as f64;
            let motion = Motion { acceleration: coefficient * (to - from) / length_s, ..Motion::default() };
            let ramp = RecordMotion::new(&motion, samples);
            let ramp = ramp.map_err(|error| SimulateError::Request(error.message));
            added.temperature = Some(([from, to], ramp?));
            let coefficient = significant(coefficient, 12);
            added.truth += &format!(
                "The temperature goes from {from} to {to} degC; the rate has {coefficient} deg/h/K of its change.\n"
            );
        }
        Ok(added)
    }

    /// The samples of the records.
    pub(crate) fn samples(&self) -> Samples {
        self.samples
    }

    /// Whether nothing is added.
    pub(crate) fn is_nothing(&self) -> bool {
        self.temperature.is_none()
            && self.switches.is_none()
            && self.lock_in.is_none()
            && self.motions.iter().all(Option::is_none)
    }

    /// The number of the noise and of the draws of an axis in a record.
    pub(crate) fn number(&self, record: u64, axis: usize) -> u64 {
        record * self.motions.len() as u64 + axis as u64
    }

    /// The angles that are added to the samples of an axis.
    pub(crate) fn angles(&self, record: u64, axis: usize) -> impl Iterator<Item = i128> {
        let sensed = self.motions.iter().zip(&self.parts[axis]).enumerate();
        let mut sensed: Vec<_> = sensed
            .filter_map(|(of, (motion, part))| {
                let motion = motion.as_ref().filter(|_| *part != 0)?;
                Some((motion.increments(self.number(record, of), 0), *part))
            })
            .collect();
        let number = self.number(record, axis);
        let mut others: Vec<Box<dyn Iterator<Item = i128> + '_>> = vec![];
        if let Some((_, ramp)) = &self.temperature {
            others.push(Box::new(ramp.increments(record, 0)));
        }
        if let Some(switches) = &self.switches {
            others.push(Box::new(switches.angles(self.samples, number)));
        }
        if let Some(gyros) = &self.lock_in {
            let units = libm::ldexp(gyros.lsb_arcsec() / self.samples.lsb_arcsec, MOTION_BITS as i32);
            others.push(Box::new(gyros.departures(number).map(move |lsb| (f64::from(lsb) * units) as i128)));
        }
        (0..self.samples.count).map(move |_| {
            let turned = sensed.iter_mut().map(|(angles, part)| angles.next().unwrap_or_default() * *part);
            let turned: i128 = turned.sum();
            (turned >> FRACTION_BITS) + others.iter_mut().filter_map(Iterator::next).sum::<i128>()
        })
    }

    /// The angles of the samples about an axis, ″.
    pub(crate) fn true_angles(&self, record: u64, axis: usize) -> Option<impl Iterator<Item = f64>> {
        let motion = self.motions[axis].as_ref()?;
        let unit = motion.unit_arcsec();
        Some(motion.increments(self.number(record, axis), 0).map(move |angle| angle as f64 * unit))
    }

    /// The mean temperature of each sample, °C.
    pub(crate) fn temperatures(&self) -> Option<impl Iterator<Item = f64>> {
        let ([from, to], _) = self.temperature.as_ref()?;
        let count = self.samples.count;
        let part = move |sample: u64| (sample as f64 + 0.5) / count as f64;
        Some((0..count).map(move |sample| from + (to - from) * part(sample)))
    }
}
