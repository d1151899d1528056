//! The sampled quantities of a point in fixed point: the words of the kernel before they are arranged.

use core::cell::{OnceCell, RefCell};
use core::ops::RangeInclusive;
use std::rc::Rc;
use std::sync::{Arc, OnceLock};

use crate::filler::read::Error;
use crate::filler::{Filler, Method, Target};
use crate::key::{Unrepresentable, shown};
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::lower::physical::{Physical, PhysicalTone, Rounded, ToneKind};
use crate::kinds::gap_fill::lower::physical_theory::Boundaries;
use crate::kinds::gap_fill::lower::readout::Functional;
use crate::motion::keys::Phase;
use crate::motion::{Gaussian, Value};
use sagnac_base::quantity::number::significant;
use sagnac_kernel::moments::LIMIT;
use sagnac_kernel::normal::{REACH, SIGMA};
use sagnac_kernel::sine::ONE;
use sagnac_theory::gap::{Weights, greatest_common_divisor, polynomial_weights, tick_phase};
use sagnac_theory::minimum_variance::{TickRows, minimum_variance_weights, place, sides, ticks};
use sagnac_theory::quadrature::Memo;

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
            rounded: Rounded::new(&profile.replay, lsb_arcsec),
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

/// Fewest units of 2^−4 LSB of σ, which is then rounded by at most 1 %.
const MIN_SIGMA: f64 = 50.0;

/// Units of 2^−4 LSB of σ from which on its rounding, by 0.1 %, is far below what trials resolve. Where there are fewer, a
/// finer unit is taken as far as ticks and their words allow it, and larger errors are shifted.
const ENOUGH_SIGMA: f64 = 500.0;

/// Bound of the angle over the gap with all that is added to it, LSB, for which every word fits.
const MAX_ANGLE: f64 = (1_u32 << 27) as f64;

/// Fewest LSB of the peak angle of a tick, whose words are then rounded by less than 0.1 %. Motion without noise has
/// more, even where the longest gap leaves the least room.
const MIN_MOTION: f64 = 128.0;

/// Headroom kept for fillers other than the three polynomials on their default ticks.
const RESERVE: f64 = 4.0;

/// log2 of the finest unit of 2^−24 ″ and of the coarsest of 2^24 ″.
const FINEST: i32 = 24;

/// Ticks on either side that the default fillers reach.
pub(crate) const DEFAULT_SIDES: usize = 4;

/// The weights of the three polynomials on their default ticks. They take long to compute, and points share them.
fn polynomials(gap_ticks: u32) -> Arc<[Weights]> {
    static KNOWN: Memo<u32, Arc<[Weights]>> = Memo::new(64);
    let n = gap_ticks as i32;
    let on_ticks = move |order| {
        let ticks = [[-1, 0, n + 1, n + 2], [-3, -2, -1, 0]].into_iter();
        // Four ticks always determine a quadratic.
        ticks.filter_map(move |ticks| polynomial_weights(&ticks, order, gap_ticks))
    };
    KNOWN.get(gap_ticks, || (0..3).flat_map(on_ticks).collect())
}

