//! Mode switches in simulated records: the samples that are lost after each, the apparent rotation in those that follow while the
//! path-length control loop closes, and the drift that reverses its sign with the mode.
//!
//! A switch is at the end of every M-th sample, and each but the first M samples begin with a gap. A record is one motion, which goes
//! on through its gaps, so that its phase at the switches advances from one to the next.

use sagnac_engine::drift::Drift;
use sagnac_engine::key::Unrepresentable;
use sagnac_engine::kinds::gap_fill::inputs::Inputs;
use sagnac_engine::kinds::relock::lower::{FixedRelock, method};
use sagnac_engine::kinds::switched_run::{FirstMode, Point, Relocking};
use sagnac_engine::motion::record::{MOTION_BITS, Samples};
use sagnac_kernel::normal::{SIGMA, normal};
use sagnac_kernel::philox::{Address, Purpose};
use sagnac_kernel::relock_ticks::{Given, Parameters, Shape, relock_ticks};
use sagnac_kernel::word::Scalar;

/// Fractional bits of the relative error of f0 in a relock.
const WRONG_BITS: i32 = 30;

/// The mode switches of a gyro.
#[derive(Debug)]
pub(crate) struct Switches {
    /// Samples from one switch to the next.
    pub(crate) interval: u64,
    /// Samples that are lost after each.
    pub(crate) lost: u64,
    relock: Relock,
    /// The drift, and its sign in the first interval.
    drift: Option<(Drift, FirstMode)>,
}

/// The angles that a switch adds to the samples after its gap.
#[derive(Debug)]
enum Relock {
    /// They are the same after each switch, ″.
    Given(Vec<f64>),
    /// They are those of a loop, less their compensation.
    Loop(Box<FixedRelock>, Shape),
}

impl Switches {
    /// The switches of a gap-fill study, `interval` samples apart.
    pub(crate) fn of_gap_fill(inputs: &Inputs, interval: u64) -> Switches {
        let lost = inputs.gap_ticks.into();
        Switches { interval, lost, relock: Relock::Given(inputs.relock.clone()), drift: None }
    }

    /// The switches of a run, whose point has the `inputs` of a gyro.
    ///
    /// # Errors
    /// The relock cannot be represented.
    pub(crate) fn of_run(
        point: &Point,
        inputs: &Inputs,
        first_mode: FirstMode,
    ) -> Result<Switches, Unrepresentable> {
        let interval = libm::round(point.schedule.interval_s / inputs.tick_s) as u64;
        let mut switches = Switches::of_gap_fill(inputs, interval);
        switches.drift = Some((point.drift.clone(), first_mode));
        if let Some(Relocking { relock, compensation }) = &point.relock {
            let shape = Shape { ticks: relock.ticks as usize, method: method(*compensation) };
            switches.relock = Relock::Loop(Box::new(FixedRelock::new(relock, inputs.tick_s)?), shape);
        }
        Ok(switches)
    }

    /// Fewest samples between switches with which each gap is followed by all samples of its relock.
    pub(crate) fn least_interval(&self) -> u64 {
        let relocking = match &self.relock {
            Relock::Given(angles) => angles.len(),
            Relock::Loop(_, shape) => shape.ticks,
        };
        self.lost + (relocking as u64).max(1)
    }

    /// Whether a sample lies in a gap.
    pub(crate) fn is_lost(&self, sample: u64) -> bool {
        sample >= self.interval && sample % self.interval < self.lost
    }

    /// The drift of the gyro with this number in all records, where there is one, ″ and s: its sign in the first interval, and its parts,
    /// which have no spread.
    pub(crate) fn drawn(&self, key: [u32; 2], number: u64) -> Option<(f64, Drift)> {
        let (drift, first_mode) = self.drift.as_ref()?;
        let address = Address::new(key, number);
        let [magnetic, initial, non_magnetic, mode] = address.draw(Purpose::RunDeviation, 0);
        let [warm_up, ..] = address.draw(Purpose::RunDeviation, 1);
        let is_negative = match first_mode {
            FirstMode::Positive => false,
            FirstMode::Negative => true,
            FirstMode::Random => mode.0.cast_signed() < 0,
        };
        let drawn = Drift {
            magnetic: drift.magnetic + drift.magnetic_spread * deviation(magnetic),
            initial_magnetic: drift.initial_magnetic + drift.initial_magnetic_spread * deviation(initial),
            non_magnetic: drift.non_magnetic + drift.non_magnetic_spread * deviation(non_magnetic),
            warm_up_s: drift.warm_up_s * libm::exp(drift.warm_up_spread * deviation(warm_up)),
            ..Drift::default()
        };
        Some((if is_negative { -1.0 } else { 1.0 }, drawn))
    }

    /// The angles that drift and relock add to the samples of the gyro with this number in all records, in 2^−[`MOTION_BITS`] of the unit
    /// of the noise.
    pub(crate) fn angles(&self, samples: Samples, number: u64) -> impl Iterator<Item = i128> {
        let Samples { sample_s, count, lsb_arcsec, key } = samples;
        let unit = libm::ldexp(lsb_arcsec, -(MOTION_BITS as i32));
        let units = move |arcsec: f64| libm::round(arcsec / unit) as i128;
        let interval_s = self.interval as f64 * sample_s;
        let drift = self.drawn(key, number);
        // Differences of rounded angles do not add up their roundings.
        let drifted = move |boundary: u64| {
            let time_s = boundary as f64 * sample_s;
            let angle = |(sign, drift): &(f64, Drift)| {
                sign * drift.magnetic_drift().signed_integral(interval_s, time_s)
                    + drift.non_magnetic * time_s
            };
            drift.as_ref().map_or(0, |drift| units(angle(drift)))
        };
        let mut before = drifted(0);
        let address = Address::new(key, number);
        let mut relocking = vec![];
        (0..count).map(move |sample| {
            let now = drifted(sample + 1);
            let turned = now - std::mem::replace(&mut before, now);
            let (switch, place) = (sample / self.interval, sample % self.interval);
            if switch == 0 || place < self.lost {
                return turned;
            }
            if place == self.lost {
                relocking = self.relocking(&address, switch as usize - 1).into_iter().map(units).collect();
            }
            turned + relocking.get((place - self.lost) as usize).copied().unwrap_or_default()
        })
    }

    /// The angles of the samples after the gap of a switch, ″; switches are counted from 0, as in runs.
    fn relocking(&self, address: &Address<Scalar>, switch: usize) -> Vec<f64> {
        match &self.relock {
            Relock::Given(angles) => angles.clone(),
            Relock::Loop(fixed, shape) => {
                let words = fixed.words(*shape);
                let given = Given { p: Parameters::new(&words, *shape), shape: *shape };
                let [.., wrong] = address.draw(Purpose::Relock, 0);
                let wrong = libm::round(libm::ldexp(fixed.wrong() * deviation(wrong), WRONG_BITS)) as i32;
                let angles = relock_ticks(&given, address, switch, Scalar(wrong.cast_unsigned()));
                let arcsec = |angle: Scalar| f64::from(angle.0.cast_signed()) * fixed.lsb_arcsec;
                angles.into_iter().take(shape.ticks).map(arcsec).collect()
            }
        }
    }
}

/// A standard normal number.
fn deviation(word: Scalar) -> f64 {
    f64::from(normal(word).0.cast_signed()) / f64::from(SIGMA)
}
