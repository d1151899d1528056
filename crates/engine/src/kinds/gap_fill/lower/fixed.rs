//! The sampled quantities of a point in fixed point: the words of the kernel before they are arranged.

use std::sync::Arc;

use crate::kinds::gap_fill::lower::physical::{Physical, PhysicalTone, ToneKind};
use crate::kinds::gap_fill::lower::replayed::Rounded;
use crate::motion::Value;
use crate::motion::keys::Phase;
use sagnac_kernel::normal::SIGMA;
use sagnac_kernel::sine::ONE;
use sagnac_theory::gap::tick_phase;
use sagnac_theory::rows::{TickRows, place, ticks};

/// Units of the kernel's parameters per LSB.
pub(crate) const ANGLE_UNITS: f64 = 4.0;
pub(crate) const SIGMA_UNITS: f64 = 16.0;
pub(crate) const PEAK_UNITS: f64 = 32.0;
/// 2^32, as the angle that is common to all trials has units of 2^−32 LSB.
pub(crate) const CONSTANT_UNITS: f64 = 4_294_967_296.0;

/// Amplitude of a Rayleigh-distributed tone in units of the kernel's sine, because its normal numbers have another
/// unit.
pub(crate) const RAYLEIGH_UNIT: f64 = SIGMA as f64 / ONE as f64;

/// A point in fixed point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fixed {
    pub(crate) lsb_arcsec: f64,
    pub(crate) gap_ticks: i32,
    pub(crate) sigma: u32,
    pub(crate) tones: Vec<FixedTone>,
    /// The rows of the Gaussian motion's ticks in whole numbers, in the order of [`place`], for the requested number of
    /// ticks on either side.
    pub(crate) gaussian: Option<Vec<Vec<i32>>>,
    pub(crate) profile: Option<FixedProfile>,
    /// Constant rate, acceleration and relock, LSB per tick.
    pub(crate) rate: f64,
    pub(crate) acceleration: f64,
    pub(crate) relock: Vec<f64>,
    /// log2 of a pulse in LSB, and the noise over the gap.
    pub(crate) readout: Option<Readout>,
}

/// A tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedTone {
    pub(crate) motion: ToneMotion,
    pub(crate) phase: u32,
    pub(crate) phase_spread: u32,
    /// Least fraction of the amplitude and the width of its range, in 2^−31.
    pub(crate) part: [u32; 2],
    pub(crate) rayleigh: bool,
}

/// The frequency and angle of a tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ToneMotion {
    /// A fixed frequency νT, with the peak angle of a tick, LSB.
    Fixed { amplitude: f64, nu_t: f64 },
    /// A drawn frequency, as the words of the kernel.
    Drawn { peak: u32, low: u32, width: u32, scale: u32, of_angle: bool },
}

/// A recorded profile.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FixedProfile {
    pub(crate) rounded: Arc<Rounded>,
    pub(crate) positions: usize,
    pub(crate) every: bool,
}

/// The readout in whole pulses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Readout {
    pub(crate) bits: u32,
    /// Noise over the whole gap, 2^−4 LSB.
    pub(crate) gap_sigma: u32,
}

impl Fixed {
    /// The words for a given unit of angle; the Gaussian motion covers `sides` ticks on either side.
    pub(crate) fn new(physical: &Physical, lsb_arcsec: f64, sides: usize) -> Fixed {
        let n = physical.gap_ticks as i32;
        let sigma = libm::round(physical.sigma_arcsec / lsb_arcsec * SIGMA_UNITS) as u32;
        let gap_sigma =
            libm::round(physical.sigma_arcsec * libm::sqrt(f64::from(n)) / lsb_arcsec * SIGMA_UNITS) as u32;
        let profile = physical.profile.as_ref().map(|profile| FixedProfile {
            rounded: Rounded::of(&profile.replay, lsb_arcsec),
            positions: profile.positions,
            every: profile.every,
        });
        Fixed {
            lsb_arcsec,
            gap_ticks: n,
            sigma,
            tones: physical.tones.iter().map(|tone| FixedTone::new(tone, lsb_arcsec)).collect(),
            gaussian: physical
                .gaussian
                .as_ref()
                .map(|g| factor(&g.rows, physical.gap_ticks, sides, lsb_arcsec)),
            profile,
            rate: physical.rate_arcsec / lsb_arcsec,
            acceleration: physical.acceleration_arcsec / lsb_arcsec,
            relock: physical.relock.iter().map(|angle| angle / lsb_arcsec).collect(),
            readout: (physical.readout_lsb > 0.0).then(|| Readout {
                bits: libm::round(libm::log2(physical.readout_lsb / lsb_arcsec)) as u32,
                gap_sigma,
            }),
        }
    }

    pub(crate) fn has_amplitudes(&self) -> bool {
        self.tones.iter().any(|tone| tone.rayleigh || tone.part[1] > 0)
    }

