//! The exact mean and deviation of angles of runs, for the lowered parameters.

use core::f64::consts::PI;

use crate::kinds::gap_fill::lower::fixed::{ANGLE_UNITS, SIGMA_UNITS};
use crate::kinds::switched_run::Angle as RunAngle;
use crate::kinds::switched_run::lower::fixed::{Fixed, FixedRow, FixedTime, FixedTone};

/// Mean and standard deviation of an angle, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunTheory {
    /// Mean over runs, signed.
    pub mean: f64,
    /// Standard deviation from run to run.
    pub deviation: f64,
    /// Bound of the deviation of a sampled mean or rms due to rounding in the kernel.
    pub rounding: f64,
}

impl RunTheory {
    /// √(mean² + deviation²), ″.
    pub fn rms(&self) -> f64 {
        libm::hypot(self.mean, self.deviation)
    }
}

impl Fixed {
    /// The theory of an angle of the study with index `place`; `None` where a compensated relock has no closed form.
    pub(crate) fn theory(&self, angle: RunAngle, place: usize) -> Option<RunTheory> {
        if self.relock.as_ref().is_some_and(|relock| !relock.exact) {
            return None;
        }
        self.about(angle, place)
    }

    /// The theory of an angle; for a compensated relock it is approximated by the first trials.
    fn about(&self, angle: RunAngle, place: usize) -> Option<RunTheory> {
        match angle {
            RunAngle::Largest => None,
            RunAngle::End if !self.drawn.is_empty() => {
                Some(averaged(self.drawn.iter().map(|end| self.within(end))))
            }
            RunAngle::End => {
                let [whole, last] = self.walk.map(square);
                let walk = (self.ends.len() - 1) as f64 * whole + last;
                self.ends.last().map(|row| self.at(row, walk))
            }
            RunAngle::At(_) => {
                place.checked_sub(2).and_then(|time| self.times.get(time)).map(|time| self.within(time))
            }
        }
    }

    /// Mean and deviation at a time within an interval.
    fn within(&self, time: &FixedTime) -> RunTheory {
        let walk = time.row.switches as f64 * square(self.walk[0]) + square(time.walk) + square(time.bridge);
        self.at(&time.row, walk)
    }

    /// Mean and deviation at the drift `row`, with the variance `walk` of the random walk, LSB².
    fn at(&self, row: &FixedRow, walk: f64) -> RunTheory {
        let switches = row.switches as f64;
        let constant = self.constant as f64 / libm::exp2(32.0);
        let deviations: f64 = row.deviations.iter().map(|&word| square(word.unsigned_abs())).sum();
        let mut variance = walk + deviations + switches * square(self.noise);
        let mut relocked = 0.0;
        let mut rounded = 0.0;
        if let Some(relock) = &self.relock {
            let deviation = relock.deviation / self.lsb_arcsec;
            let alike = switches * relock.alike / self.lsb_arcsec;
            variance += switches * deviation * deviation + alike * alike;
            relocked = switches * relock.mean / self.lsb_arcsec;
            // Each switch is rounded to the LSB once more.
            rounded = switches * (relock.rounding + 0.5 * self.lsb_arcsec);
        }
        for tone in &self.tones {
            let amplitude = f64::from(tone.amplitude) / ANGLE_UNITS;
            let times = if tone.each { switches } else { in_phase(tone.step, row.switches) };
            variance += 0.5 * amplitude * amplitude * times;
        }
        let [heated, spread, rounding] = match &self.warm_up {
            Some(warm_up) => {
                let [mean, variance] = warm_up.moments(row.time_s, row.held_s);
                let lsb = self.lsb_arcsec;
                [mean / lsb, variance / (lsb * lsb), warm_up.rounding()]
            }
            None => [0.0; 3],
        };
        // Where the first mode is drawn, the magnetic part has either sign.
        let magnetic = f64::from(row.magnetic) + heated;
        let (mean, drawn) = if self.mode { (0.0, magnetic) } else { (heated, 0.0) };
        RunTheory {
            mean: (f64::from(row.angle) + mean + relocked + switches * constant) * self.lsb_arcsec,
            deviation: libm::sqrt(variance + spread + drawn * drawn) * self.lsb_arcsec,
            rounding: 2.0 * self.lsb_arcsec + rounding + rounded,
        }
    }

