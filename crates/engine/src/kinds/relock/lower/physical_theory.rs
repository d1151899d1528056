//! Mean and rms of the angle left from the physical inputs: theory that shares no computation with the kernel.
//!
//! The angle that a miss Δλ0 leaves in some ticks is C·Δλ0². Z(11) over tick i is C_i = 2χ f0 τ_L q^{2i−1} sinh²(T/2τ_L), and
//! over the first m ticks it is ½χ f0 τ_L tanh(T/2τ_L)(1 − q^{2m}), with q = e^{−T/τ_L} and f0 in ″/s. Units, words and the
//! bias lost in half-ticks, of which lowering makes the angles, do not occur.

use crate::kinds::relock::RelockInputs;
use crate::kinds::relock::inputs::{Compensation, FirstHalf, Relock};

/// Mean and rms of the angle left in a tick, or in all ticks, ″; `None` where they have no closed form.
pub(crate) fn left(
    inputs: &RelockInputs,
    compensation: Compensation,
    tick: Option<u32>,
) -> Option<(f64, f64)> {
    let relock = &inputs.relock;
    let scale = angle_of_one(inputs, tick);
    let [second, fourth] = moments_of_miss(relock);
    let (mean, rms) = (scale * second, scale.abs() * libm::sqrt(fourth));
    match (compensation, tick) {
        (Compensation::None, _) | (Compensation::Frequency, Some(1)) => Some((mean, rms)),
        (Compensation::Detuning, _) if relock.adc_noise == 0.0 && relock.adc_step == 0.0 => {
            Some((0.0, rms * relock.temperature_error))
        }
        _ => None,
    }
}

/// C, the angle left of a miss of one wavelength, ″.
fn angle_of_one(inputs: &RelockInputs, tick: Option<u32>) -> f64 {
    let RelockInputs { tick_s, relock } = inputs;
    let ratio = tick_s / relock.loop_s;
    let of_loop = match tick {
        Some(tick) => {
            let half = libm::sinh(0.5 * ratio);
            2.0 * libm::exp(-f64::from(2 * tick - 1) * ratio) * half * half
        }
        None => 0.5 * libm::tanh(0.5 * ratio) * -libm::expm1(-f64::from(2 * relock.ticks) * ratio),
    };
    let sign = if relock.first_half == FirstHalf::Negative { 1.0 } else { -1.0 };
    let bias_arcsec_per_s = relock.pulse_weight_arcsec * relock.bias_frequency_hz;
    sign * relock.curvature * bias_arcsec_per_s * relock.loop_s * of_loop
}

/// ⟨Δλ0²⟩ and ⟨Δλ0⁴⟩.
fn moments_of_miss(relock: &Relock) -> [f64; 2] {
    let square = |x: f64| x * x;
    let normal = square(relock.half_wave_error);
    // An error that is uniform to either side of 0.
    let uniform = |half: f64| [square(half) / 3.0, square(square(half)) / 5.0];
    // An independent error without a mean is added to others.
    let with = |[s, f]: [f64; 2], [second, fourth]: [f64; 2]| [s + second, f + 6.0 * s * second + fourth];
    let errors = [uniform(0.5 * relock.dac_step), uniform(relock.hysteresis)];
    let errors = errors.into_iter().fold([normal, 3.0 * normal * normal], with);
    let miss = square(relock.miss);
    with([miss, miss * miss], errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::relock::verify;

    /// The bias has opposite signs in the halves of a tick.
    #[test]
    fn the_angle_is_the_integral_of_the_bias_that_is_lost() {
        for loop_s in [0.0025, 0.012, 0.2] {
            let mut inputs = verify::relock();
            inputs.relock.loop_s = loop_s;
            let Relock { bias_frequency_hz, pulse_weight_arcsec, curvature, ticks, .. } = inputs.relock;
            let steps = 4000;
            let of = |tick: u32| {
                let at = |k: u32| {
                    let part = (f64::from(k) + 0.5) / f64::from(steps);
                    let detuning = libm::exp(-(f64::from(tick - 1) + part) * inputs.tick_s / loop_s);
                    let sign = if part < 0.5 { 1.0 } else { -1.0 };
                    sign * curvature * detuning * detuning
                };
                let mean = (0..steps).map(at).sum::<f64>() / f64::from(steps);
                bias_frequency_hz * pulse_weight_arcsec * inputs.tick_s * mean
            };
            let mut sum = 0.0;
            for tick in 1..=ticks {
                let (found, expected) = (angle_of_one(&inputs, Some(tick)), of(tick));
                sum += expected;
                assert!(
                    (found / expected - 1.0).abs() < 1e-5,
                    "{loop_s} s, tick {tick}: {found}, {expected}"
                );
            }
            let found = angle_of_one(&inputs, None);
            assert!((found / sum - 1.0).abs() < 1e-5, "{loop_s} s: {found}, not {sum}");
        }
    }
}