/// The unit of angle, ″, at which the worst error of the three polynomials on their default ticks leaves a factor
/// [`RESERVE`] to the limit. It is a power of two, or with whole pulses a pulse divided by a power of two.
///
/// # Errors
/// Noise, motion or pulses have too few units.
pub(crate) fn lsb(physical: &Physical) -> Result<f64, Unrepresentable> {
    let sizes = physical.tick_sizes();
    let whole = sizes.iter().map(|(_, size)| size).sum::<f64>()
        + physical.constant_size()
        + REACH * physical.sigma_arcsec
        + physical.readout_lsb;
    let n = physical.gap_ticks as i32;
    let mut worst = f64::from(n + 1) * whole;
    if whole > 0.0 {
        // A provisional unit, in which all words certainly fit.
        let provisional = worst / libm::exp2(26.0);
        let fixed = Fixed::new(physical, provisional, DEFAULT_SIDES);
        for Weights { ticks, numerators: weights, denominator: scale } in
            polynomials(physical.gap_ticks).iter()
        {
            let functional = Functional { ticks, weights, scale: *scale, gap: n };
            let noise = (REACH * physical.sigma_arcsec + physical.readout_lsb) * functional.gain();
            worst = worst.max(fixed.response(&functional).bound * provisional + noise);
        }
    }
    let mut bits = libm::floor(libm::log2(LIMIT as f64 / (RESERVE * worst)));
    let sigma_units = physical.sigma_arcsec * SIGMA_UNITS;
    if sigma_units > 0.0 && sigma_units * libm::exp2(bits) < ENOUGH_SIGMA {
        let wanted = libm::ceil(libm::log2(ENOUGH_SIGMA / sigma_units));
        let most = libm::floor(libm::log2(MAX_ANGLE / (f64::from(n + 1) * whole)));
        bits = wanted.min(most).max(bits);
    }
    let mut lsb = libm::exp2(-bits.clamp(-f64::from(FINEST), f64::from(FINEST)));
    if physical.readout_lsb > 0.0 {
        let steps = libm::floor(libm::log2(physical.readout_lsb / lsb));
        if steps < 0.0 {
            let (readout_lsb, unit_arcsec) = (physical.readout_lsb, lsb);
            let found = format!(
                "a pulse of {}″ is less than a unit of {}″ of the 32-bit arithmetic that this motion leaves",
                shown(readout_lsb),
                significant(unit_arcsec, 3)
            );
            let help = "leave readout_lsb out: pulses as fine as this have no effect";
            return Err(Unrepresentable::new("gyro.readout_lsb", found, help));
        }
        lsb = physical.readout_lsb / libm::exp2(steps.min(f64::from(FINEST)));
    }
    let finest = lsb <= libm::exp2(-f64::from(FINEST));
    let lost = match finest {
        true => "are too few units of 2^-24″, the finest unit of angle".to_owned(),
        false => format!(
            "are lost beside motion and noise of up to {}″ per tick in 32-bit arithmetic",
            shown(whole)
        ),
    };
    let sigma_arcsec = physical.sigma_arcsec;
    if sigma_arcsec > 0.0 && libm::round(sigma_arcsec / lsb * SIGMA_UNITS) < MIN_SIGMA {
        let found = format!("{}″ of noise per tick {lost}", shown(sigma_arcsec));
        return Err(Unrepresentable::new("gyro.tick_noise", found, "make the noise larger, or 0"));
    }
    for (key, tick_arcsec) in sizes {
        if tick_arcsec > 0.0 && tick_arcsec / lsb < MIN_MOTION {
            let help = match finest {
                true => "make the motion larger, or 0",
                false => "make the motion larger, or 0; or the noise smaller, or the gap shorter",
            };
            let found = format!("{}″ of motion per tick {lost}", shown(tick_arcsec));
            return Err(Unrepresentable::new(key, found, help));
        }
    }
    Ok(lsb)
}

/// Weights on some ticks over a common denominator: one row for the whole gap, one row for each of its ticks, or for
/// errors in the gap one row for each number of its first ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Numbers of the ticks; 0 is the last before the gap.
    pub ticks: Vec<i32>,
    /// Numerators, by row and tick.
    pub numerators: Vec<Vec<i64>>,
    /// Common denominator D, positive.
    pub denominator: i64,
    /// Whether the fractions are the exact weights instead of the nearest ones over a power of two.
    pub exact: bool,
    /// The sum over the ends of the ticks that the error is, made at the first use.
    pub(crate) boundaries: OnceLock<Boundaries>,
}

