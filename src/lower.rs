//! Lowering: a point of a study becomes the fixed-point parameters of its kernel, with a proof that they fit.
//!
//! Everything here is f64 through `libm`, in a fixed order, so that the words are the same on every machine. The
//! oracle of each estimate is taken from the *lowered* parameters: it is exact for what is sampled.

use core::f64::consts::PI;

use crate::id::Id;
use crate::kernel::gap_fill::{self, Launch, MAX_FILLERS, Parameters, Shape};
use crate::kernel::moments::{LIMIT, level};
use crate::kernel::normal::REACH;
use crate::store::Address;
use crate::study::{Filler, Inputs, Phase, Point, Streams, round_12};
use crate::table::significant;
use crate::theory::gap::{Weights, polynomial_weights, sine_response, tick_amplitude, tick_phase};

/// Why a point cannot be sampled. Each message names the parameter to change.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LowerError {
    #[error("gyro.tick_noise: {} ″ of noise per tick {lost}", significant(*sigma_arcsec, 6))]
    NoiseTooSmall { sigma_arcsec: f64, lost: Lost },
    #[error("motion.amplitude: {} ″ of motion per tick {lost}", significant(*tick_arcsec, 6))]
    MotionTooSmall { tick_arcsec: f64, lost: Lost },
    #[error("switching.fillers: `{filler}` does not determine its polynomial from ticks {ticks:?}")]
    Singular { filler: &'static str, ticks: Vec<i32> },
    #[error(
        "switching.fillers: the weighted sum of the {error} of `{filler}` reaches 2^{bits:.0}, more than its 64-bit sum can hold"
    )]
    TooLarge { filler: &'static str, error: &'static str, bits: f64 },
}

/// Why a quantity has too few units in the fixed point of a tick.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Lost {
    /// The other quantity is so large that it takes all 32 bits.
    #[error("are lost beside a motion of {} ″ per tick in 32-bit arithmetic", significant(*tick_arcsec, 6))]
    BesideMotion { tick_arcsec: f64 },
    #[error("are lost beside a noise of {} ″ per tick in 32-bit arithmetic", significant(*sigma_arcsec, 6))]
    BesideNoise { sigma_arcsec: f64 },
    /// There is no finer unit.
    #[error("are too few units of 2^-24 ″, the finest unit of angle")]
    BelowFinest,
}

/// Which error of a filler: after the gap is closed, or while it is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error {
    Residual,
    Extrapolation,
}

impl Error {
    pub const ALL: [Error; 2] = [Error::Residual, Error::Extrapolation];

    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Error::Residual => "residual",
            Error::Extrapolation => "extrapolation",
        }
    }
}

/// The exact values of an estimate for the lowered parameters, in ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oracle {
    pub rms: f64,
    /// Largest error of the motion alone.
    pub max: f64,
    /// No sampled rms is farther from `rms` than this for rounding in the kernel.
    pub rounding: f64,
}

/// One estimate of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    pub error: Error,
    pub address: Address,
    pub oracle: Oracle,
    /// ″ per unit of the tally.
    pub unit_arcsec: f64,
    /// Where its histogram starts.
    pub bin_base: u32,
    weights: Weights,
    /// Bits that its sum is rounded by.
    shift: u32,
}

/// A point, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Lowered {
    pub id: Id,
    key: [u32; 2],
    tone: Tone,
    /// Residual and extrapolation of each filler.
    pub fillers: Vec<[Estimate; 2]>,
}

/// The sampled quantities in fixed point.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tone {
    gap_ticks: u32,
    nu_t: f64,
    /// Angle of a tick at the peak of the rate, in LSB.
    amplitude: f64,
    phase: u32,
    phase_spread: u32,
    sigma: u32,
}

/// Units of the kernel's parameters per LSB.
const ANGLE_UNITS: f64 = 4.0;
const SIGMA_UNITS: f64 = 16.0;

/// Fewest units of σ: it is then rounded by at most 1 %.
const LEAST_SIGMA: f64 = 50.0;

