//! The points of a gap-fill study and their physical inputs, in ″ and s, with the keys that set them.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::filler::read::{Extrapolation, GAP_TICKS, Written};
use crate::filler::{Fill, Method, Specification, Target, TickList};
use crate::key::document::SpanMap;
use crate::key::sweep::{SweepTarget, Sweep, SweepValue};
use crate::key::{ParseContext, ValueType, keys, measure};
use crate::kinds::TICK;
use crate::kinds::gap_fill::sweepable;
use crate::motion::keys::Design;
use crate::motion::{Frequency, Gaussian, Motion, Profile, Tone};
use crate::noise::{self, NOISE, Noise};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::{Dimension, round_12};
use sagnac_kernel::gap_fill::shape::MAX_SIDE;
use sagnac_theory::allan::terms::Term;
use sagnac_theory::minimum_variance::{Band, sides};

/// The inputs on which the motion, the noise and the gap of one point depend. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Tick T, s.
    pub tick_s: f64,
    /// White noise of the ticks.
    pub tick_noise: TickNoise,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
    pub readout_lsb: f64,
    /// Angle that the relock adds to the ticks n+1, n+2, …, ″.
    pub relock: Vec<f64>,
    /// Motion of the base.
    pub motion: Motion,
    /// Motion on which fillers are judged instead of that of the base.
    pub specification: Option<Arc<Specification>>,
    /// Number of lost ticks n.
    pub gap_ticks: u32,
}

/// Noise of the angle of one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TickNoise {
    /// Standard deviation σ, ″.
    Std(f64),
    /// Angle random walk N, ″/√s.
    AngleRandomWalk(f64),
}

impl TickNoise {
    /// The noise with the given three standard deviations, ″.
    fn from_three_sigma(three_sigma: f64) -> TickNoise {
        TickNoise::Std(round_12(three_sigma / 3.0))
    }
}

impl Inputs {
    /// σ of the noise of one tick, ″: as given, or N·√T.
    pub fn sigma_arcsec(&self) -> f64 {
        match self.tick_noise {
            TickNoise::Std(sigma) => sigma,
            TickNoise::AngleRandomWalk(n) => n * libm::sqrt(self.tick_s),
        }
    }

    /// Covariance of the errors of readings at lags 0 and 1, ″², from noise and whole pulses.
    pub fn noise_covariance(&self) -> [f64; 2] {
        // A reading of whole pulses is wrong by the difference of two fractions, and neighbours share one of them.
        let fraction = self.readout_lsb * self.readout_lsb / 12.0;
        let sigma = self.sigma_arcsec();
        [sigma * sigma + 2.0 * fraction, -fraction]
    }

    /// Whether the base is at rest and nothing is added to the ticks.
    pub(crate) fn is_nothing(&self) -> bool {
        let added = self.relock.iter().any(|angle| *angle != 0.0);
        self.motion == Motion::default() && self.sigma_arcsec() == 0.0 && self.readout_lsb == 0.0 && !added
    }

    /// Δt·ν with Δt = (n+1)T/2, from the middle of the gap to the nearest valid tick (our reading of Z(20)). `None`
    /// unless the motion is one tone of fixed frequency.
    pub fn dt_nu(&self) -> Option<f64> {
        let (_, frequency_hz) = self.motion.single_tone()?;
        Some((f64::from(self.gap_ticks) + 1.0) / 2.0 * self.tick_s * frequency_hz)
    }

    /// A_Ω·T/σ, the ratio of the angle of a tick at the peak of the rate to the standard deviation of its noise. `None`
    /// without noise, and unless the motion is one tone of fixed frequency and amplitude.
    pub fn amplitude_noise(&self) -> Option<f64> {
        let (rate, _) = self.motion.single_tone()?;
        let sigma = self.sigma_arcsec();
        (sigma > 0.0).then(|| rate * self.tick_s / sigma)
    }
}

