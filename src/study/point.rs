//! Points: every combination of swept values, each checked as a whole.

use super::diagnose::Fault;
use super::file::Filler;
use super::inputs::Inputs;
use super::key::{AMPLITUDE, FREQUENCY, Key, NOISE_RANDOM_WALK, TICK};
use super::place::Places;
use super::sweep::Sweep;
use super::ticks::TickList;
use super::units::Quantity;
use crate::table::significant;

/// Highest vibration frequency, in tick rates; above it the gyro sees nothing of the vibration but aliases.
const MOST_TICK_RATES: f64 = 10.0;
/// Highest amplitude of the rate, ″/s.
const MOST_RATE: f64 = 1e9;
/// Highest σ of one tick, ″.
const MOST_SIGMA: f64 = 1e6;

/// One combination of swept values, with all that follows from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Place in the order of points; the first sweep changes slowest.
    pub index: usize,
    /// Name of each swept key, and its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, Quantity)>,
    pub inputs: Inputs,
    /// Ticks that the residual is fitted to, ascending.
    pub fit_ticks: Vec<i32>,
    /// Ticks that the extrapolation is fitted to, ascending.
    pub extrapolation_ticks: Vec<i32>,
}

/// What all points share, with the places to blame.
pub(super) struct Base<'a> {
    pub(super) inputs: Inputs,
    pub(super) places: &'a Places,
    pub(super) sweeps: &'a [Sweep],
    pub(super) fillers: &'a [Filler],
    pub(super) fit_ticks: TickList,
    pub(super) extrapolation_ticks: TickList,
}

impl Base<'_> {
    /// All points, in order.
    ///
    /// # Errors
    /// The first point that makes no sense.
    pub(super) fn points(&self) -> Result<Vec<Point>, Fault> {
        let count = self.sweeps.iter().map(|sweep| sweep.values.len()).product();
        (0..count).map(|index| self.point(index)).collect()
    }

    fn point(&self, index: usize) -> Result<Point, Fault> {
        let mut inputs = self.inputs;
        let mut swept = Vec::with_capacity(self.sweeps.len());
        let mut rest = index;
        for sweep in self.sweeps.iter().rev() {
            let value = sweep.values[rest % sweep.values.len()];
            rest /= sweep.values.len();
            sweep.key.set(&mut inputs, value);
            swept.push((sweep.key.name, value));
        }
        swept.reverse();
        self.check(&inputs)?;
        let fit_ticks = self.ticks(&self.fit_ticks, &inputs)?;
        let extrapolation_ticks = self.ticks(&self.extrapolation_ticks, &inputs)?;
        Ok(Point { index, swept, inputs, fit_ticks, extrapolation_ticks })
    }

    /// Limits that need more than one value.
    fn check(&self, inputs: &Inputs) -> Result<(), Fault> {
        let Inputs { tick_s, frequency_hz, .. } = *inputs;
        let refuse = |keys: &[&'static Key], message, label, accepted: &str| {
            let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
            let place = self.places.blame(self.sweeps, &names);
            Err(Fault::new(place, message, label, format!("accepted: {accepted}")))
        };
        if frequency_hz * tick_s > MOST_TICK_RATES {
            let tick_rate = significant(1.0 / tick_s, 6);
            let message = format!(
                "motion.frequency = {frequency_hz} Hz is absurd at a tick rate of {tick_rate} Hz \
                 (gyro.tick = {tick_s} s)"
            );
            let highest = significant(MOST_TICK_RATES / tick_s, 6);
            let accepted = format!("up to {MOST_TICK_RATES} times the tick rate, {highest} Hz here");
            return refuse(&[&FREQUENCY, &TICK], message, "too fast for the ticks", &accepted);
        }
        let rate = inputs.rate_amplitude();
        if rate > MOST_RATE {
            let message = format!("motion.amplitude comes to {rate:.3e} arcsec/s at {frequency_hz} Hz");
            return refuse(&[&AMPLITUDE, &FREQUENCY], message, "too large", "0 to 1e9 arcsec/s");
        }
        let sigma = inputs.sigma_arcsec();
        if sigma > MOST_SIGMA {
            let message = format!("gyro.tick_noise comes to {sigma:.3e} arcsec per tick of {tick_s} s");
            return refuse(&[&NOISE_RANDOM_WALK, &TICK], message, "too large", "0 to 1e6 arcsec per tick");
        }
        Ok(())
    }

    /// The ticks of `list` at this point, enough of them for every filler.
    fn ticks(&self, list: &TickList, inputs: &Inputs) -> Result<Vec<i32>, Fault> {
        let ticks = list.resolve(inputs.gap_ticks)?;
        let Some(filler) = self.fillers.iter().find(|filler| filler.order() >= ticks.len()) else {
            return Ok(ticks);
        };
        let (name, needed, found) = (filler.name(), filler.order() + 1, ticks.len());
        let plural = if needed == 1 { "" } else { "s" };
        let message =
            format!("the fit is singular: {name} needs {needed} tick{plural}, {} has {found}", list.purpose);
        let help = format!("list at least {needed} tick{plural}, or leave out the filler \"{name}\"");
        Err(Fault::new(list.span.clone(), message, "too few ticks", help))
    }
}