/// Fewest units of the peak angle of a tick: it is then rounded by less than 0.1 %. Motion without noise has more even
/// where the longest gap leaves the least room.
const LEAST_MOTION: f64 = 512.0;

/// Headroom kept for fillers other than the three polynomials on their default ticks.
const RESERVE: f64 = 4.0;

/// Finest LSB is 2^−24 ″, coarsest 2^24 ″.
const FINEST: i32 = 24;

impl LowerError {
    /// The key of the study that has to change.
    pub fn key(&self) -> &'static str {
        match self {
            LowerError::NoiseTooSmall { .. } => "gyro.tick_noise",
            LowerError::MotionTooSmall { .. } => "motion.amplitude",
            LowerError::Singular { .. } | LowerError::TooLarge { .. } => "switching.fillers",
        }
    }

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            LowerError::NoiseTooSmall { .. } => "make the noise larger, or 0",
            LowerError::MotionTooSmall { lost: Lost::BelowFinest, .. } => "make the motion larger, or 0",
            LowerError::MotionTooSmall { .. } => {
                "make the motion larger, or 0; or the noise smaller, or the gap shorter"
            }
            LowerError::Singular { .. } => "give it more ticks, or a lower order",
            LowerError::TooLarge { .. } => {
                "leave the filler out, move its ticks nearer to the gap, or shorten the gap"
            }
        }
    }
}

impl Lowered {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The point cannot be represented: see [`LowerError`].
    pub fn new(
        point: &Point,
        fillers: &[Filler],
        seed: u64,
        streams: Streams,
    ) -> Result<Lowered, LowerError> {
        let inputs = canonical(&point.inputs);
        let id = point_id(&inputs, seed, streams);
        let key = match streams {
            Streams::Independent => id.key(),
            Streams::Common => Id::of(&format!("streams\nkind=gap-fill\nseed={seed}\n")).key(),
        };
        let Physical { tick_arcsec, sigma_arcsec, nu_t, gap_ticks, phase } = inputs;
        let lsb_arcsec = lsb(&inputs);
        let (phase, phase_spread) = match phase {
            Phase::Uniform => (0, u32::MAX),
            Phase::ZeroCrossing => (0, 0),
            Phase::Extremum => (1 << 30, 0),
        };
        let finest = lsb_arcsec == libm::exp2(-f64::from(FINEST));
        let sigma = libm::round(sigma_arcsec / lsb_arcsec * SIGMA_UNITS);
        if sigma_arcsec > 0.0 && sigma < LEAST_SIGMA {
            let tick_arcsec = tick_arcsec.abs();
            let lost = if finest { Lost::BelowFinest } else { Lost::BesideMotion { tick_arcsec } };
            return Err(LowerError::NoiseTooSmall { sigma_arcsec, lost });
        }
        let sigma = sigma as u32;
        let amplitude = tick_arcsec / lsb_arcsec;
        if amplitude != 0.0 && amplitude.abs() * ANGLE_UNITS < LEAST_MOTION {
            let tick_arcsec = tick_arcsec.abs();
            let lost = if finest { Lost::BelowFinest } else { Lost::BesideNoise { sigma_arcsec } };
            return Err(LowerError::MotionTooSmall { tick_arcsec, lost });
        }
        let tone = Tone { gap_ticks, nu_t, amplitude, phase, phase_spread, sigma };
        let fillers = fillers
            .iter()
            .map(|&filler| {
                let lower = |error, ticks: &[i32]| {
                    let singular = || LowerError::Singular { filler: filler.name(), ticks: ticks.to_vec() };
                    let weights =
                        polynomial_weights(ticks, filler.order(), gap_ticks).ok_or_else(singular)?;
                    tone.estimate(id, key, lsb_arcsec, filler, error, weights)
                };
                Ok([
                    lower(Error::Residual, &point.fit_ticks)?,
                    lower(Error::Extrapolation, &point.extrapolation_ticks)?,
                ])
            })
            .collect::<Result<Vec<_>, LowerError>>()?;
        Ok(Lowered { id, key, tone, fillers })
    }

