//! The inputs of a gyro with lock-in, and their keys.

use crate::key::row::{Holds, keys, measure, words};
use crate::key::sweep::Setting;
use crate::motion::Motion;
use sagnac_base::quantity::units::Dimension;
use sagnac_theory::lock_in::LockIn;

words! {
    /// The angle that is put out.
    pub enum Readout {
        /// Read at whole periods of the dither, whose angle is zero there.
        Stripped = "stripped",
        /// Read at any time, with the angle of the dither.
        Dithered = "dithered",
        /// Read at any time, less the nominal angle of the dither: what its noise adds remains.
        Demodulated = "demodulated",
    }
}

/// A gyro with lock-in, in ″ and s. Every number has 12 significant digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Angle q of a pulse, ″.
    pub scale_factor: f64,
    /// Lock-in threshold Ω_L, ″/s.
    pub threshold: f64,
    /// Angle random walk of the beam's phase, ″/√s.
    pub beam_noise: f64,
    /// Factor on the number of steps.
    pub refinement: f64,
    /// The dither, if there is one.
    pub dither: Option<Dither>,
    /// Input rate at the start, ″/s.
    pub rate: f64,
    /// Its change, ″/s².
    pub ramp: f64,
    /// Motion in addition, the same in every gyro.
    pub motion: Option<Motion>,
    /// Time from one sample to the next, s; chosen where absent.
    pub sample_s: Option<f64>,
    /// Requested length, s; a record has the nearest whole number of samples.
    pub length_s: f64,
}

/// A torsional oscillation of the block. Noise is that of each half-cycle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dither {
    /// Frequency f_d, Hz.
    pub frequency_hz: f64,
    /// Amplitude Ω_D of the rate, ″/s.
    pub rate: f64,
    /// Standard deviation of the amplitude, as a part of it.
    pub amplitude_noise: f64,
    /// Standard deviation of the step of the amplitude's random walk, as a part of the amplitude.
    pub amplitude_walk: f64,
    /// Standard deviation of the phase at the reversal, ″.
    pub phase_noise: f64,
    /// The angle that is put out.
    pub readout: Readout,
}

impl Dither {
    /// Standard deviation of the amplitude in the middle of a record, as a part of it.
    pub fn spread(&self, length_s: f64) -> f64 {
        let walked = self.amplitude_walk * libm::sqrt(self.frequency_hz * length_s);
        libm::hypot(self.amplitude_noise, walked)
    }
}

impl Inputs {
    /// The gyro of the closed forms; absent without dither.
    pub fn gyro(&self) -> Option<LockIn> {
        let dither = self.dither.as_ref()?;
        Some(LockIn {
            threshold: self.threshold,
            scale_factor: self.scale_factor,
            dither_rate: dither.rate,
            dither_frequency: dither.frequency_hz,
        })
    }

    /// The angle that is put out.
    pub fn readout(&self) -> Readout {
        self.dither.as_ref().map_or(Readout::Stripped, |dither| dither.readout)
    }

    /// Everything that determines the draws and the truth, as lines of text, without the samples. Other steps take the same draws.
    pub(crate) fn canonical(&self) -> String {
        let Inputs { scale_factor, threshold, beam_noise, dither, rate, ramp, .. } = self;
        let of_dither = dither.as_ref().map_or(String::new(), |dither| {
            let Dither { frequency_hz, rate, amplitude_noise, amplitude_walk, phase_noise, readout } = dither;
            format!(
                "dither={frequency_hz:.11e}\ndither_rate={rate:.11e}\namplitude_noise={amplitude_noise:.11e}\n\
                 amplitude_walk={amplitude_walk:.11e}\nphase_noise={phase_noise:.11e}\nreadout={}\n",
                readout.name()
            )
        });
        format!(
            "scale_factor={scale_factor:.11e}\nthreshold={threshold:.11e}\nbeam_noise={beam_noise:.11e}\n\
             rate={rate:.11e}\nramp={ramp:.11e}\n{of_dither}"
        )
    }
}

