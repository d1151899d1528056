//! Points of a gap-fill study: every combination of swept values, each checked as a whole.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::filler::read::{Extrapolation, Written};
use crate::filler::{Fill, Method, Target, TickList};
use crate::key::document::Places;
use crate::key::sweep::{self, Sweep, Swept};
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::keys::{NOISE_RANDOM_WALK, SETTINGS};
use crate::motion::keys::Design;
use crate::motion::{self, Frequency, Gaussian, Profile, Tone};
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::Fault;
use sagnac_kernel::gap_fill::shape::MAX_SIDE;
use sagnac_theory::minimum_variance::Band;
use sagnac_theory::rows::sides;

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
    pub swept: Vec<(&'static str, Swept)>,
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

/// The inputs common to all points, with their places in the text.
pub(crate) struct Base<'a> {
    pub(crate) inputs: Inputs,
    pub(crate) places: &'a Places,
    pub(crate) sweeps: &'a [Sweep],
    pub(crate) fillers: &'a [Written],
    pub(crate) fit_ticks: TickList,
    pub(crate) extrapolation_ticks: TickList,
}

impl Base<'_> {
    /// All points, in order.
    ///
    /// # Errors
    /// The first point that is invalid.
    pub(crate) fn points(&self) -> Result<Vec<Point>, Fault> {
        let mut fills = HashMap::new();
        sweep::points(self.sweeps).map(|swept| self.point(swept, &mut fills)).collect()
    }

    /// A point; `known` are the ticks of the fillers for each length of the gap so far.
    fn point(
        &self,
        swept: Vec<(&'static str, Swept)>,
        known: &mut HashMap<u32, Arc<[Fill]>>,
    ) -> Result<Point, Fault> {
        let mut inputs = self.inputs.clone();
        sweep::set(&mut inputs, &SETTINGS, &swept);
        sweep::set(&mut inputs.motion, &motion::keys::SETTINGS, &swept);
        if let Some(mut vibration) = inputs.motion.vibration.clone() {
            vibration.suspension = motion::KEYS.swept(&swept).unwrap_or(vibration.suspension);
            vibration.check(inputs.tick_s, MAX_TICK_RATES, self.places)?;
            vibration.add_to(&mut inputs.motion);
            inputs.motion.vibration = Some(vibration);
        }
        self.check(&inputs)?;
        let fills = match known.get(&inputs.gap_ticks) {
            Some(fills) => fills.clone(),
            None => {
                let fills = self.fillers.iter().map(|written| self.fill(written, &inputs));
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
        for Written { filler, span, .. } in self.fillers {
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
        let fit = fit_ticks.as_ref().unwrap_or(&self.fit_ticks);
        let given = matches!(filler.method, Method::Weights { .. });
        let resolved = |list: &TickList| if given { list.resolve_in_order(n) } else { list.resolve(n) };
        let fit_ticks = resolved(fit)?;
        let (list, extrapolation_ticks) = match extrapolation {
            Extrapolation::None => (None, None),
            Extrapolation::Common => {
                (Some(&self.extrapolation_ticks), Some(resolved(&self.extrapolation_ticks)?))
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