const ANGLES: ValueType = measure(&[Dimension::Angle], 0.0, 1e6, "0 to 1e6 arcsec");
const THREE_SIGMAS: ValueType = measure(&[Dimension::Angle], 0.0, 3e6, "0 to 3e6 arcsec");
const N: ValueType = measure(&[Dimension::AngleRandomWalk], 0.0, 1e9, "0 to 1e9 arcsec/sqrt(s)");
const PULSES: ValueType = measure(&[Dimension::Angle], 1e-6, 1e6, "1e-6 to 1e6 arcsec");
const RELOCKS: ValueType = measure(&[Dimension::Angle], -1e6, 1e6, "-1e6 to 1e6 arcsec");
const TABLE: ValueType = ValueType::Table;

keys! {
    /// The keys of the gyro, except its tick.
    pub(crate) static KEYS;
    /// The gyro.
    pub GYRO = "gyro", "", Fixed, TABLE, "[gyro]\ntick = \"5 ms\"\ntick_noise = { std = \"0.53 arcsec\" }";
    /// Noise of the angle of one tick, independent from tick to tick, in exactly one of three forms. Leave it out if
    /// [noise] gives the noise.
    pub(crate) TICK_NOISE = "gyro.tick_noise", "", Fixed, ValueType::OneOf, "tick_noise = { std = \"0.53 arcsec\" }   # std = \"0 arcsec\" if there is no noise, for example with readout_lsb alone";
    /// Standard deviation, an angle: "0.53 arcsec".
    NOISE_STD = "gyro.tick_noise.std", "tick noise σ", Condition, ANGLES, r#"std = "0.53 arcsec""#;
    /// Three standard deviations, an angle: "1.6 arcsec".
    NOISE_THREE_SIGMA = "gyro.tick_noise.three_sigma", "tick noise 3σ", Condition, THREE_SIGMAS, r#"three_sigma = "1.6 arcsec""#;
    /// Angle random walk N, from which the standard deviation is N·√tick: "0.003 deg/sqrt(h)".
    pub(crate) NOISE_RANDOM_WALK = "gyro.tick_noise.angle_random_walk", "angle random walk", Condition, N, r#"angle_random_walk = "0.003 deg/sqrt(h)""#;
    /// Angle of a pulse, if the gyro counts whole pulses: "3.2 arcsec". If absent, the readout is not quantized.
    pub READOUT_LSB = "gyro.readout_lsb", "pulse weight", Condition, PULSES, r#"readout_lsb = "3.2 arcsec""#;
    /// Angles that the uncorrected relock adds to the ticks n+1, n+2, …: ["20.3 arcsec", "14.8 arcsec"].
    pub RELOCK = "gyro.relock", "", Fixed, ValueType::List(&RELOCKS), r#"relock = ["20.3 arcsec", "14.8 arcsec"]"#;
}

/// The settings that can be swept, except the motion.
pub(crate) static SETTINGS: [SweepTarget<Inputs>; 6] = [
    SweepTarget::new(&TICK, |inputs, tick| inputs.tick_s = tick.value),
    SweepTarget::new(&NOISE_STD, |inputs, sigma| inputs.tick_noise = TickNoise::Std(sigma.value)),
    SweepTarget::new(&NOISE_THREE_SIGMA, |inputs, three_sigma| {
        inputs.tick_noise = TickNoise::from_three_sigma(three_sigma.value);
    }),
    SweepTarget::new(&NOISE_RANDOM_WALK, |inputs, n| inputs.tick_noise = TickNoise::AngleRandomWalk(n.value)),
    SweepTarget::new(&READOUT_LSB, |inputs, lsb| inputs.readout_lsb = lsb.value),
    // Within its limits a count converts exactly.
    SweepTarget::new(&GAP_TICKS, |inputs, n| inputs.gap_ticks = n.value as u32),
];