const SCALES: Holds = measure(&[Dimension::ScaleFactor], 1e-6, 1e6, "1e-6 to 1e6 arcsec/pulse");
const THRESHOLDS: Holds = measure(&[Dimension::Rate], 1e-9, 1e6, "1e-9 to 1e6 arcsec/s");
const WALKS: Holds = measure(&[Dimension::AngleRandomWalk], 0.0, 1e3, "0 to 1e3 deg/sqrt(h)");
const FACTORS: Holds = measure(&[Dimension::Ratio], 0.25, 16.0, "0.25 to 16");
const FREQUENCIES: Holds = measure(&[Dimension::Frequency], 1e-3, 1e6, "0.001 Hz to 1e6 Hz");
const AMPLITUDES: Holds = measure(&[Dimension::Rate], 1e-6, 1e9, "1e-6 to 1e9 arcsec/s");
const PARTS: Holds = measure(&[Dimension::Ratio], 0.0, 0.1, "0 to 0.1, or 0 % to 10 %");
const PHASES: Holds = measure(&[Dimension::Angle], 0.0, 36_000.0, "0 to 10 deg");
const RATES: Holds = measure(&[Dimension::Rate], -1e9, 1e9, "-1e9 to 1e9 arcsec/s");
const RAMPS: Holds = measure(&[Dimension::AngularAcceleration], -1e9, 1e9, "-1e9 to 1e9 arcsec/s^2");
const TIMES: Holds = measure(&[Dimension::Time], 1e-6, 1e6, "1 µs to 1e6 s");

keys! {
    /// The keys of the gyro, its dither and its input.
    pub(crate) static KEYS;
    /// The gyro.
    GYRO = "gyro", "", Fixed, Holds::Table, "[gyro]\nscale_factor = \"2 arcsec/pulse\"";
    /// Scale factor q, the input angle of one period of the beat: "2 arcsec/pulse".
    pub SCALE_FACTOR = "gyro.scale_factor", "scale factor", Choice, SCALES, r#"scale_factor = "2 arcsec/pulse""#, required;
    /// Lock-in of the two beams.
    LOCK_IN = "lock_in", "", Fixed, Holds::Table, "[lock_in]\nthreshold = \"180 arcsec/s\"";
    /// Lock-in threshold Ω_L, the largest rate that a gyro without dither does not see: "180 arcsec/s".
    pub THRESHOLD = "lock_in.threshold", "lock-in threshold", Condition, THRESHOLDS, r#"threshold = "180 arcsec/s""#, required;
    /// White phase noise of the beam, as the angle random walk that it causes without lock-in; 0 if absent.
    BEAM_NOISE = "lock_in.beam_noise", "phase noise of the beam", Choice, WALKS, r#"beam_noise = "0.0002 deg/sqrt(h)""#;
    /// Factor on the number of steps of the integration, to see that the results do not depend on it; 1 if absent.
    pub REFINEMENT = "lock_in.refinement", "factor on the steps", Choice, FACTORS, "refinement = 2";
    /// Dither, a torsional oscillation of the block, which keeps the gyro out of lock-in; none if absent. Its noise is that of each
    /// half-cycle, from one zero crossing of its angle to the next.
    pub DITHER = "dither", "", Fixed, Holds::Table, "[dither]\nfrequency = \"400 Hz\"\nrate = \"100 deg/s\"\namplitude_noise = \"2 %\"";
    /// Dither frequency f_d: "400 Hz".
    pub FREQUENCY = "dither.frequency", "dither frequency", Choice, FREQUENCIES, r#"frequency = "400 Hz""#, required;
    /// Amplitude Ω_D of the dither rate: "100 deg/s".
    pub DITHER_RATE = "dither.rate", "amplitude of the dither rate", Choice, AMPLITUDES, r#"rate = "100 deg/s""#, required;
    /// Randomization: standard deviation of the amplitude, independent in each half-cycle, as a part of the amplitude; 0 if absent.
    pub AMPLITUDE_NOISE = "dither.amplitude_noise", "amplitude noise of the dither", Choice, PARTS, r#"amplitude_noise = "2 %""#;
    /// Standard deviation of the step of the amplitude's random walk from half-cycle to half-cycle, as a part of the amplitude; 0 if
    /// absent.
    AMPLITUDE_WALK = "dither.amplitude_walk", "amplitude walk of the dither", Choice, PARTS, r#"amplitude_walk = "0.01 %""#;
    /// Standard deviation of the dither's phase at each reversal, which leaves the zero crossings where they are; 0 if absent.
    PHASE_NOISE = "dither.phase_noise", "phase noise of the dither", Choice, PHASES, r#"phase_noise = "0.5 deg""#;
    /// The angle that is put out; "stripped" if absent.
    pub READOUT = "dither.readout", "", Fixed, Holds::Word(Readout::WORDS), r#"readout = "stripped""#;
    /// Input rate of the gyro; none if absent.
    INPUT = "input", "", Fixed, Holds::Table, "[input]\nrate = \"37 arcsec/s\"";
    /// Input rate Ω at the start: "37 arcsec/s"; 0 if absent.
    pub RATE = "input.rate", "input rate", Condition, RATES, r#"rate = "37 arcsec/s""#;
    /// Change of the input rate, for a slow passage through a dead band: "1 arcsec/s^2"; 0 if absent.
    pub RAMP = "input.ramp", "ramp of the input rate", Choice, RAMPS, r#"ramp = "1 arcsec/s^2""#;
    /// The record of the angle.
    RECORD = "record", "", Fixed, Holds::Table, "[record]\nlength = \"10 s\"";
    /// Time from one sample of the angle to the next, rounded to whole periods of the dither unless it is left in; one period, or 10 ms
    /// without dither, if absent.
    pub SAMPLE = "record.sample", "sampling time", Choice, TIMES, r#"sample = "5 ms""#;
    /// Length of the record, rounded to whole samples: "10 s".
    pub LENGTH = "record.length", "length of the record", Choice, TIMES, r#"length = "10 s""#, required;
}