/// What exact weights depend on: the length of the gap, the ticks that are read, the identity of the filler, and whether
/// there is a row for each number of the first ticks of the gap.
type Asked = (u32, Vec<i32>, &'static str, bool);

/// Exact weights; none where the ticks do not determine them.
static EXACT: Memo<Asked, Option<Arc<Rows>>> = Memo::new(128);

/// The refusal of motion without noise that is determined by fewer ticks than the filler reads, so that many weights
/// would be equally good.
pub(crate) fn singular_covariance(filler: &str, sigma_arcsec: f64) -> Unrepresentable {
    let found = format!(
        "the covariance of the ticks of `{filler}` is singular, a noise of {}″ is too small beside the motion to choose weights by",
        shown(sigma_arcsec)
    );
    let help = "give the noise that the gyro really has, fewer fit ticks, or a wider band to design for";
    Unrepresentable::new("gyro.tick_noise", found, help)
}

impl Rows {
    /// The weights of a filler on `ticks` for one of its errors; `None` where the filler does not have that error.
    ///
    /// # Errors
    /// The ticks do not determine the weights.
    pub fn new(
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Unrepresentable> {
        let n = statistics.inputs.gap_ticks;
        let lengths = if error == Error::InGap { 1..=n } else { n..=n };
        Rows::over(lengths, filler, error, ticks, statistics)
    }

    /// Gives weights that equal these, and that points share where they are exact.
    ///
    /// # Errors
    /// The ticks do not determine the weights.
    pub(crate) fn shared(
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Arc<Rows>>, Unrepresentable> {
        let compute = || Rows::new(filler, error, ticks, statistics).map(|rows| rows.map(Arc::new));
        let Method::Closed(closed) = &filler.method else { return compute() };
        // What differs most comes first, as it is compared with that of all known ones.
        let key = (statistics.inputs.gap_ticks, ticks.to_vec(), closed.identity, error == Error::InGap);
        match EXACT.get(key, || compute().ok().flatten()) {
            // The refusal names the filler.
            None => compute(),
            known => Ok(known),
        }
    }

    /// The weights of a filler for each single tick of the gap, as firmware needs them: those that interpolate the tick
    /// for the residual, else those that extrapolate to it. Over the gap they sum to the weights of the error, up to
    /// rounding where they are not small fractions. `None` where the filler defines nothing for single ticks.
    ///
    /// # Errors
    /// The ticks do not determine the weights.
    pub fn by_tick(
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Unrepresentable> {
        let Some(mut rows) = Rows::over(1..=statistics.inputs.gap_ticks, filler, error, ticks, statistics)?
        else {
            return Ok(None);
        };
        // From the end, so that the previous row still belongs to a length.
        for j in (1..rows.numerators.len()).rev() {
            let (before, from) = rows.numerators.split_at_mut(j);
            from[0].iter_mut().zip(&before[j - 1]).for_each(|(w, shorter)| *w -= shorter);
        }
        Ok(Some(rows))
    }

    /// The weights over the first ticks of the gap, for each of the given numbers of ticks.
    fn over(
        lengths: RangeInclusive<u32>,
        filler: &Filler,
        error: Error,
        ticks: &[i32],
        statistics: &Statistics,
    ) -> Result<Option<Rows>, Unrepresentable> {
        match &filler.method {
            Method::Closed(closed) => {
                let rows = lengths.map(|length| (closed.weights)(ticks, length));
                let singular = || {
                    let found =
                        format!("`{}` does not determine its polynomial from ticks {ticks:?}", filler.name);
                    Unrepresentable::new("switching.fillers", found, "give it more ticks, or a lower order")
                };
                let rows = rows.collect::<Option<Vec<Weights>>>().ok_or_else(singular)?;
                Ok(Some(exact(ticks, rows)))
            }
            Method::MinimumVariance(target) => {
                let motion = statistics.motion(target, sides(ticks, statistics.inputs.gap_ticks));
                let noise = statistics.inputs.noise_covariance();
                let rows = lengths
                    .map(|length| {
                        let weights = minimum_variance_weights(ticks, length, &motion, &noise);
                        let singular = || singular_covariance(&filler.name, statistics.inputs.sigma_arcsec());
                        let bounded = |w: &Vec<f64>| w.iter().all(|w| w.abs() < MAX_WEIGHT);
                        Ok((length, weights.filter(bounded).ok_or_else(singular)?))
                    })
                    .collect::<Result<Vec<_>, Unrepresentable>>()?;
                Ok(Some(nearest(ticks, &rows)))
            }
            Method::Weights { residual, extrapolation } => {
                let weights = match error {
                    Error::Residual => Some(residual),
                    Error::Extrapolation | Error::InGap => extrapolation.as_ref(),
                };
                // Given weights do not define the first ticks of a gap.
                let n = statistics.inputs.gap_ticks;
                let weights = weights.filter(|_| *lengths.start() == n);
                Ok(weights.map(|weights| nearest(ticks, &[(n, weights.clone())])))
            }
        }
    }

    /// The weights as numbers, row by row.
    pub fn values(&self) -> Vec<Vec<f64>> {
        let value = |w: &i64| *w as f64 / self.denominator as f64;
        self.numerators.iter().map(|row| row.iter().map(value).collect()).collect()
    }
}

/// Bound of the weights of a designed filler, which leaves at least ten bits for their fractions.
const MAX_WEIGHT: f64 = (1 << 20) as f64;

/// Second-order statistics of a point, from which minimum-variance fillers are designed. Those of a long record are
/// expensive, so each is computed on first use, and again for another number of ticks on a side.
#[derive(Debug)]
pub struct Statistics<'a> {
    inputs: &'a Inputs,
    /// The ticks of its motion, or of its specification, with the number of ticks on either side.
    motion: RefCell<(usize, Rc<TickRows>)>,
    rate_rms: OnceCell<f64>,
}

impl<'a> Statistics<'a> {
    /// The statistics of a point with these inputs.
    pub fn new(inputs: &'a Inputs) -> Statistics<'a> {
        Statistics { inputs, motion: RefCell::default(), rate_rms: OnceCell::new() }
    }

    /// The ticks of the motion for which a filler is designed, with `sides` ticks on either side of the gap.
    pub fn motion(&self, target: &Target, sides: usize) -> Rc<TickRows> {
        let Inputs { tick_s, motion, gap_ticks, .. } = self.inputs;
        let motion = match target {
            Target::Band(band) => {
                // As much motion as in the study, spread over the band.
                let rms = *self.rate_rms.get_or_init(|| motion.rate_rms(*tick_s));
                return Gaussian::Band { rms, band: *band }.tick_rows(*tick_s, *gap_ticks, sides).into();
            }
            Target::Specification(specification) => &specification.motion(),
            Target::Own => motion,
        };
        let mut known = self.motion.borrow_mut();
        // Rows of a profile are means over more places where fillers read fewer ticks.
        if known.0 != sides {
            *known = (sides, motion.tick_rows(*tick_s, *gap_ticks, sides).into());
        }
        known.1.clone()
    }
}

/// Fractions over one denominator, where they fit in 32 bits, else the nearest ones that do.
fn exact(ticks: &[i32], rows: Vec<Weights>) -> Rows {
    let divisor = |a: i64, b: i64| greatest_common_divisor(a.into(), b.into()) as i64;
    let common = rows.iter().try_fold(1_i64, |common, row| {
        (common / divisor(common, row.denominator)).checked_mul(row.denominator)
    });
    let numerators = common.and_then(|denominator| {
        let scaled = |row: &Weights| -> Option<Vec<i64>> {
            let factor = denominator / row.denominator;
            row.numerators.iter().map(|w| w.checked_mul(factor)).collect()
        };
        let numerators = rows.iter().map(scaled).collect::<Option<Vec<_>>>()?;
        let largest = numerators.iter().flatten().map(|w| w.abs()).max().unwrap_or(0).max(denominator);
        (largest < 1 << 30).then_some(Rows {
            ticks: ticks.to_vec(),
            numerators,
            denominator,
            exact: true,
            boundaries: OnceLock::new(),
        })
    });
    numerators.unwrap_or_else(|| {
        let length = |row: &Weights| libm::round(row.values().sum()) as u32;
        nearest(ticks, &rows.iter().map(|row| (length(row), row.values().collect())).collect::<Vec<_>>())
    })
}

/// The nearest weights over one power of two, each row with the sum of its length.
fn nearest(ticks: &[i32], rows: &[(u32, Vec<f64>)]) -> Rows {
    let largest = rows.iter().flat_map(|(_, row)| row).fold(1.0, |largest: f64, w| largest.max(w.abs()));
    let bits = libm::floor(30.0 - libm::log2(largest)).clamp(1.0, 24.0) as u32;
    let nearest =
        |(length, row): &(u32, Vec<f64>)| Weights::nearest(ticks, row, i64::from(*length), bits).numerators;
    let numerators = rows.iter().map(nearest).collect();
    Rows {
        ticks: ticks.to_vec(),
        numerators,
        denominator: 1 << bits,
        exact: false,
        boundaries: OnceLock::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::read::Error;
    use crate::kinds::gap_fill::inputs::TickNoise;
    use crate::kinds::gap_fill::verify::{Configuration, minimum_variance};
    use crate::motion::keys::{Design, Interpolation, Position};
    use crate::motion::{Gaussian, Motion, Profile, Tone};
    use sagnac_records::record::Record;
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

    /// With the covariance of the record by lag the error was up to 8.7 times as large.
    #[test]
    fn a_filler_designed_from_a_record_is_nearly_as_good_as_one_that_knows_its_tones() {
        let (tick_s, n) = (0.002, 3);
        let tones: Vec<Tone> = (0..8).map(|k| Tone::of_rate(500.0, 61.3 + 7.9 * f64::from(k))).collect();
        let rate = |i: usize| {
            let turn = |(k, tone): (usize, &Tone)| {
                let phase = (k * k) as f64;
                500.0 * libm::sin(core::f64::consts::TAU * tone.band().low_hz * 0.0005 * i as f64 + phase)
            };
            tones.iter().enumerate().map(turn).sum()
        };
        let record = Record { step_s: 0.0005, rates: (0..12_000).map(rate).collect() };
        let profile = Profile {
            file: "eight tones".to_owned(),
            record: Arc::new(record),
            position: Position::Every,
            interpolation: Interpolation::BandLimited,
            design: Design::FirstHalf,
        };
        let recorded = Motion { profile: Some(profile), ..Motion::default() };
        let known = Motion { tones: tones.clone(), ..Motion::default() };
        for sides in [6, 12, 30] {
            let fit_ticks: Vec<i32> = (1 - sides..=0).chain(n + 1..=n + sides).collect();
            let errors = [&recorded, &known].map(|motion| {
                let configuration = Configuration::new("record", |own| {
                    own.inputs.tick_s = tick_s;
                    own.inputs.tick_noise = TickNoise::Std(1e-3);
                    own.inputs.motion = motion.clone();
                });
                let statistics = Statistics::new(&configuration.inputs);
                let rows = Rows::new(&minimum_variance(), Error::Residual, &fit_ticks, &statistics);
                let weights = rows.unwrap().unwrap().values().pop().unwrap();
                let rows = known.tick_rows(tick_s, n as u32, sides as usize);
                let noise: f64 = weights.iter().map(|w| w * w * 1e-6).sum();
                libm::sqrt(rows.error_variance(&fit_ticks, &weights, n as u32) + noise)
            });
            assert!(errors[0] < 1.1 * errors[1], "{sides} ticks: {} and {} arcsec", errors[0], errors[1]);
        }
    }
}