    pub(crate) fn has_frequencies(&self) -> bool {
        self.tones.iter().any(|tone| matches!(tone.motion, ToneMotion::Drawn { .. }))
    }

    pub(crate) fn has_constants(&self) -> bool {
        self.rate != 0.0 || self.acceleration != 0.0 || !self.relock.is_empty()
    }

    /// The angle of a tick that is common to all trials, in 2^−32 LSB.
    pub(crate) fn tick_constant(&self, tick: i32) -> i64 {
        if !self.has_constants() {
            return 0;
        }
        let after_gap = usize::try_from(tick - self.gap_ticks - 1).ok();
        let relock = after_gap.and_then(|place| self.relock.get(place)).copied().unwrap_or(0.0);
        let from_middle = f64::from(tick) - 0.5 * (f64::from(self.gap_ticks) + 1.0);
        libm::round((self.rate + self.acceleration * from_middle + relock) * CONSTANT_UNITS) as i64
    }

    /// The same angle over the first `ticks` of the gap.
    pub(crate) fn gap_constant(&self, ticks: i32) -> i64 {
        (1..=ticks).map(|tick| self.tick_constant(tick)).sum()
    }

    /// The words that determine an estimate that reads `ticks`, except its weights.
    pub(crate) fn words(&self, ticks: &[i32]) -> Vec<u32> {
        let n = self.gap_ticks;
        let mut words = vec![n as u32, self.sigma];
        let all = || ticks.iter().copied().chain(1..=n);
        for tone in &self.tones {
            let [low, width] = tone.part;
            words.extend([tone.phase, tone.phase_spread, low, width, tone.rayleigh.into()]);
            match tone.motion {
                ToneMotion::Fixed { .. } => {
                    let parts = all().flat_map(|tick| tone.tick_words(tick, n));
                    words.extend(parts.map(|word| word as u32));
                }
                ToneMotion::Drawn { scale, .. } => {
                    // The words of a frequency without a scale are those of earlier versions, whose trials are kept.
                    let all = tone.drawn_words();
                    words.extend(&all[..if scale == 1 { 4 } else { 5 }]);
                }
            }
        }
        if let Some(factor) = &self.gaussian {
            let rows = all().flat_map(|tick| &factor[gaussian_place(tick, n)]);
            words.extend(rows.map(|&word| word as u32));
        }
        if let Some(profile) = &self.profile {
            words.extend(profile.rounded.content.key());
            words.push(u32::from(profile.every));
        }
        words.extend(all().flat_map(|tick| long_words(self.tick_constant(tick))));
        words.extend(self.readout.iter().flat_map(|readout| [readout.bits, readout.gap_sigma]));
        words
    }
}

impl FixedTone {
    fn new(tone: &PhysicalTone, lsb_arcsec: f64) -> FixedTone {
        let (phase, phase_spread) = match tone.phase {
            Phase::Uniform => (0, u32::MAX),
            Phase::ZeroCrossing => (0, 0),
            Phase::Extremum => (1 << 30, 0),
        };
        let whole = (1_u32 << 31) - 1;
        let part = match tone.value {
            Value::Fixed(_) | Value::Rayleigh(_) => [whole, 0],
            Value::Uniform([low, _]) => {
                let low = libm::round(low * f64::from(whole)) as u32;
                [low, whole - low]
            }
        };
        let rayleigh = matches!(tone.value, Value::Rayleigh(_));
        let scale = if rayleigh { 1.0 / RAYLEIGH_UNIT } else { 1.0 } / lsb_arcsec;
        let motion = match tone.kind {
            ToneKind::Fixed { tick_arcsec, nu_t } => {
                ToneMotion::Fixed { amplitude: tick_arcsec * scale, nu_t }
            }
            ToneKind::Drawn { arcsec, of_angle, nu_t } => {
                // The word of the frequency stays where the polynomial holds: sinc, and a sine without its sign.
                let most = if of_angle { 1.0 } else { 0.5 };
                let mut doublings = 0;
                while nu_t[1] > most * f64::from(1 << doublings) {
                    doublings += 1;
                }
                let word = |nu_t: f64| libm::round(nu_t * libm::exp2(f64::from(31 - doublings))) as u32;
                let half_turns = nu_t.map(word);
                // A_Ω T sinc νT is 2/π A_Ω T times the ratio in the kernel.
                let factor = if of_angle { 1.0 } else { core::f64::consts::FRAC_2_PI };
                ToneMotion::Drawn {
                    peak: libm::round(arcsec * scale * factor * PEAK_UNITS) as u32,
                    low: half_turns[0],
                    width: half_turns[1] - half_turns[0],
                    scale: 1 << doublings,
                    of_angle,
                }
            }
        };
        FixedTone { motion, phase, phase_spread, part, rayleigh }
    }

    /// Whether only the phase of the tone is drawn, or also its amplitude from a Rayleigh distribution.
    pub(crate) fn is_plain(&self) -> bool {
        matches!(self.motion, ToneMotion::Fixed { .. }) && self.part[1] == 0
    }