/// The settings of these keys. Those of the dither apply where there is one.
pub(crate) static SETTINGS: [Setting<Inputs>; 13] = [
    Setting::new(&SCALE_FACTOR, |inputs, scale| inputs.scale_factor = scale.value),
    Setting::new(&THRESHOLD, |inputs, threshold| inputs.threshold = threshold.value),
    Setting::new(&BEAM_NOISE, |inputs, noise| inputs.beam_noise = noise.value),
    Setting::new(&REFINEMENT, |inputs, factor| inputs.refinement = factor.value),
    Setting::of(&FREQUENCY, is_dithered, |inputs, frequency| {
        with_dither(inputs, |dither| dither.frequency_hz = frequency.value);
    }),
    Setting::of(&DITHER_RATE, is_dithered, |inputs, rate| {
        with_dither(inputs, |dither| dither.rate = rate.value)
    }),
    Setting::of(&AMPLITUDE_NOISE, is_dithered, |inputs, noise| {
        with_dither(inputs, |dither| dither.amplitude_noise = noise.value);
    }),
    Setting::of(&AMPLITUDE_WALK, is_dithered, |inputs, step| {
        with_dither(inputs, |dither| dither.amplitude_walk = step.value);
    }),
    Setting::of(&PHASE_NOISE, is_dithered, |inputs, noise| {
        with_dither(inputs, |dither| dither.phase_noise = noise.value);
    }),
    Setting::new(&RATE, |inputs, rate| inputs.rate = rate.value),
    Setting::new(&RAMP, |inputs, ramp| inputs.ramp = ramp.value),
    Setting::new(&SAMPLE, |inputs, sample| inputs.sample_s = Some(sample.value)),
    Setting::new(&LENGTH, |inputs, length| inputs.length_s = length.value),
];

fn is_dithered(inputs: &Inputs) -> bool {
    inputs.dither.is_some()
}

fn with_dither(inputs: &mut Inputs, set: impl FnOnce(&mut Dither)) {
    if let Some(dither) = &mut inputs.dither {
        set(dither);
    }
}