    /// Bound of the rms of the difference between an angle of these words and that of the inputs, ″, with `of_switch` as
    /// that of a switch: each word is within half its unit of what it stands for.
    pub(crate) fn representation(&self, switches: f64, of_switch: f64) -> f64 {
        // Drift and its three deviations; walk, noise and sines of each switch; their common part.
        let once = 1.0 + 3.0 * 0.5 / SIGMA_UNITS;
        let each = libm::sqrt(switches) * 2.0 * 0.5 / SIGMA_UNITS + switches / libm::exp2(33.0);
        let sine = |tone: &FixedTone| {
            let times = if tone.each { libm::sqrt(switches) } else { switches };
            // The phase advances by up to 2^−33 turns more or less at each switch, which adds up over the run.
            let advance = if tone.each { 0.0 } else { PI * libm::exp2(-33.0) * switches * switches };
            (0.5 * times + advance * f64::from(tone.amplitude)) / ANGLE_UNITS
        };
        let sines: f64 = self.tones.iter().map(sine).sum();
        let ends = self.ends.iter().chain(self.drawn.iter().map(|end| &end.row));
        let largest = ends.map(|row| row.angle.unsigned_abs().max(row.magnetic.unsigned_abs())).max();
        // Inputs have 12 digits.
        let digits = 1e-11 * f64::from(largest.unwrap_or(0));
        (once + each + sines + digits) * self.lsb_arcsec + switches * of_switch
    }

    /// Approximate rms of an angle, LSB; where it is unknown, the largest one at the end of any interval.
    pub(crate) fn expected_rms(&self, angle: RunAngle, place: usize) -> f64 {
        match self.about(angle, place) {
            Some(theory) => theory.rms() / self.lsb_arcsec,
            None => {
                let walk = |row: &FixedRow| (row.switches + 1) as f64 * square(self.walk[0]);
                let heated = |row: &FixedRow| {
                    let usual = self.warm_up.as_ref().map(|warm_up| warm_up.usual(row.time_s, row.held_s));
                    usual.unwrap_or(0.0).abs() / self.lsb_arcsec
                };
                let unheated =
                    Fixed { warm_up: None, ends: vec![], times: vec![], drawn: vec![], ..self.clone() };
                let rms = |row: &FixedRow| unheated.at(row, walk(row)).rms() / self.lsb_arcsec + heated(row);
                self.ends.iter().map(rms).fold(0.0, f64::max)
            }
        }
    }
}

/// Mean and deviation over angles that are equally likely.
fn averaged(angles: impl ExactSizeIterator<Item = RunTheory>) -> RunTheory {
    let n = angles.len() as f64;
    let (mut mean, mut square, mut rounding) = (0.0, 0.0, 0.0_f64);
    for angle in angles {
        mean += angle.mean / n;
        square += angle.rms() * angle.rms() / n;
        rounding = rounding.max(angle.rounding);
    }
    RunTheory { mean, deviation: libm::sqrt((square - mean * mean).max(0.0)), rounding }
}

/// The square of a standard deviation in 2^−4 LSB, LSB².
fn square(word: u32) -> f64 {
    let sigma = f64::from(word) / SIGMA_UNITS;
    sigma * sigma
}

/// |Σ_{j<n} e^{2πi·j·step}|².
fn in_phase(step: u32, n: usize) -> f64 {
    let half = PI * f64::from(step) / libm::exp2(32.0);
    let n = n as f64;
    if step == 0 {
        return n * n;
    }
    let ratio = libm::sin(n * half) / libm::sin(half);
    ratio * ratio
}