    /// Whether only the phase of the tone is drawn; its frequency may be that of a band of no width.
    pub(crate) fn is_sine(&self) -> bool {
        let is_drawn = matches!(self.motion, ToneMotion::Drawn { width: 1.., .. });
        !is_drawn && self.part[1] == 0 && !self.rayleigh && self.phase_spread != 0
    }

    /// Peak, least frequency, width of its range, whether the amplitude is that of the angle, and the scale, of a tone of
    /// drawn frequency; there is no tone of fixed frequency beside one.
    pub(crate) fn drawn_words(&self) -> [u32; 5] {
        match self.motion {
            ToneMotion::Fixed { .. } => {
                unreachable!("lowering makes all tones of drawn frequency where one is")
            }
            ToneMotion::Drawn { peak, low, width, scale, of_angle } => {
                [peak, low, width, of_angle.into(), scale]
            }
        }
    }

    /// The angle of a tone of fixed frequency over a tick, at sine 1 and at cosine 1 of the phase at the middle of the
    /// gap.
    pub(crate) fn tick_words(&self, tick: i32, gap_ticks: i32) -> [i32; 2] {
        let ToneMotion::Fixed { amplitude, nu_t } = self.motion else { return [0; 2] };
        let phase = tick_phase(f64::from(tick), gap_ticks as u32, nu_t);
        let word = |part: f64| libm::round(part * amplitude * ANGLE_UNITS) as i32;
        [word(libm::cos(phase)), word(libm::sin(phase))]
    }

    /// The same angles over the first `ticks` of the gap; over the whole gap the parts at cosine 1 cancel.
    pub(crate) fn gap_words(&self, ticks: i32, gap_ticks: i32) -> [i32; 2] {
        let ToneMotion::Fixed { amplitude, nu_t } = self.motion else { return [0; 2] };
        let phases = (1..=ticks).map(|tick| tick_phase(f64::from(tick), gap_ticks as u32, nu_t));
        let word = |part: f64| libm::round(part * amplitude * ANGLE_UNITS) as i32;
        let cosines: f64 = phases.clone().map(libm::cos).sum();
        let sines: f64 = if ticks == gap_ticks { 0.0 } else { phases.map(libm::sin).sum() };
        [word(cosines), word(sines)]
    }
}

/// The place of a tick among the normal numbers of the Gaussian motion.
pub(crate) fn gaussian_place(tick: i32, gap_ticks: i32) -> usize {
    place(tick, gap_ticks as u32)
}

/// The rows as whole numbers: a triangle.
fn factor(rows: &TickRows, gap_ticks: u32, sides: usize, lsb_arcsec: f64) -> Vec<Vec<i32>> {
    let word = |x: f64| libm::round(x / lsb_arcsec * SIGMA_UNITS) as i32;
    let row = |(place, tick): (usize, i32)| {
        let mut row: Vec<i32> = rows.tick(tick).iter().copied().map(word).collect();
        row.resize(place + 1, 0);
        row
    };
    ticks(gap_ticks, sides).enumerate().map(row).collect()
}

/// A word of ones where a property is set, else of zeros.
pub(crate) fn mask(is_set: bool) -> u32 {
    if is_set { u32::MAX } else { 0 }
}

/// The two words of a 64-bit constant.
pub(crate) fn long_words(x: i64) -> [u32; 2] {
    [x as u32, (x >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Gaussian;
    use sagnac_theory::minimum_variance::Band;

    #[test]
    fn the_rows_of_gaussian_motion_times_each_other_are_the_covariance() {
        let lsb = libm::exp2(-16.0);
        for (band, gap_ticks, sides) in [([18.0, 22.0], 3, 8), ([1.0, 60.0], 2, 4), ([20.0, 20.0], 1, 3)] {
            let [low_hz, high_hz] = band;
            let motion = Gaussian::Band { rms: 12_000.0, band: Band { low_hz, high_hz } };
            let factor = factor(&motion.tick_rows(0.005, gap_ticks, sides), gap_ticks, sides, lsb);
            let (structure, scale) = motion.structure(0.005, 64);
            let all: Vec<i32> = ticks(gap_ticks, sides).collect();
            let unit = lsb / SIGMA_UNITS;
            for (i, j) in (0..all.len()).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let product: f64 =
                    factor[i].iter().zip(&factor[j]).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum();
                // The covariance of differences of angles is the second difference of their structure.
                let lag = all[i].abs_diff(all[j]) as usize;
                let second =
                    structure[lag + 1] + structure[lag.abs_diff(1)] - structure[lag] - structure[lag];
                let (found, expected) = (product * unit * unit, second.value() * scale);
                // Each word is rounded by half its unit.
                let tolerance = unit * 60.0 * libm::sqrt((i + 1) as f64);
                assert!((found - expected).abs() < tolerance, "{band:?}, {i}, {j}: {found}, not {expected}");
            }
        }
    }
}