/// The noise of `[noise]`, where the study has it instead of `gyro.tick_noise`.
pub(crate) fn read(reading: &mut ParseContext) -> Result<Option<Noise>, Wrong> {
    const ACCEPTED: &str = "accepted: gyro.tick_noise = { std = \"0.53 arcsec\" }, or the coefficients of a record as in\n\
                            [noise]\nfile = \"noise.toml\"";
    match (reading.get(&TICK_NOISE), reading.get(&NOISE)) {
        (Some(_), None) => Ok(None),
        (None, Some(table)) => {
            reading.places.add(TICK_NOISE.name, table.span());
            reading.places.add(READOUT_LSB.name, table.span());
            let noise = noise::read(reading)?.noise;
            noise.lock_in.map_or(Ok(()), |lock_in| lock_in.check(&reading.places))?;
            Ok(Some(noise))
        }
        (Some(tick_noise), Some(_)) => {
            let message = "gyro.tick_noise conflicts with [noise]";
            Err(tick_noise.fault(message, "a second noise", ACCEPTED).into())
        }
        (None, None) => {
            let place = reading.table.span_of(&GYRO).unwrap_or_default();
            Err(Fault::new(place, "the key `tick_noise` is missing", "in this table", ACCEPTED).into())
        }
    }
}

/// Sets N as the noise of ticks, and Q as that of a readout in whole pulses of √12·Q, whose error is Q.
pub(crate) fn set(inputs: &mut Inputs, noise: &Noise) {
    inputs.tick_noise = TickNoise::AngleRandomWalk(noise.of(Term::AngleRandomWalk)[0]);
    inputs.readout_lsb = match noise.readout_lsb {
        0.0 => of_quantization(noise),
        lsb => lsb,
    };
}

/// The pulse whose error is Q, ″.
fn of_quantization(noise: &Noise) -> f64 {
    round_12(libm::sqrt(12.0) * noise.of(Term::Quantization)[0])
}

/// A note on the parts that are left out over a gap, each with the angle that it could accumulate in the longest gap of
/// the study.
pub(crate) fn left_out(noise: &Noise, inputs: &Inputs, sweeps: &[Sweep]) -> Option<String> {
    let longest = |name: &str, written: f64| {
        let values = sweeps.iter().filter(|sweep| sweep.key.name == name).flat_map(|sweep| &sweep.values);
        values.filter_map(|value| Some(value.quantity()?.value)).fold(written, f64::max)
    };
    let tick_s = longest(TICK.name, inputs.tick_s);
    let gap_s = tick_s * longest(GAP_TICKS.name, f64::from(inputs.gap_ticks));
    // A given pulse has an error of its own.
    let is_read = inputs.readout_lsb != of_quantization(noise) || longest(READOUT_LSB.name, 0.0) > 0.0;
    let [q, _] = noise.of(Term::Quantization);
    let quantization = (is_read && q > 0.0).then_some(("quantization", q));
    let parts: Vec<String> = noise
        .over(gap_s)
        .into_iter()
        .chain(quantization)
        .map(|(name, arcsec)| format!("{name} ({}″)", significant(arcsec, 2)))
        .collect();
    let readout = longest(READOUT_LSB.name, inputs.readout_lsb);
    let sigma = Inputs { tick_s, ..inputs.clone() }.sigma_arcsec();
    (!parts.is_empty()).then(|| {
        format!(
            "of [noise], a gap of up to {} s includes angle random walk, {}″ in a tick{}; left out, with the angle \
             accumulated over the gap: {}",
            significant(gap_s, 4),
            significant(sigma, 3),
            if readout > 0.0 { format!(", and pulses of {}″", significant(readout, 3)) } else { String::new() },
            parts.join(", ")
        )
    })
}

/// Highest vibration frequency, in tick rates; above it only aliases of the vibration reach the ticks.
const MAX_TICK_RATES: f64 = 10.0;
/// Highest amplitude of the rate, ″/s.
const MAX_RATE: f64 = 1e9;
/// Highest σ of one tick, ″.
const MAX_SIGMA: f64 = 1e6;

/// One combination of swept values, with everything derived from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Inputs that determine the draws.
    pub inputs: Inputs,
    /// The ticks of each filler, in the order of the fillers. Points with equal gaps share them.
    pub fills: Arc<[Fill]>,
    /// Inputs for which fillers are designed, where they are not those of the point.
    pub design: Option<Box<Inputs>>,
}

/// What the fillers of least error for the motion of a point are designed for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Designed {
    /// The motion and noise that determine the draws.
    Here,
    /// A part of a record other than the one that is replayed.
    OtherPart,
    /// Other inputs.
    Elsewhere,
}

