//! Named relocks that cover every distinction made by the kernel.

use crate::device::Workload;
use crate::key::Streams;
use crate::kinds::relock::lower::LoweredRelock;
use crate::kinds::relock::{Compensation, FirstHalf, Relock, RelockInputs, RelockPoint};
use sagnac_kernel::launch::Launch;

/// A relock like the paper's, with every kind of error.
pub fn relock() -> RelockInputs {
    let relock = Relock {
        miss: 0.05,
        half_wave_error: 0.005,
        dac_step: 0.002,
        hysteresis: 0.004,
        loop_s: 0.012,
        bias_frequency_hz: 80_000.0,
        pulse_weight_arcsec: 2.6,
        curvature: 40.0,
        temperature_error: 0.0002,
        adc_noise: 0.0002,
        adc_step: 0.0005,
        count_step: 1.0,
        ticks: 4,
        ..Relock::default()
    };
    RelockInputs { tick_s: 0.005, relock }
}

/// The launches that sample the ticks of a relock with one compensation.
pub fn launches_of(inputs: &RelockInputs, compensation: Compensation) -> Vec<Launch> {
    let point = RelockPoint { swept: vec![], inputs: inputs.clone() };
    let lowered = LoweredRelock::new(&point, 1, Streams::Independent)
        .unwrap_or_else(|error| panic!("a relock does not lower: {error}"));
    lowered.launched(compensation).iter().map(|estimates| lowered.launch(estimates)).collect()
}

/// The loads on which the kernel is checked.
pub fn loads() -> Vec<Workload> {
    Workload::of_launches(launches(), &["by-frequency", "by-detuning"])
}

fn launches() -> Vec<(&'static str, Launch)> {
    let of = |(name, compensation, inputs): (_, _, RelockInputs)| {
        launches_of(&inputs, compensation).into_iter().map(move |launch| (name, launch))
    };
    named_relocks().into_iter().flat_map(of).collect()
}

/// Relocks that cover every distinction made by the kernel, each with the compensation to sample.
pub fn named_relocks() -> Vec<(&'static str, Compensation, RelockInputs)> {
    let mut all = Vec::new();
    let mut add = |name, compensation, change: &dyn Fn(&mut Relock)| {
        let mut inputs = relock();
        change(&mut inputs.relock);
        all.push((name, compensation, inputs));
    };
    add("uncompensated", Compensation::None, &|_| {});
    add("by-frequency", Compensation::Frequency, &|_| {});
    add("by-detuning", Compensation::Detuning, &|_| {});
    add("positive-half-first", Compensation::Detuning, &|relock| relock.first_half = FirstHalf::Positive);
    add("one-tick", Compensation::Detuning, &|relock| relock.ticks = 1);
    add("eight-ticks-by-frequency", Compensation::Frequency, &|relock| relock.ticks = 8);
    add("eight-ticks-by-detuning", Compensation::Detuning, &|relock| {
        (relock.ticks, relock.adc_step) = (8, 0.0);
    });
    add("without-counts", Compensation::Frequency, &|relock| {
        (relock.count_step, relock.temperature_error) = (0.0, 0.0);
    });
    // Noise so large that signs and decays are wrong in many trials.
    add("lost-in-noise-by-frequency", Compensation::Frequency, &|relock| {
        (relock.miss, relock.half_wave_error, relock.temperature_error) = (0.0, 0.01, 0.01);
    });
    add("lost-in-noise-by-detuning", Compensation::Detuning, &|relock| {
        (relock.miss, relock.adc_noise, relock.adc_step) = (0.0, 0.01, 0.02);
    });
    all
}
