//! The variance added by reading whole pulses: in closed form, or as a mean over the motion.
//!
//! A reading is the tick less the difference of the fractions f of a pulse at its two ends, so that fractions
//! telescope: the error is Σ_b (w_{b+1} − w_b) f_b over the boundaries b, where w is the weight of the tick that ends
//! at b. Each f is uniform and independent of the motion. The fractions at two boundaries with an angle d between them
//! have the covariance q²/(2π²) Σ_m cos(2πmd/q)/m², whose mean over the trials is that of the characteristic function
//! of d. Where that function has no closed form, the covariance is averaged over the motion itself.

use core::cell::RefCell;
use core::f64::consts::PI;
use std::collections::HashMap;

use crate::kinds::gap_fill::lower::fixed::{
    ANGLE_UNITS, CONSTANT_UNITS, Fixed, FixedTone, RAYLEIGH_UNIT, SIGMA_UNITS, gaussian_place, long_words,
};
use crate::kinds::gap_fill::lower::response::Functional;
use sagnac_theory::lattice;
use sagnac_theory::memo::Memo;
use sagnac_theory::pulse;

/// Damping by noise from which on the sum converges within its terms to the last digit.
const DAMPED: f64 = 64.0;

/// Largest omitted part otherwise, relative to the first factor: less than a ten-millionth of a pulse squared.
const NEGLIGIBLE: f64 = 1e-6;

/// Most terms of the sum over m.
const TERMS: u32 = 4096;

/// The fractions of a pulse at a point. Fillers share boundaries, and each sum is long, so it is computed once.
#[derive(Debug)]
pub(crate) struct Fractions<'a> {
    pub(crate) fixed: &'a Fixed,
    known: RefCell<HashMap<(i32, i32), Covariance>>,
}

/// Covariance of the fractions at two boundaries, with a bound of the omitted part; `None` without a closed form.
type Covariance = Option<(f64, f64)>;

