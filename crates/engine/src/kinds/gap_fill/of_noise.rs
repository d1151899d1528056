//! The noise of a gap-fill study from `[noise]`: the parts that matter over a gap, and those that do not.

use crate::filler::read::GAP_TICKS;
use crate::key::row::Reading;
use crate::key::sweep::Sweep;
use crate::kinds::TICK;
use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
use crate::kinds::gap_fill::keys::{GYRO, READOUT_LSB, TICK_NOISE};
use crate::noise::{self, NOISE, Noise};
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::units::round_12;
use sagnac_base::source::diagnose::{Fault, Wrong};
use sagnac_theory::allan::terms::Term;

/// The noise of `[noise]`, where the study has it instead of `gyro.tick_noise`.
pub(crate) fn read(reading: &mut Reading) -> Result<Option<Noise>, Wrong> {
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