    /// The launch that samples some of the fillers, at most [`MAX_FILLERS`]; its estimates are their residuals, then
    /// their extrapolations.
    pub fn launch(&self, fillers: &[usize]) -> Launch {
        debug_assert!(fillers.len() <= MAX_FILLERS);
        let estimates = |error: usize| fillers.iter().map(move |&filler| &self.fillers[filler][error]);
        let n = self.tone.gap_ticks as i32;
        let side = |estimate: &Estimate| {
            let before = estimate.weights.ticks.iter().map(|&tick| 1 - tick).max().unwrap_or(0).max(0);
            let after = estimate.weights.ticks.iter().map(|&tick| tick - n).max().unwrap_or(0).max(0);
            (before as usize, after as usize)
        };
        let residual_before = estimates(0).map(|e| side(e).0).max().unwrap_or(0);
        let extrapolation_before = estimates(1).map(|e| side(e).0).max().unwrap_or(0);
        let shape = Shape {
            before: residual_before.max(extrapolation_before),
            after: estimates(0).map(|e| side(e).1).max().unwrap_or(0),
            residual_before,
            extrapolation_before,
            fillers: fillers.len(),
            wide: [0, 1].into_iter().flat_map(estimates).any(|estimate| estimate.shift > 0),
        };
        let before: Vec<i32> = (0..shape.before as i32).map(|k| -k).collect();
        let after: Vec<i32> = (1..=shape.after as i32).map(|k| n + k).collect();
        let (side_sin, side_cos): (Vec<u32>, Vec<u32>) = (1..=shape.sides() as i32)
            .map(|k| self.tone.tick_words(n + k))
            .map(|[sin, cos]| (sin as u32, cos as u32))
            .unzip();
        let weights = |error: usize, ticks: &[i32]| -> Vec<u32> {
            estimates(error).flat_map(|e| ticks.iter().map(|&tick| e.weight(tick) as u32)).collect()
        };
        let scales =
            |error: usize| -> Vec<u32> { estimates(error).map(|e| e.weights.denominator as u32).collect() };
        let residual_ticks = [&before[..residual_before], &after[..]].concat();
        let bin_base: Vec<u32> = [0, 1].into_iter().flat_map(estimates).map(|e| e.bin_base).collect();
        let shift: Vec<u32> = [0, 1].into_iter().flat_map(estimates).map(|e| e.shift).collect();
        let words = Parameters {
            key: &self.key,
            phase: &[self.tone.phase],
            phase_spread: &[self.tone.phase_spread],
            sigma: &[self.tone.sigma],
            gap_sin: &[self.tone.gap_words()[0] as u32],
            side_sin: &side_sin,
            side_cos: &side_cos,
            residual_weight: &weights(0, &residual_ticks),
            residual_scale: &scales(0),
            extrapolation_weight: &weights(1, &before[..extrapolation_before]),
            extrapolation_scale: &scales(1),
            shift: if shape.wide { &shift } else { &[] },
            bin_base: &bin_base,
        }
        .words();
        Launch { shape, words }
    }
}

impl Estimate {
    fn weight(&self, tick: i32) -> i32 {
        let place = self.weights.ticks.iter().position(|&own| own == tick);
        place.map_or(0, |k| self.weights.numerators[k] as i32)
    }
}

impl Tone {
    /// The angle of a tick at sine 1 and at cosine 1 of the phase at the middle of the gap.
    fn tick_words(&self, tick: i32) -> [i32; 2] {
        let phase = tick_phase(f64::from(tick), self.gap_ticks, self.nu_t);
        self.words(libm::cos(phase), libm::sin(phase))
    }

    /// The same of the whole gap, whose parts at cosine 1 cancel.
    fn gap_words(&self) -> [i32; 2] {
        let phases = (1..=self.gap_ticks).map(|tick| tick_phase(f64::from(tick), self.gap_ticks, self.nu_t));
        self.words(phases.map(libm::cos).sum(), 0.0)
    }