impl<'a> Fractions<'a> {
    pub(crate) fn of(fixed: &'a Fixed) -> Fractions<'a> {
        Fractions { fixed, known: RefCell::default() }
    }

    /// The variance of their part of a sum, and a bound of its error, LSB²; `None` for motion whose characteristic
    /// function has no closed form here.
    pub(crate) fn variance(&self, f: &Functional) -> Option<(f64, f64)> {
        let Some(readout) = self.fixed.readout else { return Some((0.0, 0.0)) };
        let pulse = libm::exp2(f64::from(readout.bits));
        let boundaries = boundaries(self.fixed, f);
        let (mut sum, mut error) = (0.0, 0.0);
        for (i, &(from, g)) in boundaries.iter().enumerate() {
            sum += g * g * pulse * pulse / 12.0;
            for &(to, h) in &boundaries[i + 1..] {
                let (covariance, tail) = self.covariance(from, to, pulse)?;
                sum += 2.0 * g * h * covariance;
                error += 2.0 * (g * h).abs() * tail;
            }
        }
        Some((sum, error))
    }

    fn covariance(&self, from: i32, to: i32, pulse: f64) -> Option<(f64, f64)> {
        let compute = || covariance(self.fixed, from, to, pulse);
        *self.known.borrow_mut().entry((from, to)).or_insert_with(compute)
    }
}

/// Returns the variance that whole pulses add to a sum for any motion, LSB².
///
/// Without a closed form it is averaged over all positions of a recorded profile, or over a lattice of the drawn values
/// of tones; the average over noise and Gaussian motion is in closed form. It is right to a relative 1e-4 for profiles
/// and for swings of up to some thirty pulses, and to 1e-3 beyond, where the lattice is coarse.
pub(crate) fn variance(fixed: &Fixed, f: &Functional) -> f64 {
    if let Some((variance, _)) = Fractions::of(fixed).variance(f) {
        return variance;
    }
    let between: Vec<i32> = (f.ticks[0]..=f.ticks[f.ticks.len() - 1]).collect();
    let ticks = f.ticks.iter().map(|&tick| tick as u32);
    let weights = f.weights.iter().flat_map(|&weight| long_words(weight));
    let asked = fixed.words(&between).into_iter().chain(ticks).chain(weights).collect();
    AVERAGES.get(asked, || averaged(fixed, f))
}

/// The averages of the last few motions and fillers, by the words that determine them.
static AVERAGES: Memo<Vec<u32>, f64> = Memo::new(256);

/// The variance as a mean over the motion.
fn averaged(fixed: &Fixed, f: &Functional) -> f64 {
    let Some(readout) = fixed.readout else { return 0.0 };
    let (n, pulse) = (fixed.gap_ticks, libm::exp2(f64::from(readout.bits)));
    let (ticks, factors): (Vec<i32>, Vec<f64>) = boundaries(fixed, f).into_iter().unzip();
    let start = ticks.first().copied().unwrap_or(0);
    let constants: Vec<f64> = ticks.iter().map(|&b| constant(fixed, &spans(start, b, n)) / pulse).collect();
    let is_random = |tone: &FixedTone| tone.rayleigh || tone.phase_spread != 0;
    let is_stationary = fixed.profile.is_none()
        && fixed.tones.iter().all(is_random)
        && fixed.acceleration == 0.0
        && fixed.relock.is_empty();
    let deviation =
        |i: usize, j: usize| libm::sqrt(normal(fixed, &spans(ticks[i], ticks[j], n), &[])) / pulse;
    let draws = fixed.profile.as_ref().map_or(lattice::POINTS as usize, |profile| profile.positions);
    let angles = |draw: usize, angles: &mut [f64]| {
        angles.copy_from_slice(&constants);
        if let Some(profile) = &fixed.profile {
            for (angle, &b) in angles.iter_mut().zip(&ticks) {
                *angle += f64::from(profile.angle(draw, b)) / pulse;
            }
        }
        let mut coordinates = lattice::point(draw as u32);
        for tone in &fixed.tones {
            let drawn = tone.drawn(&mut coordinates);
            for (angle, &b) in angles.iter_mut().zip(&ticks) {
                *angle += drawn.angle(b, n) / pulse;
            }
        }
    };
    let class = |i: usize, j: usize| is_stationary.then(|| class([ticks[i], ticks[j]], n));
    pulse::mean_variance(&factors, deviation, class, draws, angles) * pulse * pulse / 12.0
}

/// What the mean covariance of the fractions at two boundaries depends on where the motion is stationary: their distance, and
/// whether the gap lies between them, whose noise is one word.
pub(crate) fn class(boundaries: [i32; 2], gap_ticks: i32) -> (i32, bool) {
    let [from, to] = boundaries;
    (to - from, from <= 0 && to >= gap_ticks)
}

/// The boundaries at which a fraction counts, each with its factor.
fn boundaries(fixed: &Fixed, f: &Functional) -> Vec<(i32, f64)> {
    let weight = |tick: i32| f.ticks.iter().position(|&own| own == tick).map_or(0.0, |k| f.weights[k] as f64);
    let [Some(&first), Some(&last)] = [f.ticks.first(), f.ticks.last()] else { return vec![] };
    // Boundary b is the end of tick b; boundaries within the gap have no weight.
    (first.min(1) - 1..=last.max(0))
        .filter(|b| !(1..fixed.gap_ticks).contains(b))
        .map(|b| {
            // The interval after tick 0 is the gap, which is not read.
            let next = if b == 0 { 0.0 } else { weight(b + 1) };
            let own = if b == fixed.gap_ticks && b > 0 { 0.0 } else { weight(b) };
            (b, next - own)
        })
        .filter(|(_, g)| *g != 0.0)
        .collect()
}

/// Covariance of the fractions at two boundaries, with a bound of the omitted part.
fn covariance(fixed: &Fixed, from: i32, to: i32, pulse: f64) -> Covariance {
    if fixed.profile.is_some() || !fixed.tones.iter().all(FixedTone::is_plain) {
        return None;
    }
    let n = fixed.gap_ticks;
    let parts = spans(from, to, n);
    // The angle between the boundaries consists of a constant, tones of random phase, and a normal part.
    let mut constant = constant(fixed, &parts);
    let mut rayleigh = Vec::new();
    let mut swings = Vec::new();
    for tone in &fixed.tones {
        let [a, b] = swung(tone, &parts, n);
        let phase = f64::from(tone.phase) / libm::exp2(32.0) * 2.0 * PI;
        if tone.rayleigh {
            rayleigh.push((a * a + b * b) * RAYLEIGH_UNIT * RAYLEIGH_UNIT);
        } else if tone.phase_spread != 0 {
            // Without a swing the closed form is exact.
            let swing = libm::hypot(a, b);
            if swing > 0.0 {
                swings.push(swing);
            }
        } else {
            constant += a * libm::sin(phase) + b * libm::cos(phase);
        }
    }
    let normal = normal(fixed, &parts, &rayleigh);
    if swings.is_empty() {
        let part = pulse::covariance(constant / pulse, libm::sqrt(normal) / pulse);
        return Some((pulse * pulse / 12.0 * part, 0.0));
    }
    let unit = pulse * pulse / (2.0 * PI * PI);
    // J0(x)| is at most √(2/(πx)) and at most 1, so a swing over many pulses leaves at most a fraction 1/√m of term m.
    let parts = swings.iter().map(|d| pulse / (PI * PI * d)).filter(|part| *part < 1.0);
    let (envelope, power) =
        parts.fold((1.0, 1.0), |(envelope, power), part| (envelope * libm::sqrt(part), power + 0.5));
    let (mut sum, mut rest) = (0.0, 1.0);
    for m in (1..=TERMS).map(f64::from) {
        let k = 2.0 * PI * m / pulse;
        let damped = libm::exp(-0.5 * k * k * normal);
        if damped < 1e-15 {
            rest = 0.0;
            break;
        }
        let swung: f64 = swings.iter().map(|swing| libm::j0(k * swing)).product();
        sum += damped * swung * libm::cos(k * constant) / (m * m);
        if m >= DAMPED || m == f64::from(TERMS) {
            // Later terms have at most this damping and envelope, and Σ j^(−1−p) beyond m is below m^−p / p.
            rest = damped * envelope * libm::pow(m, -power) / power;
            if m >= DAMPED && rest < NEGLIGIBLE {
                break;
            }
        }
    }
    Some((unit * sum, unit * rest))
}

/// The angle over the spans that is common to all trials.
fn constant(fixed: &Fixed, parts: &[(i32, bool)]) -> f64 {
    let n = fixed.gap_ticks;
    let mut sum = 0.0;
    for &(tick, gap) in parts {
        let of = if gap { fixed.gap_constant(n) } else { fixed.tick_constant(tick) };
        sum += of as f64 / CONSTANT_UNITS;
    }
    sum
}

/// The variance of the normal part of the angle over the spans: noise, `more`, and Gaussian motion.
fn normal(fixed: &Fixed, parts: &[(i32, bool)], more: &[f64]) -> f64 {
    let n = fixed.gap_ticks;
    let mut sum = 0.0;
    for &(_, gap) in parts {
        let gap_sigma = fixed.readout.map_or(0.0, |readout| f64::from(readout.gap_sigma) / SIGMA_UNITS);
        let sigma = if gap { gap_sigma } else { fixed.sigma_lsb() };
        sum += sigma * sigma;
    }
    for part in more {
        sum += part;
    }
    if let Some(factor) = &fixed.gaussian {
        for i in 0..factor.len() {
            let word =
                |tick: i32| factor[gaussian_place(tick, n)].get(i).map_or(0.0, |&word| f64::from(word));
            let angle: f64 =
                parts.iter().map(|&(tick, gap)| if gap { (1..=n).map(word).sum() } else { word(tick) }).sum();
            sum += angle * angle / (SIGMA_UNITS * SIGMA_UNITS);
        }
    }
    sum
}

/// The spans between two boundaries: ticks, and the gap as a whole.
fn spans(from: i32, to: i32, n: i32) -> Vec<(i32, bool)> {
    (from + 1..=to).filter(|tick| !(2..=n).contains(tick)).map(|tick| (tick, tick == 1)).collect()
}

/// The angle of a plain tone over the spans, at sine 1 and cosine 1.
fn swung(tone: &FixedTone, parts: &[(i32, bool)], n: i32) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for &(tick, gap) in parts {
        let words = if gap { tone.gap_words(n, n) } else { tone.tick_words(tick, n) };
        sum[0] += f64::from(words[0]) / ANGLE_UNITS;
        sum[1] += f64::from(words[1]) / ANGLE_UNITS;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::read::Error;
    use crate::kinds::gap_fill::GapFill;
    use crate::kinds::gap_fill::lower::Lowered;
    use crate::kinds::gap_fill::lower::estimate::{Estimate, functionals};
    use crate::study::Study;

    /// A point with pulses of 1 ″, this motion, and noise as a standard deviation in ″.
    fn lowered(motion: &str, noise: f64, gap_ticks: u32, fillers: &str) -> Lowered {
        let text = format!(
            "title = \"pulses\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"5 ms\"\nreadout_lsb = \"1 arcsec\"\n\
             tick_noise = {{ std = \"{noise} arcsec\" }}\n[motion]\n{motion}\n[switching]\ngap_ticks = {gap_ticks}\n\
             errors = [\"residual\"]\nfillers = [{fillers}]\n"
        );
        let study = Study::parse("pulses.toml", &text).unwrap();
        let asked = study.asked::<GapFill>().unwrap();
        Lowered::new(&asked.points[0], &asked.fillers, &asked.errors, 1, study.streams).unwrap()
    }

    /// The variances of the fillers of a point, in squared pulses.
    fn variances(lowered: &Lowered, of: fn(&Fixed, &Functional) -> f64) -> Vec<f64> {
        let of_filler = |estimates: &Vec<Estimate>| {
            let rows = &estimates[0].rows;
            let unit = lowered.fixed.lsb_arcsec / rows.denominator as f64;
            let all = functionals(rows, Error::Residual, lowered.fixed.gap_ticks);
            of(&lowered.fixed, &all[0]) * unit * unit
        };
        lowered.fillers.iter().map(of_filler).collect()
    }

    fn closed(fixed: &Fixed, f: &Functional) -> f64 {
        Fractions::of(fixed).variance(f).expect("a motion with a closed form").0
    }

    #[test]
    fn the_average_over_the_motion_is_the_closed_form_where_there_is_one() {
        let fillers = "\"const\", \"quadratic\", { kind = \"minimum-variance\", band = [\"18 Hz\", \"22 Hz\"], \
                       fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }";
        let motions = [
            "rate = \"64.3 arcsec/s\"",
            "amplitude = \"4 arcsec/s\"\nfrequency = \"20 Hz\"",
            "amplitude = \"60 arcsec/s\"\nfrequency = \"20 Hz\"",
            "amplitude = \"12000 arcsec/s\"\nfrequency = \"19.3 Hz\"",
            "amplitude = \"60 arcsec/s\"\nfrequency = \"20 Hz\"\nphase = \"extremum\"\nacceleration = \"0.3 deg/s^2\"",
            "amplitude = { rayleigh = \"60 arcsec/s\" }\nfrequency = \"20 Hz\"\nrate = \"0.1 deg/s\"",
            "gaussian = { rms = \"60 arcsec/s\", band = [\"18 Hz\", \"22 Hz\"] }\nrate = \"33 arcsec/s\"",
            "tones = [{ amplitude = \"90 arcsec/s\", frequency = \"11 Hz\" }, { amplitude = \"300 arcsec/s\", frequency = \"31 Hz\" }]",
        ];
        for motion in motions {
            for (noise, gap_ticks) in [(0.004, 1), (0.05, 3), (0.4, 5)] {
                let lowered = lowered(motion, noise, gap_ticks, fillers);
                let pairs = variances(&lowered, averaged).into_iter().zip(variances(&lowered, closed));
                for (found, expected) in pairs {
                    let off = (found / expected - 1.0).abs();
                    assert!(off < 1e-4, "{motion}, {noise} ″, gap of {gap_ticks}: {found}, not {expected}");
                }
            }
        }
    }

    /// Given its amplitude and frequency, a drawn tone is one with a closed form.
    #[test]
    fn the_average_over_drawn_tones_is_the_mean_of_the_closed_forms_at_their_values() {
        const STEPS: u32 = 400;
        let cases =
            [("uniform", 0.02, 1), ("uniform", 0.1, 3), ("zero-crossing", 0.004, 3), ("extremum", 0.05, 5)];
        for (phase, noise, gap_ticks) in cases {
            for peak in [10.0, 200.0, 4000.0] {
                let of = |amplitude: String, frequency: String, variance: fn(&Fixed, &Functional) -> f64| {
                    let motion = format!(
                        "amplitude = {amplitude}\nfrequency = {frequency}\nphase = \"{phase}\"\nrate = \"620 arcsec/s\""
                    );
                    // At a random phase, the last filler has more pairs of a lag than are averaged.
                    let last = if phase == "uniform" {
                        "[\"-5..0\", \"n+1..n+6\"]"
                    } else {
                        "[\"-1..0\", \"n+1..n+2\"]"
                    };
                    let fillers = format!(
                        "\"const\", \"quadratic\", {{ kind = \"linear\", name = \"long\", fit_ticks = {last} }}"
                    );
                    variances(&lowered(&motion, noise, gap_ticks, &fillers), variance)
                };
                let rate = |x: f64| format!("\"{x} arcsec/s\"");
                let hertz = |x: f64| format!("\"{x} Hz\"");
                let amplitudes = format!("{{ uniform = [{}, {}] }}", rate(0.5 * peak), rate(peak));
                let frequencies = format!("[{}, {}]", hertz(18.0), hertz(22.0));
                let at = |place: u32| (f64::from(place) + 0.5) / f64::from(STEPS);
                let mean = |of: &dyn Fn(f64) -> Vec<f64>| {
                    let all: Vec<Vec<f64>> = (0..STEPS).map(|place| of(at(place))).collect();
                    [0, 1, 2].map(|filler| all.iter().map(|one| one[filler]).sum::<f64>() / f64::from(STEPS))
                };
                let by_amplitude = mean(&|x| of(rate(peak * (0.5 + 0.5 * x)), hertz(20.0), closed));
                let by_frequency = mean(&|x| of(rate(peak), hertz(18.0 + 4.0 * x), closed));
                for (drawn, found, expected) in [
                    ("amplitude", of(amplitudes, hertz(20.0), averaged), by_amplitude),
                    ("frequency", of(rate(peak), frequencies, averaged), by_frequency),
                ] {
                    for (found, expected) in found.into_iter().zip(expected) {
                        let off = (found / expected - 1.0).abs();
                        assert!(
                            off < 1e-4,
                            "{drawn} up to {peak} ″/s, {phase}, {noise} ″, gap of {gap_ticks}: {found}, not {expected}"
                        );
                    }
                }
            }
        }
    }
}
