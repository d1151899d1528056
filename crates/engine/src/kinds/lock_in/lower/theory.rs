//! Closed forms of a gyro with lock-in, where their premises hold.

use crate::kinds::lock_in::{Inputs, Point, Readout};
use sagnac_theory::lock_in::{LockIn, Premise, mean_rate};

/// A zone of dynamic lock-in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Zone {
    /// Its number k.
    pub(crate) number: i32,
    /// Its centre, ″/s.
    pub(crate) centre: f64,
    /// Its half width without noise of the dither, ″/s.
    pub(crate) half_width: f64,
}

/// Largest number of a zone whose width is computed.
const MAX_ZONES: f64 = 1e6;

impl Zone {
    /// The zone whose centre is nearest to `rate`, ″/s; none without dither.
    pub(crate) fn nearest(inputs: &Inputs, rate: f64) -> Option<Zone> {
        let gyro = inputs.gyro()?;
        let number = libm::round(rate / gyro.zone_centre(1));
        if libm::fabs(number) > MAX_ZONES {
            return None;
        }
        let number = number as i32;
        Some(Zone { number, centre: gyro.zone_centre(number), half_width: gyro.zone_half_width(number) })
    }
}

/// Why the angle random walk has no closed form at a point; empty where it has one, `None` without dither.
pub(crate) fn failing(point: &Point) -> Option<Vec<Premise>> {
    let (inputs, gyro) = (&point.inputs, point.inputs.gyro()?);
    let spread = inputs.dither.as_ref()?.spread(point.times.length_s());
    Some(gyro.failing_premises(spread, inputs.rate))
}

/// The angle random walk from lock-in and the noise of the beam, ″/√s.
pub(crate) fn angle_random_walk(point: &Point) -> Option<f64> {
    let holds = failing(point)?.is_empty() && is_plain(&point.inputs);
    let of_lock_in = point.inputs.gyro().as_ref().map(LockIn::angle_random_walk)?;
    holds.then(|| libm::hypot(of_lock_in, point.inputs.beam_noise))
}

/// The mean output rate, ″/s: without dither, and in a zone that no noise breaks up.
pub(crate) fn mean_output(point: &Point) -> Option<f64> {
    let inputs = &point.inputs;
    if inputs.ramp != 0.0 || inputs.beam_noise > 0.0 || inputs.motion.is_some() {
        return None;
    }
    let Some(dither) = &inputs.dither else { return Some(mean_rate(inputs.rate, inputs.threshold)) };
    let is_quiet = dither.spread(point.times.length_s()) == 0.0 && dither.phase_noise == 0.0;
    let zone = Zone::nearest(inputs, inputs.rate)?;
    // Half widths are of first order in Ω_L; the second order shifts the edges.
    let shift = inputs.threshold * inputs.threshold / (2.0 * inputs.gyro()?.zone_centre(1));
    let inside = libm::fabs(inputs.rate - zone.centre) + shift < INSIDE * zone.half_width;
    (is_quiet && inside).then_some(zone.centre)
}

/// Part of a zone's half width in which a gyro locks within a record.
const INSIDE: f64 = 0.9;

/// Whether the angle that is put out is the one of the closed form.
fn is_plain(inputs: &Inputs) -> bool {
    inputs.readout() == Readout::Stripped && inputs.ramp == 0.0 && inputs.motion.is_none()
}