impl Point {
    /// What its fillers of least error are designed for.
    pub(crate) fn designed(&self) -> Designed {
        let is_half = |profile: &Profile| profile.design == Design::FirstHalf;
        match (&self.design, &self.inputs.motion.profile) {
            (Some(_), _) => Designed::Elsewhere,
            (None, Some(profile)) if is_half(profile) => Designed::OtherPart,
            (None, _) => Designed::Here,
        }
    }

    /// Most ticks on a side of the gap that a filler reads.
    pub(crate) fn sides(&self) -> usize {
        let ticks = |fill: &Fill| {
            let all = [Some(&fill.fit_ticks), fill.extrapolation_ticks.as_ref()].into_iter().flatten();
            all.map(|ticks| sides(ticks, self.inputs.gap_ticks)).max()
        };
        self.fills.iter().filter_map(ticks).fold(1, usize::max)
    }

    /// The point at which motion between ticks matters most: that of the shortest tick, and of the longest gap.
    pub(crate) fn hardest(points: &[Point]) -> Option<&Point> {
        points.iter().min_by(|a, b| {
            let gap_ticks = |point: &Point| point.inputs.gap_ticks;
            a.inputs.tick_s.total_cmp(&b.inputs.tick_s).then(gap_ticks(b).cmp(&gap_ticks(a)))
        })
    }

    /// Its swept values as text, such as ` (switching.gap_ticks = 5)`; empty without sweeps.
    pub(crate) fn place(&self) -> String {
        let values: Vec<String> = self.swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        if values.is_empty() { String::new() } else { format!(" ({})", values.join(", ")) }
    }
}

/// The ticks of the fillers, as written.
#[derive(Debug)]
pub(crate) struct Switch {
    /// Whether `[noise]` gives the noise.
    pub(crate) has_noise: bool,
    pub(crate) fillers: Vec<Written>,
    pub(crate) fit_ticks: TickList,
    pub(crate) extrapolation_ticks: TickList,
}

impl Switch {
    /// All points of some sweeps, in order.
    ///
    /// # Errors
    /// The first point that is invalid.
    pub(crate) fn points(
        &self,
        inputs: &Inputs,
        sweeps: &[Sweep],
        places: &SpanMap,
    ) -> Result<Vec<Point>, Fault> {
        let (base, mut known) = (Base { switch: self, places }, HashMap::new());
        let point = |(swept, inputs)| base.point(swept, inputs, &mut known);
        sweepable().points(inputs, sweeps).map(point).collect()
    }
}

/// The inputs that all points have in common, with the places of the keys of the study.
struct Base<'a> {
    switch: &'a Switch,
    places: &'a SpanMap,
}

