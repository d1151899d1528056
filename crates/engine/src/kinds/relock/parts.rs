//! The parts of the angle that a relock leaves.

use crate::kinds::relock::Relock;
use crate::study::Part;

/// All parts. Without its nominal initial detuning, a loop starts from the errors of the initial detuning alone; without these there is nothing to
/// relock, and the initial detuning stays.
pub(crate) static PARTS: [Part<Relock>; 8] = [
    Part {
        name: "initial detuning",
        off: |relock| {
            if [relock.half_wave_error, relock.dac_step, relock.hysteresis].iter().any(|error| *error != 0.0)
            {
                relock.miss = 0.0;
            }
        },
    },
    Part { name: "error of U_λ/2", off: |relock| relock.half_wave_error = 0.0 },
    Part { name: "step of the DAC", off: |relock| relock.dac_step = 0.0 },
    Part { name: "hysteresis", off: |relock| relock.hysteresis = 0.0 },
    Part { name: "error of f0", off: |relock| relock.temperature_error = 0.0 },
    Part { name: "noise of the detuning", off: |relock| relock.adc_noise = 0.0 },
    Part { name: "step of the ADC", off: |relock| relock.adc_step = 0.0 },
    Part { name: "step of the count", off: |relock| relock.count_step = 0.0 },
];