    fn words(&self, sin: f64, cos: f64) -> [i32; 2] {
        [sin, cos].map(|part| libm::round(part * self.amplitude * ANGLE_UNITS) as i32)
    }

    /// Lowers one estimate: proves that it fits, and finds what it comes to exactly.
    fn estimate(
        &self,
        point: Id,
        key: [u32; 2],
        lsb_arcsec: f64,
        filler: Filler,
        error: Error,
        weights: Weights,
    ) -> Result<Estimate, LowerError> {
        let weights = in_32_bits(weights);
        let scale = weights.denominator as f64;
        let ticks: Vec<[i32; 2]> = weights.ticks.iter().map(|&tick| self.tick_words(tick)).collect();
        let gap = self.gap_words();
        // D·δP = a sin φ + b cos φ + noise, in LSB.
        let part = |i: usize| {
            let filled: f64 =
                weights.numerators.iter().zip(&ticks).map(|(&w, tick)| w as f64 * f64::from(tick[i])).sum();
            (filled - scale * f64::from(gap[i])) / ANGLE_UNITS
        };
        let (a, b) = (part(0), part(1));
        let sigma = f64::from(self.sigma) / SIGMA_UNITS;
        let gain = weights.largest_gain() * scale;
        let noise = sigma * weights.noise_gain() * scale;
        // The terms of the sum one by one: what its accumulator must hold on the way.
        let size = |words: &[i32; 2]| (f64::from(words[0]).abs() + f64::from(words[1]).abs()) / ANGLE_UNITS;
        let motion: f64 =
            weights.numerators.iter().zip(&ticks).map(|(&w, tick)| w.abs() as f64 * size(tick)).sum::<f64>()
                + scale * size(&gap);
        let terms = motion + (REACH * sigma + 1.0) * gain + scale;
        // Below 2^59 the shift stays below 32, which `bits_from` asks for.
        if terms >= libm::exp2(59.0) {
            let (filler, error, bits) = (filler.name(), error.name(), libm::log2(terms));
            return Err(LowerError::TooLarge { filler, error, bits });
        }
        // Each tick and the gap is rounded once, by half an LSB at most; the sine is wrong by 2^−29.5 at most.
        let rounding = 0.5 * (gain + scale) + libm::exp2(-29.5) * motion;
        let bound = libm::hypot(a, b) + REACH * sigma * gain + rounding;
        let shift = libm::ceil(libm::log2((bound + 1.0) / (LIMIT as f64 - 1.0))).max(0.0);
        let (shift, unit) = (shift as u32, libm::exp2(shift));
        // From here on in units of the tally.
        let [a, b, noise, rounding] = [a, b, noise, rounding].map(|x| x / unit);
        let rounding = if shift > 0 { rounding + 0.5 } else { rounding };
        let unit_arcsec = lsb_arcsec / scale * unit;
        let (mean_square, max) = if self.phase_spread != 0 {
            (0.5 * (a * a + b * b), libm::hypot(a, b))
        } else {
            let phase = f64::from(self.phase) / libm::exp2(32.0) * 2.0 * PI;
            let fixed = a * libm::sin(phase) + b * libm::cos(phase);
            (fixed * fixed, fixed.abs())
        };
        let rms = libm::sqrt(mean_square + noise * noise);
        let oracle =
            Oracle { rms: rms * unit_arcsec, max: max * unit_arcsec, rounding: rounding * unit_arcsec };
        let bin_base = level(libm::floor(0.25 * rms) as u32);
        let head = [gap_fill::VERSION, key[0], key[1], self.phase, self.phase_spread, self.sigma];
        let words = head
            .into_iter()
            .chain(gap.map(|word| word as u32))
            .chain(ticks.iter().flatten().map(|&word| word as u32))
            .chain(weights.ticks.iter().map(|&tick| tick as u32))
            .chain(weights.numerators.iter().map(|&w| w as u32))
            .chain([weights.denominator as u32, shift, bin_base])
            .chain(words_of(unit_arcsec));
        let address = Address {
            point,
            estimate: estimate_id(filler, error, &weights.ticks),
            digest: Id::of_words(words),
        };
        Ok(Estimate { error, address, oracle, unit_arcsec, bin_base, weights, shift })
    }
}