impl Base<'_> {
    /// A point; `known` are the ticks of the fillers for each length of the gap so far.
    fn point(
        &self,
        swept: Vec<(&'static str, SweepValue)>,
        mut inputs: Inputs,
        known: &mut HashMap<u32, Arc<[Fill]>>,
    ) -> Result<Point, Fault> {
        if let Some(vibration) = inputs.motion.vibration.clone() {
            vibration.check(inputs.tick_s, MAX_TICK_RATES, self.places)?;
            vibration.add_to(&mut inputs.motion);
        }
        self.check(&inputs)?;
        let fills = match known.get(&inputs.gap_ticks) {
            Some(fills) => fills.clone(),
            None => {
                let fills = self.switch.fillers.iter().map(|written| self.fill(written, &inputs));
                let fills: Arc<[Fill]> = fills.collect::<Result<_, _>>()?;
                known.entry(inputs.gap_ticks).or_insert(fills).clone()
            }
        };
        Ok(Point { swept, inputs, fills, design: None })
    }

    /// Checks limits that involve more than one value.
    fn check(&self, inputs: &Inputs) -> Result<(), Fault> {
        for tone in &inputs.motion.tones {
            self.check_tone(tone, inputs)?;
        }
        if let Some(Gaussian::Band { band, .. }) = &inputs.motion.gaussian {
            let names = ["motion.gaussian.low", "motion.gaussian.high", "motion.gaussian", "gyro.tick"];
            self.check_order("motion.gaussian", *band, &names)?;
        }
        if let Some(high_hz) = inputs.motion.gaussian.as_ref().and_then(Gaussian::highest_hz) {
            let place = self.places.blame(&["motion.gaussian.high", "motion.gaussian", "gyro.tick"]);
            check_highest("motion.gaussian", high_hz, inputs, place)?;
        }
        for Written { filler, span, .. } in &self.switch.fillers {
            if let Method::MinimumVariance(Target::Band(band)) = &filler.method {
                check_highest(&filler.name, band.high_hz, inputs, span.clone())?;
            }
        }
        for part in inputs.specification.iter().flat_map(|specification| &specification.parts) {
            let place = self.places.blame(&["specification", "gyro.tick"]);
            check_highest("specification", part.highest_hz(), inputs, place)?;
        }
        let turned = inputs.motion.acceleration.abs() * inputs.tick_s * MAX_SIDE as f64;
        if turned > MAX_RATE {
            let message =
                format!("motion.acceleration changes the rate by {turned:.3e} arcsec/s in {MAX_SIDE} ticks");
            let names = ["motion.acceleration", "gyro.tick"];
            return self.places.refuse(&names, message, "too large", "accepted: up to 1e9 arcsec/s");
        }
        assert!(inputs.motion.rate.abs() <= MAX_RATE, "a key's limit");
        let sigma = inputs.sigma_arcsec();
        if sigma > MAX_SIGMA {
            let message =
                format!("gyro.tick_noise comes to {sigma:.3e} arcsec per tick of {} s", inputs.tick_s);
            let names = [NOISE_RANDOM_WALK.name, "gyro.tick"];
            return self.places.refuse(&names, message, "too large", "accepted: 0 to 1e6 arcsec per tick");
        }
        Ok(())
    }

    /// Limits of a tone.
    fn check_tone(&self, tone: &Tone, inputs: &Inputs) -> Result<(), Fault> {
        let names = ["motion.frequency", "motion.tones", "gyro.tick"];
        if let Frequency::Band(band) = tone.frequency {
            let names = ["motion.frequency.low", "motion.frequency.high", "motion.frequency", "motion.tones"];
            self.check_order("motion.frequency", band, &names)?;
        }
        let highest = tone.band().high_hz;
        check_highest("motion.frequency", highest, inputs, self.places.blame(&names))?;
        let rate = tone.amplitude.value.scale() * tone.rate_factor(highest);
        if rate > MAX_RATE {
            let message = format!("motion.amplitude comes to {rate:.3e} arcsec/s at {highest} Hz");
            let names = ["motion.amplitude", "motion.frequency", "motion.tones", "motion.suspension"];
            return self.places.refuse(&names, message, "too large", "accepted: 0 to 1e9 arcsec/s");
        }
        Ok(())
    }

    /// Checks that a band has its ends in order.
    fn check_order(&self, key: &str, band: Band, names: &[&str]) -> Result<(), Fault> {
        if band.low_hz > band.high_hz {
            let message = format!("{key}: the band runs from {} Hz down to {} Hz", band.low_hz, band.high_hz);
            return self.places.refuse(names, message, "backwards", "keep the lower end below the upper one");
        }
        Ok(())
    }

    /// The ticks of one filler at this point, after checking their number against the method and the weights.
    fn fill(&self, written: &Written, inputs: &Inputs) -> Result<Fill, Fault> {
        let Written { filler, fit_ticks, extrapolation, span } = written;
        let n = inputs.gap_ticks;
        let fit = fit_ticks.as_ref().unwrap_or(&self.switch.fit_ticks);
        let given = matches!(filler.method, Method::Weights { .. });
        let resolved = |list: &TickList| if given { list.resolve_in_order(n) } else { list.resolve(n) };
        let fit_ticks = resolved(fit)?;
        let (list, extrapolation_ticks) = match extrapolation {
            Extrapolation::None => (None, None),
            Extrapolation::Common => {
                let common = &self.switch.extrapolation_ticks;
                (Some(common), Some(resolved(common)?))
            }
            Extrapolation::Own(list) => (Some(list), Some(resolved(list)?)),
            Extrapolation::OfFit => {
                let before: Vec<i32> = fit_ticks.iter().copied().filter(|tick| *tick <= 0).collect();
                (Some(fit), Some(before))
            }
        };
        for (list, ticks) in [(Some(fit), Some(&fit_ticks)), (list, extrapolation_ticks.as_ref())] {
            let (Some(list), Some(ticks)) = (list, ticks) else { continue };
            let (needed, found, name) = (filler.least_ticks(), ticks.len(), &filler.name);
            if found < needed {
                let plural = if needed == 1 { "" } else { "s" };
                let message = format!(
                    "the fit is singular: {name} needs {needed} tick{plural}, {} has {found}",
                    list.purpose
                );
                let help = format!("list at least {needed} tick{plural}, or leave out the filler \"{name}\"");
                return Err(Fault::new(list.span.clone(), message, "too few ticks", help));
            }
        }
        if let Method::Weights { residual, extrapolation } = &filler.method {
            check_weights("weights", residual, &fit_ticks, n, span)?;
            if let (Some(weights), Some(ticks)) = (extrapolation, &extrapolation_ticks) {
                check_weights("extrapolation_weights", weights, ticks, n, span)?;
            }
        }
        Ok(Fill { fit_ticks, extrapolation_ticks })
    }
}

/// Refuses a frequency at `place` that is too far above the tick rate.
fn check_highest(name: &str, high_hz: f64, inputs: &Inputs, place: Range<usize>) -> Result<(), Fault> {
    let tick_s = inputs.tick_s;
    if high_hz * tick_s <= MAX_TICK_RATES {
        return Ok(());
    }
    let [rate, most] = [1.0, MAX_TICK_RATES].map(|rates| significant(rates / tick_s, 6));
    let message =
        format!("{name} = {high_hz} Hz is too fast for a tick rate of {rate} Hz (gyro.tick = {tick_s} s)");
    let help = format!("accepted: up to {MAX_TICK_RATES} times the tick rate, {most} Hz here");
    Err(Fault::new(place, message, "too fast for the ticks", help))
}

/// Largest difference between the sum of given weights and n that counts as rounding.
const SUM_TOLERANCE: f64 = 1e-6;

/// Checks that there is one weight for each tick and that the weights sum to n.
fn check_weights(
    key: &str,
    weights: &[f64],
    ticks: &[i32],
    n: u32,
    span: &Range<usize>,
) -> Result<(), Fault> {
    let at = format!("(at gap_ticks = {n})");
    if weights.len() != ticks.len() {
        let message = format!("{} {key} stand for {} ticks {ticks:?} {at}", weights.len(), ticks.len());
        let help = "write a weight for each tick";
        return Err(Fault::new(span.clone(), message, "not one for each tick", help));
    }
    let sum: f64 = weights.iter().sum();
    if (sum - f64::from(n)).abs() > SUM_TOLERANCE {
        let short = significant(sum - f64::from(n), 6);
        let message = format!("the {key} sum to {}, not to n = {n} {at}", significant(sum, 9));
        let help = format!(
            "a constant rate Ω would leave an error of {short}·Ω·T at every switch: scale the weights to sum to {n}"
        );
        return Err(Fault::new(span.clone(), message, "a biased filler", help));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Tone;

    #[test]
    fn derived_quantities_follow_the_theory() {
        let mut inputs = Inputs {
            tick_s: 0.005,
            tick_noise: TickNoise::AngleRandomWalk(2.0),
            readout_lsb: 0.0,
            relock: vec![],
            motion: Motion::of_tone(Tone::of_angle(90.0, 20.0)),
            specification: None,
            gap_ticks: 3,
        };
        assert!((inputs.sigma_arcsec() - 0.141_421_356).abs() < 1e-9);
        assert!((inputs.motion.single_tone().unwrap().0 - 11_309.733_553).abs() < 1e-6);
        assert!((inputs.dt_nu().unwrap() - 0.2).abs() < 1e-15);
        inputs.tick_noise = TickNoise::from_three_sigma(1.6);
        inputs.motion = Motion::of_tone(Tone::of_rate(12000.0, 20.0));
        assert_eq!(
            (inputs.sigma_arcsec(), inputs.motion.single_tone()),
            (0.533_333_333_333, Some((12000.0, 20.0)))
        );
    }
}