/// The weights themselves where they fit in 32 bits, else the nearest that do.
fn in_32_bits(weights: Weights) -> Weights {
    let largest = weights.numerators.iter().map(|w| w.abs()).max().unwrap_or(0).max(weights.denominator);
    if largest < 1 << 30 {
        return weights;
    }
    let largest = weights.values().fold(1.0, |largest: f64, w| largest.max(w.abs()));
    weights.fixed_point(libm::floor(30.0 - libm::log2(largest)).clamp(1.0, 24.0) as u32)
}

fn words_of(x: f64) -> [u32; 2] {
    [x.to_bits() as u32, (x.to_bits() >> 32) as u32]
}

/// What a point's draws and truth depend on, each to 12 significant digits.
#[derive(Debug, Clone, Copy)]
struct Physical {
    /// Angle of a tick with the peak of the rate at its middle, negative where sinc(νT) is.
    tick_arcsec: f64,
    sigma_arcsec: f64,
    nu_t: f64,
    gap_ticks: u32,
    phase: Phase,
}

/// The inputs by what they come to: a motion given as a rate or as an angle is the same motion.
fn canonical(inputs: &Inputs) -> Physical {
    let (tick_s, frequency_hz) = (round_12(inputs.tick_s), round_12(inputs.frequency_hz));
    let nu_t = round_12(tick_s * frequency_hz);
    Physical {
        tick_arcsec: round_12(round_12(inputs.rate_amplitude()) * tick_amplitude(tick_s, nu_t)),
        sigma_arcsec: round_12(inputs.sigma_arcsec()),
        nu_t,
        gap_ticks: inputs.gap_ticks,
        phase: inputs.phase,
    }
}

fn point_id(inputs: &Physical, seed: u64, streams: Streams) -> Id {
    let Physical { tick_arcsec, sigma_arcsec, nu_t, gap_ticks, phase } = inputs;
    Id::of(&format!(
        "point\nkind=gap-fill\nseed={seed}\nstreams={}\n\
         gap_ticks={gap_ticks}\nnu_t={nu_t:.11e}\nphase={}\nsigma_arcsec={sigma_arcsec:.11e}\ntick_arcsec={tick_arcsec:.11e}\n",
        streams.name(),
        phase.name(),
    ))
}

fn estimate_id(filler: Filler, error: Error, ticks: &[i32]) -> Id {
    Id::of(&format!(
        "estimate\nfiller=polynomial\norder={}\nerror={}\nticks={ticks:?}\n",
        filler.order(),
        error.name()
    ))
}

/// The unit of angle, a power of two of an arcsecond, from the physical inputs alone: the worst error of the three
/// polynomials on their default ticks leaves a factor [`RESERVE`] to the limit.
fn lsb(inputs: &Physical) -> f64 {
    let &Physical { tick_arcsec, sigma_arcsec, nu_t, gap_ticks, .. } = inputs;
    let n = gap_ticks as i32;
    let tick_arcsec = tick_arcsec.abs();
    let mut worst = f64::from(gap_ticks + 1) * (tick_arcsec + REACH * sigma_arcsec);
    for order in 0..3 {
        for ticks in [[-1, 0, n + 1, n + 2], [-3, -2, -1, 0]] {
            // Four ticks always determine a quadratic.
            let Some(weights) = polynomial_weights(&ticks, order, gap_ticks) else { continue };
            let (a, b) = sine_response(&weights, gap_ticks, nu_t);
            let error = tick_arcsec * libm::hypot(a, b) + REACH * sigma_arcsec * weights.largest_gain();
            worst = worst.max(error * weights.denominator as f64);
        }
    }
    let bits = libm::floor(libm::log2(LIMIT as f64 / (RESERVE * worst)));
    libm::exp2(-bits.clamp(-f64::from(FINEST), f64::from(FINEST)))
}
